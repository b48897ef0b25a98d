// One setting of one method, and the ways to change it: its ladder of growing cost and its other knobs.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "photon/methods/method.h"
#include "scene/file/description.h"

namespace obscura {

class World;

/// Whether `obscura render` can make such a picture: it has no keys for grids.
inline bool renders(const MethodType* method) noexcept { return !method->cells; }

/// A method without any work: what it does not have stays so, so that equal means equal work.
inline Method no_work(const MethodType& type = kPathTracer) {
  Method method;
  method.type = &type;
  method.photons = 0;
  method.nearest = method.samples = method.cells = method.order = 0;
  return method;
}

struct StudySetting {
  Method method = no_work();
  int rays = 1;  ///< max_oversampling
  double octree_tolerance = 1e-3;
  int intervals = 0;        ///< of each band that has wavelengths; 0: the scene's own
  bool everything = false;  ///< no effect is left out on a bound: a reference

  bool operator==(const StudySetting&) const = default;
};

/// What a scene is like, as far as it decides which knobs there are.
struct StudyTraits {
  StudySetting given;    ///< the scene's own method and knobs, photons and samples of all methods
  bool scatters = true;  ///< a cloud scatters or a surface reflects
  bool clouds = true;
  bool depth_limited = false;  ///< scattering_depth is set
  bool spectral = false;       ///< optics vary within a band
  int most_intervals = 1;      ///< that the scene gives to a band
  int most_rays = 1024;
};

/// The lowest rung of a method's ladder. Rungs are factors of four in cost around the scene's own setting.
StudySetting first_rung(const StudyTraits& traits, const MethodType* method);
/// The main knobs of the method times `factor`: photons, and nearest with their power 4/7; paths; cells; rays where
/// nothing scatters, and elsewhere above the scene's own setting.
StudySetting scaled(const StudyTraits& traits, StudySetting setting, double factor);
inline constexpr double kRung = 4;

struct StudyVariation {
  std::string knob;
  StudySetting setting;
};
/// Each other knob changed alone.
std::vector<StudyVariation> variations(const StudyTraits& traits, const StudySetting& base);
/// The same setting with one knob as in another.
StudySetting with_knob(StudySetting setting, const std::string& knob, const StudySetting& base,
                       const StudySetting& changed);

/// Work in units of its own: of photons, of the picture. Only ratios within a method mean anything.
struct StudyWork {
  double map = 0, image = 0;
};
StudyWork work_of(const StudySetting& setting);
/// Whether two settings can share a World.
inline bool same_world(const StudySetting& a, const StudySetting& b) noexcept {
  return a.octree_tolerance == b.octree_tolerance && a.intervals == b.intervals && a.everything == b.everything;
}

/// "photon map, 500,000 photons, 64 nearest": what a reader needs to tell it from others of its method.
std::string study_label(const StudySetting& setting);
const char* name_of(Kernel kernel) noexcept;

/// JSON pointers and values (JSON) that make any scene render so; empty for ordinates.
/// @param bands for the pointers of intervals: whether each is grey
std::vector<std::pair<std::string, std::string>> scene_edits(const StudySetting& setting,
                                                             const std::vector<bool>& grey);
/// The whole method: the scene's settings where the study leaves them alone.
Method full_method(const StudySetting& setting, const Description& scene);

/// @param method that the plan chooses for the scene
StudyTraits traits_of(const Description& scene, const World& world, const Method& method);

}  // namespace obscura
