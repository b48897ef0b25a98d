// The world walk: the segments of all clouds along a ray, merged front to back into one stream with
// constant total coefficients. Resumable, no allocation.
#pragma once

#include <array>
#include <cstddef>
#include <new>
#include <optional>
#include <type_traits>

#include "octree/tree/walk.h"
#include "photon/world/footprint.h"
#include "photon/world/spectral_world.h"

namespace obscura {

/// One cloud's non-empty segments along a ray.
class CloudStream {
 public:
  CloudStream(SpectralWorld world, int cloud, const Ray& ray, CoarseCells* coarse = nullptr) noexcept
      : cloud_(&world->clouds()[static_cast<std::size_t>(cloud)]),
        optics_(&world.optics(cloud)),
        cells_(world->frame(cloud), ray),
        coarse_(coarse),
        voxel_m_(world->frame(cloud).voxel_m) {
    next();
  }

  /// False once there is nothing more; the values then are those of an empty segment at infinity.
  bool next() noexcept {
    for (;;) {
      while (walk_ && (coarse_ ? walk_->next(*this) : walk_->next())) {
        if (coarse_ && walk_->coarse()) {
          begin_ = walk_->begin();
          end_ = walk_->end();
          local_ = cell_;
          coarse_->passed_over((end_ - begin_) * faces_);
          return true;
        }
        if (walk_->empty()) continue;
        begin_ = walk_->begin();
        end_ = walk_->end();
        local_ = optics_->at([this](int channel) noexcept { return walk_->value(channel); });
        return true;
      }
      const std::optional<Ray> piece = cells_.next();
      if (!piece) break;
      walk_.emplace(*cloud_->octree, *piece);
      if (coarse_) faces_ = std::abs(piece->direction.x) + std::abs(piece->direction.y) + std::abs(piece->direction.z);
    }
    walk_.reset();
    begin_ = end_ = kInfinity;
    local_ = {};
    return false;
  }

  double begin() const noexcept { return begin_; }
  double end() const noexcept { return end_; }
  const LocalOptics& optics() const noexcept { return local_; }

  /// What Walk::next(stops) asks of its stops: the coarsest level that may be offered here, and whether a cell is
  /// taken.
  int level(double t) const noexcept { return coarse_->level(t, voxel_m_); }
  bool take(const CellBounds& bounds, double begin, double end) noexcept {
    const double length = end - begin;
    if (!(length > 0)) return false;
    const std::optional<CoarseOptics> cell =
        optics_->coarse(bounds, [&](double extinction) { return coarse_->allows(length, extinction); });
    if (!cell || !coarse_->take(length, cell->extinction, cell->emission)) return false;
    cell_ = cell->mean;
    return true;
  }

 private:
  const Cloud* cloud_;
  const CloudOptics* optics_;
  CellRays cells_;
  CoarseCells* coarse_;
  double voxel_m_;
  double faces_ = 0;  // of voxels that the ray crosses, per unit of t
  LocalOptics cell_;  // of the coarse cell that the walk is in
  std::optional<Walk> walk_;
  double begin_ = kInfinity;
  double end_ = kInfinity;
  LocalOptics local_;
};

/// Segments of the whole World. Gaps between segments hold nothing.
class WorldWalk {
 public:
  /// @param coarse null: by leaves alone. Else it decides which cells are taken whole, and the caller must call
  ///               coarse->passed(depth, transmission) after every segment
  WorldWalk(SpectralWorld world, const Ray& ray, CoarseCells* coarse = nullptr) noexcept {
    for (int cloud = 0; cloud < world->cloud_count(); ++cloud) {
      const CloudStream* stream = new (slot(count_)) CloudStream(world, cloud, ray, coarse);
      if (stream->begin() < kInfinity) ++count_;
    }
  }

  bool next() noexcept {
    if (count_ == 1) return next_of_one();
    // Where the segment begins: where the last one ended, or after the gap behind it.
    double begin = kInfinity;
    for (int i = 0; i < count_; ++i) {
      CloudStream& stream = *slot(i);
      while (stream.end() <= end_ && stream.begin() < kInfinity) stream.next();
      begin = std::min(begin, std::max(stream.begin(), end_));
    }
    if (begin == kInfinity) return false;
    // It ends where any cloud changes.
    double end = kInfinity;
    optics_ = {};
    for (int i = 0; i < count_; ++i) {
      const CloudStream& stream = *slot(i);
      if (stream.begin() <= begin) {
        end = std::min(end, stream.end());
        optics_ += stream.optics();
      } else {
        end = std::min(end, stream.begin());
      }
    }
    begin_ = begin;
    end_ = end;
    return true;
  }

  double begin() const noexcept { return begin_; }
  double end() const noexcept { return end_; }
  const LocalOptics& optics() const noexcept { return optics_; }

 private:
  bool next_of_one() noexcept {
    CloudStream& stream = *slot(0);
    if (started_) stream.next();
    started_ = true;
    if (stream.begin() == kInfinity) return false;
    begin_ = stream.begin();
    end_ = stream.end();
    optics_ = stream.optics();
    return true;
  }

  CloudStream* slot(int i) noexcept { return reinterpret_cast<CloudStream*>(storage_) + i; }

  // Only the clouds that the ray meets are ever made.
  static_assert(std::is_trivially_destructible_v<CloudStream>);
  alignas(CloudStream) std::byte storage_[World::kMaxClouds * sizeof(CloudStream)];
  int count_ = 0;
  bool started_ = false;
  double begin_ = -kInfinity;
  double end_ = -kInfinity;
  LocalOptics optics_;
};

}  // namespace obscura
