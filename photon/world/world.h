// The World at one time: clouds, surfaces, hot spheres, sky, sun and beams, with their optics at every
// spectral interval. Made from arrays, immutable; all kernels read it.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "octree/base/math.h"
#include "octree/base/random.h"
#include "octree/tree/batch_walk.h"
#include "photon/optics/band.h"
#include "photon/optics/material.h"
#include "photon/world/cloud.h"
#include "photon/world/cloud_frame.h"
#include "photon/world/face_lights.h"
#include "photon/world/object.h"
#include "photon/world/surfaces.h"

namespace obscura {

/// A distant disc of light: sun or moon.
struct Sun {
  Vec3d toward{0, 0, 1};           ///< unit vector from the scene to it
  std::vector<double> irradiance;  ///< W/m2 per interval, normal to the beam
  double diameter = 0;             ///< radians, full angle

  /// Whether one who looks that way sees the disc.
  bool covers(const Vec3d& direction) const noexcept {
    return direction.dot(toward) > 0 && direction.cross(toward).length() < std::sin(0.5 * diameter);
  }
  /// Of its disc, W/m2/sr; 0 where it is a point.
  double radiance(int interval) const noexcept {
    const double sine = std::sin(0.5 * diameter);
    return sine > 0 ? irradiance[static_cast<std::size_t>(interval)] / (kPi * sine * sine) : 0.0;
  }
};

/// A collimated beam; its light goes along `direction` from a disc about `position`.
struct Beam {
  Vec3d position;
  Vec3d direction;            ///< unit vector
  double radius = 0;          ///< m
  std::vector<double> power;  ///< W per interval
};

/// Homogeneous air that absorbs and emits, does not scatter, and is everywhere.
struct Atmosphere {
  std::vector<double> extinction;  ///< 1/m per interval
  std::vector<double> radiance;    ///< of a black body at its temperature, W/m2/sr per interval
};

/// What a World is made of. Per-interval vectors hold one value for every interval of every band.
struct WorldContents {
  std::vector<Band> bands;
  std::vector<Cloud> clouds;
  std::vector<double> sky;  ///< radiance over the full sphere, W/m2/sr; empty: 0
  std::optional<Sun> sun;
  std::optional<Sun> moon;
  std::optional<Atmosphere> atmosphere;
  std::vector<Material> materials;
  std::vector<Object> objects;
  std::vector<HotSphere> sources;    ///< hot spheres that light the cloud directly
  std::vector<HotSphere> particles;  ///< hot spheres whose light is stored from the first collision
  std::vector<Beam> beams;
};

/// A side of a surface where a ray has met it, at one interval.
struct SurfacePoint {
  FaceId id;
  Vec3d position;
  Vec3d normal;                              ///< unit, of that side
  double cosine = 1;                         ///< between the normal and the way back along the ray
  const MaterialOptics* material = nullptr;  ///< none: it reflects nothing
  double black = 0;                          ///< a black body's radiance in its place, W/m2/sr; 0: emits nothing

  double emission(double toward) const noexcept { return material ? black * material->emissivity(toward) : black; }
  double reflectance(double toward) const noexcept { return material ? material->reflectance(toward) : 0.0; }
  bool reflects() const noexcept { return material && material->reflects(); }
};

/// The place of an interval among all of the World's.
struct IntervalIndex {
  int band = 0;
  int interval = 0;
};

class World {
 public:
  /// Most clouds that one World can hold: kernels merge their walks without allocating.
  static constexpr int kMaxClouds = 64;

  /// @throws InputError with every problem: lists of wrong length, numbers out of range or not finite, indices that
  /// point at nothing, missing octrees, directions not of unit length (check_contents.h); then too many clouds or
  /// channels, periods smaller than the grid.
  explicit World(WorldContents contents);

