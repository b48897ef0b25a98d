// What stays when a run repeats: the World, its plan and what methods make once. Results depend on
// the arguments alone, never on what was asked for before; only what the arguments change is made anew.
#pragma once

#include <optional>
#include <utility>

#include "scene/plan/plan.h"
#include "scene/world/build_world.h"
#include "sensor/capture/render.h"

namespace obscura {

/// Holds one scene at one time. Not thread-safe; its methods use all threads.
class Session {
 public:
  /// Builds the World, without what the plan leaves out.
  /// @param budget  image error that the plan may spend; none: the scene's target, or kDefaultBudget. 0: only what
  ///                provably contributes nothing is left out
  /// @throws as build_world()
  Session(Description scene, double time_s, const Progress& progress = {}, std::optional<double> budget = std::nullopt);

  const Description& scene() const noexcept { return scene_; }
  const std::vector<OctreeRecord>& octrees() const noexcept { return built_.octrees; }
  /// The whole World has air that absorbs.
  bool has_atmosphere() const noexcept { return has_atmosphere_; }

  /// For the scene's own camera. All are valid until another view is asked for.
  const World& world() { return see(own_view_), built_.world; }
  const Plan& plan() { return see(own_view_), plan_; }
  /// For any camera.
  const World& world(const CameraSettings& view) { return see(view), built_.world; }
  const Plan& plan(const CameraSettings& view) { return see(view), plan_; }
  /// What the whole World can do, with what the plan leaves out.
  const MediaSummary& summary() { return see(own_view_), summary_; }

  /// Rays that a pixel has at most, by the scene's method and over all passes.
  int rays_per_pixel();

  /// The method's answers in the World that the scene's own camera sees. What the method makes once is kept until other
  /// settings of it are asked for. @throws NumericalError where the method cannot serve; ResourceError
  Estimator estimator(const Method& method, std::uint64_t seed, const Progress& progress = {});

  /// The image of a view. More samples than one pass can hold become passes. @throws as estimator()
  Rendered render(const CameraSettings& view, const SamplerSettings& sampling, const Method& method, std::uint64_t seed,
                  const Progress& progress = {});
  /// As the scene describes it, and its plan.
  Rendered render(const Progress& progress = {});

 private:
  /// Makes World and plan anew where another view needs something that they leave out.
  void see(const CameraSettings& view);
  double budget() const;
  void make_plan();
  Estimator estimate(const Method& method, const SamplerSettings& sampling, std::uint64_t seed,
                     const Progress& progress);

  Description scene_;
  std::optional<double> budget_;
  BuiltWorld built_;
  std::optional<WorldContents> whole_;  // where the World is not all of it
  bool has_atmosphere_;
  CameraSettings own_view_, view_;
  MediaSummary summary_;
  Plan plan_;

  std::optional<std::pair<Method, EstimatorSettings>> accepted_;  // could serve this World when last asked
  struct Solved {
    SolutionBasis basis;
    Solution solution;
  };
  std::optional<Solved> solved_;
};

}  // namespace obscura
