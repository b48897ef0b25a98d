// Making maps, and queries that go on over the images of a map that repeats.
#include "photon/map/photon_map.h"

#include <limits>

namespace obscura {
namespace {

/// Pairwise, so that the error does not grow with the number of photons; the order is the tree's.
double sum_of_powers(std::span<const Photon> photons) noexcept {
  if (photons.size() <= 64) {
    double sum = 0;
    for (const Photon& photon : photons) sum += photon.power;
    return sum;
  }
  const std::size_t half = photons.size() / 2;
  return sum_of_powers(photons.first(half)) + sum_of_powers(photons.subspan(half));
}

}  // namespace

PhotonMap::PhotonMap(std::vector<Photon> photons, const Vec3d& period) : period_(period) {
  std::uint64_t images = 1;
  for (int axis = 0; axis < 3; ++axis) {
    if (!(period[axis] > 0)) continue;
    periodic_ = true;
    images *= 7;
    middle_[axis] = static_cast<float>(0.5 * period[axis]);
    for (Photon& photon : photons) {
      const double p = photon.position[axis];
      photon.position[axis] = static_cast<float>(p - period[axis] * std::floor(p / period[axis]));
    }
  }
  if (periodic_) {
    rings_ = images * photons.size() <= std::numeric_limits<std::uint32_t>::max() ? 3 : 1;
  }
  tree_ = KdTree(std::move(photons));
  power_ = sum_of_powers(tree_.photons());
}

Vec3f PhotonMap::local(const Vec3d& x) const noexcept {
  Vec3d moved = x;
  if (periodic_) {
    for (int axis = 0; axis < 3; ++axis) {
      if (period_[axis] > 0) moved[axis] -= period_[axis] * std::floor(moved[axis] / period_[axis]);
    }
  }
  return Vec3f(moved);
}

double PhotonMap::reach() const noexcept {
  double reach = kInfinity;
  for (int axis = 0; axis < 3; ++axis) {
    if (period_[axis] > 0) reach = std::min(reach, rings_ * period_[axis]);
  }
  return reach;
}

void PhotonMap::nearest(const Vec3f& local, Nearest& found) const noexcept {
  tree_.nearest(local, found);
  if (!periodic_) return;

  // Ring by ring around the cell, until a whole ring is farther away than what has been found.
  const auto count = static_cast<std::uint32_t>(size());
  const int width = 2 * rings_ + 1;
  int side[3];
  for (int axis = 0; axis < 3; ++axis) side[axis] = period_[axis] > 0 ? 1 : 0;
  for (int ring = 1; ring <= rings_; ++ring) {
    bool within = false;
    for (int i = -ring * side[0]; i <= ring * side[0]; ++i) {
      for (int j = -ring * side[1]; j <= ring * side[1]; ++j) {
        for (int k = -ring * side[2]; k <= ring * side[2]; ++k) {
          if (std::max({std::abs(i), std::abs(j), std::abs(k)}) != ring) continue;
          // The nearest point of that cell; a little too near, so that rounding loses no photon.
          const Vec3i shift(i, j, k);
          double distance2 = 0;
          for (int axis = 0; axis < 3; ++axis) {
            const double beside =
                std::abs(local[axis] - shift[axis] * period_[axis] - middle_[axis]) - 0.5 * period_[axis] * (1 + 1e-6);
            if (shift[axis] != 0 && beside > 0) distance2 += beside * beside;
          }
          if (distance2 * (1 - 1e-6) > found.bound()) continue;
          within = true;
          // The image's number, in digits of one axis each: 0, 1 .. rings, -rings .. -1.
          int number = 0;
          for (int axis = 0; axis < 3; ++axis) {
            number = number * (side[axis] ? width : 1) + (shift[axis] + (shift[axis] < 0 ? width : 0));
          }
          const Vec3f moved(Vec3d(local) - Vec3d(shift) * period_);
          tree_.nearest(moved, found, count * static_cast<std::uint32_t>(number));
        }
      }
    }
    if (!within) break;
  }
}

Vec3f PhotonMap::offset(const Vec3f& local, std::uint32_t index) const noexcept {
  if (!periodic_) return photons()[index].position - local;
  const auto count = static_cast<std::uint32_t>(size());
  int number = static_cast<int>(index / count);
  const Vec3f position = photons()[index % count].position;
  Vec3f moved;
  for (int axis = 2; axis >= 0; --axis) {
    const int width = period_[axis] > 0 ? 2 * rings_ + 1 : 1;
    const int digit = number % width;
    const int shift = 2 * digit > width ? digit - width : digit;
    number /= width;
    // The same rounding as in nearest().
    const float from = shift == 0 ? local[axis] : static_cast<float>(local[axis] - shift * period_[axis]);
    moved[axis] = position[axis] - from;
  }
  return moved;
}

}  // namespace obscura
