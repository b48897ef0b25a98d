// A method is a way to find the light that has been scattered or reflected before: the value that says which and how,
// and the list of those that there are. To add one: a file like by_paths.cpp, and its entry in method.cpp's list.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "octree/base/error.h"
#include "octree/base/progress.h"
#include "photon/map/kernel.h"
#include "photon/methods/estimator.h"
#include "photon/optics/directions.h"
#include "photon/trace/flux.h"
#include "photon/world/world.h"

namespace obscura {

struct MethodType;

extern const MethodType kPhotonMap, kFinalGather, kPathTracer, kOrdinates;

/// Which method, and every setting that any of them has; a method leaves those of others alone.
struct Method {
  const MethodType* type = &kPathTracer;
  // of photons
  std::uint64_t photons = 1000000;  ///< emitted, per band
  double photon_power_min = 0;      ///< W; weaker ones are not stored
  Directions directions = Directions::stratified;
  int nearest = 64;  ///< photons of an estimate
  Kernel kernel = Kernel::epanechnikov;
  // of paths
  int samples = 64;  ///< paths per pixel, over all its rays
  // of ordinates
  int cells = 0;  ///< of the grid's longest side; 0: the solver's choice
  int order = 8;  ///< N of S_N
  // of all
  int specular_depth = 4;               ///< mirrors that a camera ray follows; one behind them is taken for Lambertian
  std::optional<int> scattering_depth;  ///< most scatterings in clouds; none: no limit

  bool operator==(const Method&) const = default;
};

/// What is asked of any method beside its own settings, and what has been decided to leave out.
struct EstimatorSettings {
  bool scattering = true;  ///< clouds scatter light into rays
  bool again = true;       ///< light interacts more than once: else the pass along the rays is all there is
  double footprint_tolerance = 1e-3;
  int paths_per_ray = 4;  ///< where a call does not say: RadianceSettings::points
  std::uint64_t seed = 1;
  std::vector<FluxRectangle> rectangles;

  bool operator==(const EstimatorSettings&) const = default;
};

/// All that a solution depends on, everything else as by default: where two are equal, the solution is the same.
struct SolutionBasis {
  Method method;
  EstimatorSettings settings;

  bool operator==(const SolutionBasis&) const = default;
};

/// What a method makes once for all rays: photon maps, a solution. Only the method itself knows its type.
using Solution = std::shared_ptr<const void>;

struct MethodType {
  const char* word;      ///< in scene files and options; several types may share one
  const char* name;      ///< for people
  bool photons = false;  ///< photon maps are made, and shared by all rays
  bool samples = false;  ///< paths are drawn, whose noise falls with their number
  bool cells = false;    ///< a grid is solved: no random error, and one of its own

  /// Why the method cannot serve; none: it can.
  std::optional<NumericalError> (*unfit)(const World& world, const Method& method, const EstimatorSettings& settings);
  /// Methods of several types may share a solution.
  SolutionBasis (*basis)(const Method& method, const EstimatorSettings& settings);
  /// Null where nothing is made once. Cancelled: what there is. @throws as unfit() would answer; ResourceError
  Solution (*solve)(const World& world, const Method& method, const EstimatorSettings& settings,
                    const Progress& progress);
  /// @param solution as solve() has made it for this World, this basis
  Estimator (*estimator)(const World& world, const Method& method, const EstimatorSettings& settings,
                         const Solution& solution);
};

/// All methods.
std::span<const MethodType* const> methods() noexcept;

/// Its place among methods().
std::size_t index_of(const MethodType& type) noexcept;

/// The words of all methods, each once.
std::vector<std::string> method_words();

/// Why a method cannot serve a World; none: it can.
inline std::optional<NumericalError> unfit(const World& world, const Method& method,
                                           const EstimatorSettings& settings = {}) {
  return method.type->unfit(world, method, settings);
}

/// Solves and makes the estimator in one go. @throws NumericalError as unfit() answers
Estimator make_estimator(const World& world, const Method& method, const EstimatorSettings& settings,
                         const Progress& progress = {});

/// Whether more samples of the method make the image better.
inline bool draws_paths(const Method& method, const EstimatorSettings& settings) noexcept {
  return method.type->samples && (settings.again || !method.type->photons);
}

/// "photon map, 200000 photons", "path tracer, 64 samples": with the settings that cost time.
std::string text(const Method& method);

}  // namespace obscura
