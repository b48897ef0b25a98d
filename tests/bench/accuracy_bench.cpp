// Whether a target error is kept: ten scenes, each rendered to its target and compared with a referee's long run; the
// time of it beside that of the best fixed setting that a study has found; how often 95 % intervals of pixels hold the
// truth. Prints a table.
//   --only NAME   one scene     --budget S   seconds of each study (60)     --pixels N   longest side of the pictures
//   (48)
#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include "octree/base/error.h"
#include "scene/file/scene_io.h"
#include "scene/file/scene_table_io.h"
#include "scene/run/run.h"
#include "scene/study/study.h"
#include "scene/verify/verify.h"
#include "tests/support/places.h"

namespace obscura {
namespace {

struct Job {
  std::string name;
  std::string scene;  // text
  std::string folder = ".";
  std::vector<std::string> files = {};  // that have to be there
};

struct Options {
  std::string only;
  double budget = 60;
  int pixels = 48;
};

std::string shared(const char* file) { return test::shared_path(std::string("data/") + file); }

std::string verify_case(const char* name) {
  for (const VerifyCase& c : verify_cases()) {
    if (c.name == name) return c.scene;
  }
  throw InputError("--only", std::string("there is no case ") + name);
}

Job of_file(const std::string& name, const std::string& file, const std::string& rest) {
  Job job{name, "", ".", {file}};
  job.scene = R"({"obscura": 1, "clouds": [{"grid": {"file": ")" + file + "\"}, " + rest + "}";
  return job;
}

std::vector<Job> jobs() {
  const std::string rico = shared("les_rico_jpl/rico32x37x26.txt"),
                    cloud = shared("wdas_cloud_sixteenth/wdas_cloud_sixteenth.vdb"),
                    fire = shared("fds_steckler_room_fire/vdb/steckler.t050.vdb");
  const std::string above =
      R"("sensor": {"position_m": [300, -1500, 4000], "look_at_m": [320, 370, 900], "fov_deg": 40, "resolution": [320, 240]}, )";
  const std::string daylight =
      R"("environment": {"sky": {"radiance": 60}, "sun": {"zenith_deg": 30, "azimuth_deg": 200, "irradiance": 1500}}, )";
  std::vector<Job> all;
  all.push_back({"demo", detail::read_text(test::source_file("scene/examples/smoke_at_night.json")),
                 test::source_file("scene/examples")});
  all.push_back(of_file(
      "les_rico_jpl by day", rico,
      R"("media": [{"density": "lwc", "extinction": 0.1, "albedo": 0.9999, "phase": {"type": "henyey_greenstein", "g": 0.85}}],
                           "periodic": ["x", "y"], "period_m": [640, 740]}], "bands": [{"name": "vis", "um": [0.6, 0.7]}], )" +
          daylight + above + R"("render": {})"));
  all.push_back(of_file(
      "les_rico_jpl, absorption alone", rico,
      R"("media": [{"density": "lwc", "extinction": 0.1}], "temperature": {"K": 283}}], "bands": [{"name": "lwir", "um": [8, 12]}],
                           "environment": {"sky": {"K": 230}}, )" +
          above + R"("render": {})"));
  all.push_back(of_file(
      "wdas cloud by day", cloud,
      R"("media": [{"extinction": 0.02, "albedo": 0.999, "phase": {"type": "henyey_greenstein", "g": 0.8}}],
                           "place": {"rotate_deg": [90, 0, 0]}}], "bands": [{"name": "vis", "um": [0.5, 0.6]}], )" +
          daylight +
          R"("sensor": {"position_m": [0, -1100, 0], "look_at_m": [0, 0, 60], "fov_deg": 35, "resolution": [320, 240]}, "render": {})"));
  all.push_back(
      of_file("Steckler room fire", fire,
              R"("media": [{"density": "co2_density", "extinction": 80}], "temperature": {"grid": "temperature"}}],
                           "bands": [{"name": "mwir", "um": [3, 5]}], "environment": {"sky": {"K": 290}},
                           "sensor": {"position_m": [1.8, -6, 1.2], "look_at_m": [1.8, 0, 1.0], "fov_deg": 40, "resolution": [320, 240]}, "render": {})"));
  for (const char* name : {"sphere_day", "slab_day", "gaussian_night", "puffs_day", "checkerboard_day"})
    all.push_back({name, verify_case(name)});
  return all;
}

