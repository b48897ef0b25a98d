#include "octree/build/measure.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "octree/base/random.h"
#include "octree/tree/batch_walk.h"
#include "octree/tree/walk.h"

namespace obscura::detail {
namespace {

constexpr std::size_t kBatch = 512;

// The box of what is not empty, in index space.
Box3d occupied_box(const Octree& tree) {
  Box3d box;
  for (std::uint32_t i = 0; i < tree.block_count(); ++i) {
    const Cell cell = tree.block(i).cell;
    const Vec3d corner(cell.corner);
    box.extendBy(corner);
    box.extendBy(corner + Vec3d(static_cast<double>(std::int64_t{1} << cell.level)));
  }
  for (int axis = 0; axis < 3; ++axis) {
    box.min[axis] = std::max<double>(box.min[axis], tree.domain().min[axis]);
    box.max[axis] = std::min<double>(box.max[axis], tree.domain().max[axis]);
  }
  return box;
}

void optical_depths_in_parallel(const Octree& tree, const std::vector<Ray>& rays, std::size_t first, std::size_t last,
                                std::span<const double> weights, std::vector<double>& depths) {
  tbb::parallel_for(tbb::blocked_range<std::size_t>(first, last, kBatch), [&](const auto& range) {
    const std::size_t n = range.end() - range.begin();
    optical_depths(tree, {&rays[range.begin()], n}, weights, {&depths[range.begin()], n});
  });
}

}  // namespace

MeasuringRays::MeasuringRays(const Octree& lossless, const ErrorMeasure& measure, std::uint64_t seed)
    : lossless_(lossless), measure_(measure) {
  if (lossless.block_count() == 0) return;
  const Box3d box = occupied_box(lossless);
  const Vec3d size = box.max - box.min;
  rays_.resize(kCount);
  for (std::size_t i = 0; i < kCount; ++i) {
    Stream random(seed, i, 0x6d656173u);
    const auto point = [&] {
      const double x = random.uniform(), y = random.uniform(), z = random.uniform();
      return box.min + Vec3d(x * size.x, y * size.y, z * size.z);
    };
    const Vec3d from = point();
    Vec3d along = point() - from;
    Ray ray;
    if (i % 4 == 2) {
      const int axis = static_cast<int>(i / 4 % 3);
      along = Vec3d(0, 0, 0);
      along[axis] = random.uniform() < 0.5 ? 1 : -1;
    }
    const double metres = transform_direction(lossless.index_to_local(), along).length();
    ray.origin = from;
    ray.direction = along / metres;
    if (i % 4 == 3) {
      ray.t_max = metres;
    } else {
      ray.t_min = -kInfinity;
    }
    if (!(metres > 0)) ray = Ray{from, {1, 0, 0}};
    rays_[i] = ray;
  }
}

void MeasuringRays::prepare(std::size_t count) const {
  const std::size_t known = depths_.size();
  if (known < count) {
    depths_.resize(count);
    optical_depths_in_parallel(lossless_, rays_, known, count, measure_.optical_weight, depths_);
  }
  if (!measure_.emission) return;
  const std::size_t measured = std::min(count, kEmissionCount), first = radiances_.size();
  if (first >= measured) return;
  radiances_.resize(measured);
  tbb::parallel_for(first, measured, [&](std::size_t i) { radiances_[i] = radiance(lossless_, i); });
}

// What the ray collects front to back, relative to the largest radiance that the cloud can have.
double MeasuringRays::radiance(const Octree& tree, std::size_t ray) const {
  std::vector<float> values(tree.channels().size());
  double collected = 0, transmission = 1;
  walk(tree, rays_[ray], [&](double begin, double end, const Walk& at) {
    if (at.in_empty_leaf()) return true;
    double extinction = 0;
    for (std::size_t c = 0; c < values.size(); ++c) {
      values[c] = at.value(static_cast<int>(c));
      extinction += measure_.optical_weight[c] * static_cast<double>(values[c]);
    }
    const double depth = extinction * (end - begin);
    const double lost = -std::expm1(-depth);
    collected += transmission * measure_.emission(values) * (depth > 0 ? lost / extinction : end - begin);
    transmission *= 1 - lost;
    return true;
  });
  return collected;
}

MeasuringRays::Errors MeasuringRays::compare(const Octree& tree, std::size_t count) const {
  Errors errors;
  count = std::min(count, rays_.size());
  if (count == 0) return errors;
  prepare(count);
  std::vector<double> depths(count);
  optical_depths_in_parallel(tree, rays_, 0, count, measure_.optical_weight, depths);
  for (std::size_t i = 0; i < count; ++i) {
    errors.transmission = std::max(errors.transmission, std::abs(std::exp(-depths[i]) - std::exp(-depths_[i])));
  }
  if (measure_.emission) {
    std::vector<double> radiances(std::min(count, kEmissionCount));
    tbb::parallel_for(std::size_t{0}, radiances.size(), [&](std::size_t i) { radiances[i] = radiance(tree, i); });
    for (std::size_t i = 0; i < radiances.size(); ++i) {
      errors.emission = std::max(errors.emission, std::abs(radiances[i] - radiances_[i]));
    }
  }
  return errors;
}

}  // namespace obscura::detail
