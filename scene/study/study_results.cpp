// What follows from a study's runs: errors against the reference, settings for targets, slopes, the front.
#include <algorithm>
#include <limits>

#include "scene/study/study.h"

namespace obscura {
namespace {

bool reaches(const StudyRun& run, double target) { return run.error.error.value() + run.error.error.error() <= target; }

StudyTarget cheapest(const Study& study, double error) {
  StudyTarget target{error, -1, std::vector<int>(methods().size(), -1)};
  const auto cost = [&](int run) {
    return run < 0 ? std::numeric_limits<double>::infinity() : study.runs[static_cast<std::size_t>(run)].full.cpu();
  };
  for (std::size_t r = 0; r < study.runs.size(); ++r) {
    const StudyRun& run = study.runs[r];
    if (!reaches(run, error)) continue;
    const int index = static_cast<int>(r);
    int& own = target.per_method[index_of(*run.setting.method.type)];
    if (cost(index) < cost(own)) own = index;
    if (renders(run.setting.method.type) && cost(index) < cost(target.run)) target.run = index;
  }
  return target;
}

/// Error, noise and bias along a ladder against the CPU time of map and image. Points within two standard errors
/// of 0 say nothing.
void add_slopes(const Study& study, const MethodType* method, std::vector<StudySlope>& slopes) {
  const auto fit = [&](const char* what, const auto& part) {
    std::vector<double> x, y, errors;
    for (const StudyRun& run : study.runs) {
      if (run.setting.method.type != method || run.purpose != kLadder) continue;
      const RootError& root = part(run.error);
      if (root.square < 2 * root.square_error) continue;
      x.push_back(run.seconds.map.cpu + run.seconds.image.cpu);
      y.push_back(root.value());
      errors.push_back(root.error());
    }
    if (const auto law = fit_power_law(x, y, errors); law && law->points >= 3) slopes.push_back({method, what, *law});
  };
  fit("error", [](const PictureError& e) -> const RootError& { return e.error; });
  fit("noise", [](const PictureError& e) -> const RootError& { return e.noise; });
  fit("bias", [](const PictureError& e) -> const RootError& { return e.bias; });
}

std::vector<int> front_of(const Study& study) {
  std::vector<int> order;
  for (std::size_t r = 0; r < study.runs.size(); ++r) order.push_back(static_cast<int>(r));
  const auto at = [&](int r) -> const StudyRun& { return study.runs[static_cast<std::size_t>(r)]; };
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return at(a).full.cpu() < at(b).full.cpu(); });
  std::vector<int> front;
  double least = std::numeric_limits<double>::infinity();
  for (const int r : order) {
    const RootError& error = at(r).error.error;
    // Errors that the reference cannot tell from none would be on the front by luck.
    if (!(error.square > error.square_error) || !(error.value() < least)) continue;
    least = error.value();
    front.push_back(r);
  }
  return front;
}

}  // namespace

void evaluate(Study& study) {
  if (!study.reference.picture.known()) return;
  study.reference.error = reference_error(study.reference.picture);
  for (StudyRun& run : study.runs) run.error = picture_error(run.pictures, study.reference.picture);
  study.targets.clear();
  for (const double target : kStudyTargets) study.targets.push_back(cheapest(study, target));
  study.slopes.clear();
  for (const MethodType* method : methods()) add_slopes(study, method, study.slopes);
  study.front = front_of(study);
}

}  // namespace obscura
