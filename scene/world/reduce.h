// What a plan leaves out, taken out: of the description before its World is built, and of the World's contents after.
#pragma once

#include "photon/world/world.h"
#include "scene/file/description.h"

namespace obscura {

/// Parts of a World that an image can do without.
struct Cuts {
  std::vector<std::string> clouds;  ///< names of clouds that no ray meets
  bool absorption = false;
  bool emission = false;
  bool surfaces = false;  ///< objects
  bool spheres = false;   ///< hot spheres and particles
  bool specular = false;  ///< mirrors are taken for Lambertian
  bool sun = false, moon = false;
  bool sky = false;
  bool atmosphere = false;

  bool any() const noexcept { return *this != Cuts(); }
  bool operator==(const Cuts&) const = default;
};

/// A copy without them; octrees and meshes are shared.
WorldContents reduced(const WorldContents& whole, const Cuts& cuts);

/// Bands whose optics (extinction, albedo, emissivity, air) are the same in all their intervals, bit for bit, are
/// solved as one: radiances add up, so nothing changes. `effects` may keep all intervals, or give every band one.
Description with_fewest_intervals(const Description& scene);

}  // namespace obscura