/// Share of the pixels that have an error whose 95 % interval, bias and the reference's own doubt included, holds the
/// reference.
double inside(const Image& image, const ReferencePicture& reference, const std::vector<BandDescription>& bands) {
  double held = 0, pixels = 0;
  for (std::size_t b = 0; b < bands.size(); ++b) {
    const auto radiance = image.channel(bands[b].name + ".radiance"), error = image.channel(bands[b].name + ".error");
    const std::string biased = bands[b].name + ".bias";
    for (std::size_t p = 0; p < radiance.size(); ++p) {
      if (!(error[p] > 1e-5f * std::abs(radiance[p]))) continue;
      const double doubt = std::sqrt(error[p] * static_cast<double>(error[p]) + reference.variance(b, p));
      const double off = std::abs(static_cast<double>(radiance[p]) - reference.values().bands[b][p]);
      const double bias = image.has(biased) ? std::abs(image.channel(biased)[p]) : 0.0f;
      held += off <= 1.96 * doubt + bias;
      pixels += 1;
    }
  }
  return held / pixels;
}

/// Image error squared of one image, of the worst band, the reference's own taken off.
double true_error(const Image& image, const Study& study) {
  double worst = 0;
  for (std::size_t b = 0; b < study.bands.size(); ++b) {
    const auto radiance = image.channel(study.bands[b] + ".radiance");
    const std::vector<float>& truth = study.reference.picture.values().bands[b];
    double brightest = 0, sum = 0;
    for (const float value : truth) brightest = std::max(brightest, std::abs(static_cast<double>(value)));
    for (std::size_t p = 0; p < truth.size(); ++p) {
      const double scale = std::max(std::abs(static_cast<double>(truth[p])), 0.05 * brightest);
      const double off = radiance[p] - truth[p];
      sum += (off * off - study.reference.picture.variance(b, p)) / (scale * scale);
    }
    worst = std::max(worst, sum / static_cast<double>(truth.size()));
  }
  return std::sqrt(worst);
}

void measure(const Job& job, const Options& options, int& kept, int& quick, int& rows) {
  for (const std::string& file : job.files) {
    if (!std::filesystem::exists(file)) {
      fmt::print("| {} | SKIPPED: {} is absent |\n", job.name, file);
      return;
    }
  }
  Description scene = parse_scene(job.scene, job.folder, {}, job.name);
  shrink_picture(scene, options.pixels);
  scene.probes.clear();
  scene.flux.clear();
  StudySettings settings;
  settings.budget_s = options.budget;
  settings.pixels = options.pixels;
  settings.seed = 4711;
  const Study study = run_study(scene, settings);
  for (const StudyTarget& target : study.targets) {
    if (target.error > 0.06 || target.error < 0.015) continue;
    Description wish = scene;
    wish.render.target_error = ErrorTarget{target.error};
    wish.render.method.clear();
    const RunResult result = run_scene(wish, {});
    const AccuracyReport& told = *result.report.accuracy;
    double seconds = 0;
    for (const auto& [stage, time] : result.report.time_s) seconds += time;
    const double error = true_error(result.image, study);
    const double best =
        target.run >= 0 ? study.runs[static_cast<std::size_t>(target.run)].seconds.wall() : std::nan("");
    const std::string setting =
        target.run >= 0 ? study_label(study.runs[static_cast<std::size_t>(target.run)].setting) : "none reached it";
    fmt::print(
        "| {} | {:g} % | {:.2f} % | {:.2f} (95 %: {:.2f} to {:.2f}) % | {:.2f} % | {} passes of {}, {} samples | "
        "{:.2f} s | {:.2f} s: {} | {:.2f} | {:.1f} % |\n",
        job.name, 100 * target.error, 100 * error, 100 * told.error, 100 * told.interval[0], 100 * told.interval[1],
        100 * study.reference.error.value(), told.passes, told.method, told.samples, seconds, best, setting,
        seconds / best, 100 * inside(result.image, study.reference.picture, scene.bands));
    std::fflush(stdout);
    kept += error <= target.error;
    quick += !(seconds > 2 * best);
    ++rows;
  }
}

}  // namespace
}  // namespace obscura

int main(int argc, char** argv) {
  obscura::Options options;
  for (int i = 1; i + 1 < argc; i += 2) {
    const std::string key = argv[i];
    if (key == "--only") options.only = argv[i + 1];
    if (key == "--budget") options.budget = std::stod(argv[i + 1]);
    if (key == "--pixels") options.pixels = std::stoi(argv[i + 1]);
  }
  fmt::print(
      "| scene | target | true error | estimate | reference's own | passes | time | best fixed setting of the study | "
      "ratio | pixels inside 95 % |\n");
  fmt::print("|---|---|---|---|---|---|---|---|---|---|\n");
  int kept = 0, quick = 0, rows = 0;
  for (const obscura::Job& job : obscura::jobs()) {
    if (options.only.empty() || job.name.find(options.only) != std::string::npos)
      obscura::measure(job, options, kept, quick, rows);
  }
  fmt::print("\n{} of {} within the target, {} in at most twice the time of the best fixed setting\n", kept, rows,
             quick);
  return 0;
}
