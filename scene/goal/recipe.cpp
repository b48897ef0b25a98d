#include "scene/goal/recipe.h"

#include <algorithm>
#include <cmath>

#include "photon/paths/radiance.h"

namespace obscura {
namespace {

/// Passes that a time is divided into: one that takes longer than foreseen wastes little.
constexpr int kTimedPasses = 6;

/// Where the product of a pass's time and square is least, were it repeated as often as needed.
double best_samples(const RecipeModel& model) {
  if (!(model.noise > 0) || !(model.sample_s > 0)) return model.least_samples;
  if (!(model.floor > 0)) return kMostPoints;
  return std::sqrt(model.fixed_s * model.noise / (model.sample_s * model.floor));
}

int whole(double samples, const RecipeModel& model) {
  return static_cast<int>(
      std::clamp(std::ceil(samples), static_cast<double>(model.least_samples), static_cast<double>(kMostPoints)));
}

}  // namespace

std::string Recipe::text() const {
  std::string text = obscura::text(method);
  if (rays == RayStyle::uniform) text += ", 4 rays a pixel";
  if (rays == RayStyle::fine) text += ", finer rays";
  return text;
}

std::optional<PassPlan> plan_for_error(const RecipeModel& model, double image_error) {
  const double square = image_error * image_error - model.bias;
  if (!(square > 0)) return std::nullopt;
  PassPlan plan;
  plan.samples = whole(best_samples(model), model);
  // No more than the fewest passes call for.
  if (model.noise > 0) {
    const double rest = kFewestPasses * square - model.floor;
    if (rest > 0) plan.samples = std::min(plan.samples, whole(model.noise / rest, model));
  }
  const double passes = std::ceil(model.pass_square(plan.samples) / square - 1e-9);
  plan.passes = static_cast<int>(std::clamp(passes, static_cast<double>(model.least_passes), 1e9));
  plan.seconds = plan.passes * model.pass_s(plan.samples);
  plan.error = std::sqrt(model.bias + model.pass_square(plan.samples) / plan.passes);
  return plan;
}

PassPlan plan_for_time(const RecipeModel& model, double seconds) {
  PassPlan plan;
  // Several passes, of which none has more samples than its share of the time lets it have.
  const double longest = seconds / kTimedPasses;
  double samples = best_samples(model);
  if (model.sample_s > 0)
    samples = std::min(samples, std::max(1.0, std::floor((longest - model.fixed_s) / model.sample_s)));
  plan.samples = whole(std::floor(samples), model);
  plan.passes = static_cast<int>(std::clamp(std::floor(seconds / model.pass_s(plan.samples)), 1.0, 1e9));
  plan.seconds = plan.passes * model.pass_s(plan.samples);
  plan.error = std::sqrt(model.bias + model.pass_square(plan.samples) / plan.passes);
  return plan;
}

SamplerSettings styled(SamplerSettings sampling, RayStyle style) {
  if (style == RayStyle::uniform) {
    sampling.max_oversampling = kUniformRays;
    sampling.adaptive.reset();
  } else if (style == RayStyle::fine) {
    sampling.max_oversampling *= 4;
    if (!sampling.adaptive) return sampling;
    AdaptiveSettings& limits = *sampling.adaptive;
    for (std::optional<double>* limit :
         {&limits.geometry.depth, &limits.geometry.temperature_K, &limits.geometry.emissivity, &limits.shadow,
          &limits.transmission, &limits.radiance}) {
      if (*limit) **limit *= 0.5;
    }
  }
  return sampling;
}

}  // namespace obscura
