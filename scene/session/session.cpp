#include "scene/session/session.h"

#include <algorithm>
#include <utility>

#include "scene/plan/plausible.h"
#include "sensor/capture/view.h"

namespace obscura {
namespace {

/// A target in kelvin leaves out what matters in pixels up to this temperature.
constexpr double kHot_K = 1000;

/// How the rays of a pixel share the paths that a method draws. What is more than a pass can hold goes into further
/// passes, unless they would ask the same map: such passes are not independent.
struct Shared {
  SamplerSettings sampling;
  int passes = 1;
};
Shared share_samples(const Method& method, const EstimatorSettings& settings, SamplerSettings sampling) {
  Shared shared;
  if (draws_paths(method, settings)) {
    // Where all pixels have as many rays, none is without a sample.
    if (!sampling.adaptive) sampling.max_oversampling = std::min(sampling.max_oversampling, method.samples);
    if (!method.type->photons) shared.passes = (method.samples + kMostPoints - 1) / kMostPoints;
    sampling.samples = (method.samples + shared.passes - 1) / shared.passes;
  }
  shared.sampling = std::move(sampling);
  return shared;
}

}  // namespace

Session::Session(Description scene, double time_s, const Progress& progress, std::optional<double> budget)
    : scene_(std::move(scene)),
      budget_(budget),
      built_(build_world(with_fewest_intervals(scene_), time_s, progress)),
      has_atmosphere_(built_.world.atmosphere().has_value()),
      own_view_(scene_.sensor),
      view_(own_view_),
      summary_(summarize(built_.world, view_of(Camera(view_)))) {
  make_plan();
}

void Session::see(const CameraSettings& view) {
  if (view == view_) return;
  view_ = view;
  summary_ = whole_ ? summarize(World(*whole_), view_of(Camera(view))) : summarize(built_.world, view_of(Camera(view)));
  make_plan();
}

double Session::budget() const {
  if (budget_) return *budget_;
  const std::optional<ErrorTarget>& target = scene_.render.target_error;
  if (!target) return kDefaultBudget;
  if (target->unit == ErrorUnit::fraction) return target->value;
  // The hotter a thing is, the less of its radiance is a kelvin.
  double budget = kDefaultBudget;
  for (const Band& band : built_.world.bands()) {
    if (band.grey() || band.um_max() <= kThermal_um) continue;
    budget = std::min(budget, target->value * band.planck_derivative(kHot_K) / band.planck(kHot_K));
  }
  return budget;
}

void Session::make_plan() {
  Plan plan = obscura::make_plan(scene_, summary_, budget());
  for (std::string& warning : implausible_values(scene_, summary_, built_.octrees))
    plan.warnings.push_back(std::move(warning));
  if (plan.cuts != plan_.cuts) {
    // Octrees and meshes are shared; what finds surfaces exists once at a time.
    if (!whole_) whole_ = built_.world.contents();
    accepted_.reset();
    solved_.reset();
    built_.world = World({});
    built_.world = World(plan.cuts.any() ? reduced(*whole_, plan.cuts) : *whole_);
    if (!plan.cuts.any()) whole_.reset();
  }
  plan_ = std::move(plan);
}

Estimator Session::estimate(const Method& method, const SamplerSettings& sampling, std::uint64_t seed,
                            const Progress& progress) {
  EstimatorSettings settings = plan_.estimator;
  if (accepted_ != std::pair(method, settings)) {
    accepted_.reset();
    if (auto refusal = unfit(built_.world, method, settings)) throw *refusal;
    accepted_ = std::pair(method, settings);
  }
  settings.seed = seed;
  const SolutionBasis basis = method.type->basis(method, settings);
  if (!solved_ || !(solved_->basis == basis)) {
    solved_.reset();
    solved_ = {basis, method.type->solve(built_.world, method, settings, progress)};
  }
  // For callers that ask along single rays, such as probes.
  if (draws_paths(method, settings)) {
    const Shared shared = share_samples(method, settings, sampling);
    const int rays = shared.sampling.max_oversampling;
    settings.paths_per_ray = std::clamp((method.samples + rays - 1) / rays, 1, kMostPoints);
  }
  return method.type->estimator(built_.world, method, settings, solved_->solution);
}

int Session::rays_per_pixel() {
  see(own_view_);
  const Shared shared = share_samples(plan_.method, plan_.estimator, plan_.sampling);
  return shared.passes * shared.sampling.max_oversampling;
}

Estimator Session::estimator(const Method& method, std::uint64_t seed, const Progress& progress) {
  see(own_view_);
  return estimate(method, plan_.sampling, seed, progress);
}

Rendered Session::render(const CameraSettings& view, const SamplerSettings& sampling, const Method& method,
                         std::uint64_t seed, const Progress& progress) {
  see(view);
  const Estimator estimator = estimate(method, sampling, seed, progress);
  const Camera camera(view);
  auto [shared, passes] = share_samples(method, plan_.estimator, sampling);
  shared.seed = seed;
  Rendered image = obscura::render(built_.world, estimator.radiance, camera, shared, progress);
  for (int pass = 1; pass < passes && !progress.cancelled(); ++pass) {
    shared.pass = static_cast<std::uint32_t>(pass);
    image.merge(obscura::render(built_.world, estimator.radiance, camera, shared, progress));
  }
  return image;
}

Rendered Session::render(const Progress& progress) {
  see(own_view_);
  return render(own_view_, plan_.sampling, plan_.method, scene_.render.seed, progress);
}

}  // namespace obscura
