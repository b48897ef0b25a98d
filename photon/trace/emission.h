// Photon emission: every source of a World sends photons in proportion to its power at one spectral
// interval, with weights that make up for any other choice.
#pragma once

#include <algorithm>
#include <array>
#include <optional>
#include <span>
#include <vector>

#include "photon/optics/directions.h"
#include "photon/optics/work.h"
#include "photon/world/spectral_world.h"

namespace obscura {

/// Which sources take part; all on by default. A source that is off emits nothing.
struct SourceSelection {
  bool emission = true;  ///< the clouds' own
  bool sun = true;
  bool sky = true;
  bool spheres = true;  ///< hot spheres
  bool particles = true;
  bool beams = true;
  bool surfaces = true;  ///< what objects emit
};

struct EmittedPhoton {
  Vec3d position;
  Vec3d direction;                     ///< unit vector
  double power = 0;                    ///< W as if it were the only photon; to be divided by the number emitted
  bool in_direct_set = false;          ///< of a source that the sensor pass integrates directly
  bool from_beyond = false;            ///< of sun, moon or sky, which are given as they arrive at the scene
  FaceId from;                         ///< of an object or hot sphere that it leaves
  Work work = Work::photons_emission;  ///< what it counts as
};

/// The sources of one interval. Immutable and thread-safe.
class PhotonEmitter {
 public:
  /// @param around extra box that photons of sun and sky must cover besides the World, such as flux rectangles; empty:
  /// none
  explicit PhotonEmitter(SpectralWorld world, const SourceSelection& selection = {}, const Box3d& around = {});

  SpectralWorld world() const noexcept { return world_; }
  bool emits() const noexcept { return !sources_.empty(); }
  /// Clouds are among the sources.
  bool has_clouds() const noexcept {
    return std::any_of(sources_.begin(), sources_.end(),
                       [](const Source& source) { return source.kind == Kind::cloud; });
  }
  /// Power of all sources, W.
  double power() const noexcept { return power_; }

  /// Sources that can be given more or fewer photons: a cloud, sun, sky, objects, all spheres, all beams.
  std::size_t group_count() const noexcept { return groups_.size(); }
  /// An emitter of that group's sources alone.
  PhotonEmitter only(std::size_t group) const;
  /// Makes photons of each group as frequent as its share says; weights make up for it.
  /// @param shares one for each group, > 0
  void set_shares(std::span<const double> shares);

  /// A sphere about the clouds, given where the World is much larger than they are: of the light that the first surface
  /// reflects diffusely, tracing aims half of the photons at it.
  struct Focus {
    Vec3d center;
    double radius;
  };
  std::optional<Focus> focus() const noexcept {
    if (targets_.size() < 2) return std::nullopt;
    return Focus{targets_[1].center, targets_[1].radius};
  }

  /// Remembers the voxels of the block that it last emitted from: photons that come in the order of
  /// their first number find it there.
  struct Cache {
    int cloud = -1;
    std::uint32_t block = 0;
    std::array<float, 512> cumulative{};
  };

  /// @param u uniform numbers: source, position (3), direction (2), 2 spare.
  EmittedPhoton emit(const std::array<double, 8>& u, Cache& cache) const noexcept;

 private:
  enum class Kind { cloud, sun, sky, faces, lines, sphere, beam };
  struct Source {
    Kind kind;
    int index;      // cloud, sun, sphere or beam
    double power;   // W
    double chance;  // of being chosen
  };
  /// Where light from infinity enters: a disc over the bounds, or the free faces of a periodic cell.
  struct Face {
    Vec3d corner, side_u, side_v;
    Vec3d inward;  // unit normal
    double area;
  };
  /// Light from infinity is aimed at spheres: the World's bounds and, where these are much larger, the
  /// surroundings of the clouds.
  struct Target {
    Vec3d center;
    double radius;
    double share;  // of the photons
  };
  struct Blocks {
    std::vector<double> cumulative;  // of power times the bounded chance to escape
    std::vector<float> chance;       // the bounded chance to escape, per block
    double emitted = 0;              // W
  };

  static Work work_of(Kind kind) noexcept;
  Blocks sum_blocks(int cloud) const;
  void make_faces(const Box3d& around);
  void make_targets();
  void make_groups();
  void sum_chances();
  /// Area across the light of a sun, in the mean over its disc, of the faces that it comes in by.
  double area_towards(const Sun& sun) const noexcept;
  /// Where light that travels along -toward starts, beyond the bounds, and its density, 1/m2.
  std::pair<Vec3d, double> place_beyond(const Vec3d& toward, double u, double v, double which) const noexcept;
  EmittedPhoton from_cloud(int cloud, double u, const std::array<double, 8>& v, Cache& cache) const noexcept;
  EmittedPhoton from_sun(int index, const std::array<double, 8>& u) const noexcept;
  EmittedPhoton from_sky(const std::array<double, 8>& u) const noexcept;
  EmittedPhoton from_faces(double u, const std::array<double, 8>& v) const noexcept;
  EmittedPhoton from_lines(const std::array<double, 8>& u) const noexcept;
  bool is_net(const FaceId& face) const noexcept;
  bool is_on_a_line(const Vec3d& position, const Vec3d& direction, FaceId from) const noexcept;
  EmittedPhoton from_sphere(int index, const std::array<double, 8>& u) const noexcept;
  EmittedPhoton from_beam(int index, const std::array<double, 8>& u) const noexcept;

  SpectralWorld world_;
  double power_ = 0;
  Vec3d middle_{0, 0, 0};    // of the bounds of everything that light from infinity has to pass
  double radius_ = 0;        // of the sphere about them, m
  std::vector<Face> faces_;  // periodic scenes
  std::vector<Target> targets_;
  std::vector<Source> sources_;
  std::vector<std::vector<std::size_t>> groups_;  // of sources
  std::vector<double> cumulative_;
  std::vector<Blocks> blocks_;
};

}  // namespace obscura
