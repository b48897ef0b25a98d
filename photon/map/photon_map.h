// All photons of a run with their tree: where the map lies in the world, whether it repeats, and what
// its powers are relative to. Immutable.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "photon/map/kd_tree.h"

namespace obscura {

class PhotonMap {
 public:
  PhotonMap() = default;

  /// @param photons  positions relative to `origin`; taken, wrapped into one cell and reordered
  /// @param origin   m, in the world; near the photons, since their positions are float
  /// @param period   m, per axis; 0: the map does not repeat along it. The cell begins at the origin.
  /// @param emitted  what powers are to be divided by: the number of emitted photons, or 1 where they
  ///                 have been divided by it already; > 0
  explicit PhotonMap(std::vector<Photon> photons, const Vec3d& origin = {0, 0, 0}, const Vec3d& period = {0, 0, 0},
                     double emitted = 1);

  /// The map of both sets of photons, each power relative to the sum of the emitted. Origin and period
  /// must be the same. Associative and commutative to the bit.
  static PhotonMap merge(const PhotonMap& a, const PhotonMap& b);

  std::size_t size() const noexcept { return tree_.photons().size(); }
  /// In an order that depends on nothing but the photons themselves.
  std::span<const Photon> photons() const noexcept { return tree_.photons(); }
  const KdTree& tree() const noexcept { return tree_; }
  const Vec3d& origin() const noexcept { return origin_; }
  const Vec3d& period() const noexcept { return period_; }
  bool periodic() const noexcept { return periodic_; }
  double emitted() const noexcept { return emitted_; }
  /// Sum of the photons' powers / emitted, W.
  double power() const noexcept { return power_; }
  std::uint64_t bytes() const noexcept { return tree_.bytes(); }

  /// A query point as the tree sees it: relative to the origin and, where the map repeats, moved by
  /// whole periods next to the photons.
  Vec3f local(const Vec3d& x) const noexcept;
  /// Photons around a local point, those of neighbouring cells included. Where the map repeats they are
  /// found to a distance of reach().
  void nearest(const Vec3f& local, Nearest& found) const noexcept;
  /// How far (m) a query finds every photon: three periods (one, where a map of more than 10^7 photons
  /// repeats along all axes), infinite where nothing repeats.
  double reach() const noexcept;
  /// The photon behind an index of nearest().
  const Photon& photon(std::uint32_t index) const noexcept { return photons()[periodic_ ? index % size() : index]; }
  /// From the local point to that photon, in the cell where it was found, m.
  Vec3f offset(const Vec3f& local, std::uint32_t index) const noexcept;

 private:
  KdTree tree_;
  Vec3d origin_{0, 0, 0};
  Vec3d period_{0, 0, 0};
  bool periodic_ = false;
  int rings_ = 0;          // images searched to either side
  Vec3f middle_{0, 0, 0};  // of the cell
  double emitted_ = 1;
  double power_ = 0;
};

/// The light of one spectral interval that is not in the direct set.
struct PhotonMaps {
  PhotonMap volume;   ///< at collisions
  PhotonMap surface;  ///< at surfaces that reflect
};

}  // namespace obscura
