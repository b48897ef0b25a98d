// All photons of a spectral interval with their tree, and whether the map repeats. Immutable.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "photon/map/kd_tree.h"

namespace obscura {

class PhotonMap {
 public:
  PhotonMap() = default;

  /// @param photons  in the World's map frame; taken, wrapped into one cell and reordered
  /// @param period   m, per axis; 0: the map does not repeat along it. The cell begins at the frame's origin.
  explicit PhotonMap(std::vector<Photon> photons, const Vec3d& period = {0, 0, 0});

  std::size_t size() const noexcept { return tree_.photons().size(); }
  /// In an order that depends on nothing but the photons themselves.
  std::span<const Photon> photons() const noexcept { return tree_.photons(); }
  const KdTree& tree() const noexcept { return tree_; }
  const Vec3d& period() const noexcept { return period_; }
  bool periodic() const noexcept { return periodic_; }
  /// Sum of the photons' powers, W.
  double power() const noexcept { return power_; }
  std::uint64_t bytes() const noexcept { return tree_.bytes(); }

  /// A query point (m, in the map frame) as the tree sees it: where the map repeats, moved by whole
  /// periods next to the photons.
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
  Vec3d period_{0, 0, 0};
  bool periodic_ = false;
  int rings_ = 0;          // images searched to either side
  Vec3f middle_{0, 0, 0};  // of the cell
  double power_ = 0;
};

/// The light of one spectral interval that is not in the direct set.
struct PhotonMaps {
  PhotonMap volume;   ///< at collisions
  PhotonMap surface;  ///< at surfaces that reflect
};

}  // namespace obscura
