// What stays when a run repeats: the World, its plan and its photon maps. Only what changed is made anew.
#pragma once

#include <optional>

#include "photon/trace/light.h"
#include "scene/plan/plan.h"
#include "scene/world/build_world.h"

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
  const World& world() const noexcept { return built_.world; }
  const std::vector<OctreeRecord>& octrees() const noexcept { return built_.octrees; }
  const Plan& plan() const noexcept { return plan_; }
  /// What the whole World can do, with what the plan leaves out.
  const MediaSummary& summary() const noexcept { return summary_; }
  /// The whole World has air that absorbs.
  bool has_atmosphere() const noexcept { return has_atmosphere_; }
  const std::vector<FluxRectangle>& rectangles() const noexcept { return rectangles_; }

  /// The photon maps, traced at the first call; of method path nothing. Where the plan needs no maps, some photons
  /// tell what becomes of the power, and none is stored. @throws as trace_light()
  const Light& light(const Progress& progress = {});

  /// Another camera: World and photon maps stay.
  void look_from(const SensorDescription& sensor);
  /// Other settings of the method: the World stays, and the maps too where only gathering changed.
  /// The octree's tolerance is fixed at construction; a different one is ignored.
  void set_render(const RenderDescription& render);
  /// Both at once.
  void set(SensorDescription sensor, const RenderDescription& render);

  /// The image of the present camera. @throws as light() and refuse_unfit_paths()
  /// @param tiles of the film to be done; none: all
  Rendered render(const Progress& progress = {}, std::vector<int> tiles = {});

 private:
  /// For the present scene and summary; brings the World in line with it.
  void make_plan();
  Light balance(const Progress& progress) const;

  Description scene_;
  std::optional<double> budget_;
  BuiltWorld built_;
  std::optional<WorldContents> whole_;  // where the World is not all of it
  bool has_atmosphere_;
  MediaSummary summary_;
  Plan plan_;
  std::vector<FluxRectangle> rectangles_;
  std::optional<Light> light_;
};

}  // namespace obscura
