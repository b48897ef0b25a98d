// How often the code of each effect has run, so that an effect which is off can be seen to have done nothing.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace obscura {

/// What is counted: per ray, flight, point or photon, never per segment.
enum class Work {
  extinction,        ///< rays and flights through clouds that attenuate
  emission,          ///< rays and flights along which the emission of clouds is added up
  scattering,        ///< points where clouds scatter light into a camera ray
  map,               ///< density estimates asked of a photon map
  gather,            ///< flights of gathered paths
  masking,           ///< queries for the first surface in a ray's way, or whether there is one
  surfaces,          ///< places on surfaces that were looked at
  specular,          ///< legs and flights that a mirror has sent on
  sun,               ///< shadow rays towards sun and moon
  sky,               ///< shadow rays and flights towards a bright sky, whether or not clouds dim them
  faces,             ///< shadow rays towards what objects emit
  spheres,           ///< shadow rays towards hot spheres and particles
  beams,             ///< shadow rays back along beams
  atmosphere,        ///< legs, shadow rays and flights through air
  spectral,          ///< rays and photons at intervals beyond the first of their band
  photons_emission,  ///< emitted by clouds
  photons_sun,       ///< and moon
  photons_sky,
  photons_faces,    ///< by objects
  photons_spheres,  ///< hot spheres and particles
  photons_beams,
  collisions,  ///< of photons in clouds
};

inline constexpr std::array<std::string_view, 22> kWorkNames = {
    "extinction",    "emission",    "scattering",    "map",
    "gather",        "masking",     "surfaces",      "specular",
    "sun",           "sky",         "faces",         "spheres",
    "beams",         "atmosphere",  "spectral",      "photons_emission",
    "photons_sun",   "photons_sky", "photons_faces", "photons_spheres",
    "photons_beams", "collisions"};
static_assert(kWorkNames.size() == static_cast<std::size_t>(Work::collisions) + 1);

class WorkCounts {
 public:
  std::uint64_t& operator[](Work work) noexcept { return counts_[static_cast<std::size_t>(work)]; }
  std::uint64_t operator[](Work work) const noexcept { return counts_[static_cast<std::size_t>(work)]; }
  WorkCounts& operator+=(const WorkCounts& other) noexcept {
    for (std::size_t i = 0; i < counts_.size(); ++i) counts_[i] += other.counts_[i];
    return *this;
  }
  bool operator==(const WorkCounts&) const = default;

 private:
  std::array<std::uint64_t, kWorkNames.size()> counts_{};
};

}  // namespace obscura