  /// What it was made of: a copy with something left out makes a World without it.
  const WorldContents& contents() const noexcept { return contents_; }
  const std::vector<Band>& bands() const noexcept { return contents_.bands; }
  const std::vector<Cloud>& clouds() const noexcept { return contents_.clouds; }
  /// Sun and moon, those that there are.
  std::span<const Sun> suns() const noexcept { return suns_; }
  const std::optional<Atmosphere>& atmosphere() const noexcept { return contents_.atmosphere; }
  const std::vector<Beam>& beams() const noexcept { return contents_.beams; }
  const std::vector<Material>& materials() const noexcept { return contents_.materials; }
  const std::vector<Object>& objects() const noexcept { return contents_.objects; }
  /// Hot spheres first, then particles: the surfaces behind the objects.
  const std::vector<HotSphere>& spheres() const noexcept { return spheres_; }
  std::size_t source_count() const noexcept { return contents_.sources.size(); }
  const Surfaces& surfaces() const noexcept { return surfaces_; }

  int interval_count() const noexcept { return static_cast<int>(intervals_.size()); }
  IntervalIndex interval(int index) const noexcept { return intervals_[static_cast<std::size_t>(index)]; }

  const CloudFrame& frame(int cloud) const noexcept { return frames_[static_cast<std::size_t>(cloud)]; }
  int cloud_count() const noexcept { return static_cast<int>(contents_.clouds.size()); }

  /// Everything of finite size, in world metres; empty where there is nothing.
  const Box3d& bounds() const noexcept { return bounds_; }
  /// Of the clouds among it.
  const Box3d& cloud_bounds() const noexcept { return cloud_bounds_; }
  /// Surfaces are stored relative to this point.
  const Vec3d& origin() const noexcept { return origin_; }

  /// The rigid frame in which photons are stored: about the origin or, in a periodic World, along the
  /// sides of the first cell from its corner.
  const Affine& world_to_map() const noexcept { return world_to_map_; }
  const Affine& map_to_world() const noexcept { return map_to_world_; }
  /// Sides of the periodic cell in the map's frame, m; 0 where it does not repeat.
  const Vec3d& map_period() const noexcept { return map_period_; }

  bool periodic() const noexcept { return periodic_cloud_ >= 0; }
  /// Side vectors of the periodic cell in world metres; zero where not periodic.
  const std::array<Vec3d, 2>& period() const noexcept { return period_; }

  /// A point moved into the first periodic cell.
  Vec3d wrap(const Vec3d& point) const noexcept;
  /// The index-space point of a cloud, wrapped into its cell where it is periodic.
  Vec3d index_point(int cloud, const Vec3d& point) const noexcept;

  /// The first surface in the ray's way. Where materials are permeable, numbers of the stream decide which
  /// are passed through.
  SurfaceHit meet(const Ray& ray, FaceId from, Stream& stream) const noexcept;
  /// Whether there are such materials; else surfaces() alone tells.
  bool permeable() const noexcept { return permeable_; }
  bool blocked(const Ray& ray, FaceId from, Stream& stream) const noexcept;

 private:
  friend class SpectralWorld;  // what depends on the interval is asked there

  void make_map_frame();
  void place_clouds();
  void place_surfaces();
  void light_surfaces();
  std::size_t slot_of(const FaceId& face) const noexcept;

  WorldContents contents_;
  std::vector<IntervalIndex> intervals_;
  std::vector<CloudOptics> optics_;
  std::vector<CloudFrame> frames_;
  std::vector<Sun> suns_;
  std::vector<HotSphere> spheres_;
  Surfaces surfaces_;
  std::vector<MaterialOptics> materials_;  // [interval][material]
  std::vector<std::size_t> first_slots_;   // of each object, among all objects' slots
  std::size_t slot_count_ = 0;
  std::vector<double> black_;                            // [interval][slot], W/m2/sr
  std::vector<std::optional<PlanckTable>> mesh_planck_;  // per interval, where a mesh has temperatures of its own
  std::vector<FaceLights> face_lights_;                  // per interval
  std::vector<bool> surfaces_reflect_;                   // per interval
  bool permeable_ = false;
  Box3d bounds_;
  Box3d cloud_bounds_;
  Vec3d origin_{0, 0, 0};
  double largest_leaf_m_ = 0;
  int periodic_cloud_ = -1;
  std::array<Vec3d, 2> period_{Vec3d(0), Vec3d(0)};
  Affine world_to_map_;
  Affine map_to_world_;
  Vec3d map_period_{0, 0, 0};
};

}  // namespace obscura
