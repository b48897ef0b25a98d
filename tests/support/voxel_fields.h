// Voxel fields for tests and benchmarks: from a function of the voxel to a VoxelStream, and rays of
// the awkward kinds.
#pragma once

#include <tbb/parallel_for.h>

#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "octree/base/math.h"
#include "octree/base/random.h"
#include "octree/source/voxels.h"

namespace obscura::test {

/// Value of a channel in a voxel.
using Field = std::function<float(int channel, const Vec3i& voxel)>;

/// Pours the field brick by brick, in parallel.
inline VoxelStream field_stream(const Box3i& bounds, std::vector<std::string> channels, Field field,
                                const Affine& index_to_local = Affine()) {
  VoxelStream stream;
  stream.channels = channels;
  stream.index_to_local = index_to_local;
  stream.bounds = bounds;
  stream.name = "test field";
  stream.pour = [bounds, field, count = channels.size()](VoxelSink& sink) {
    const Vec3i first(bounds.min.x >> 3, bounds.min.y >> 3, bounds.min.z >> 3);
    const Vec3i last((bounds.max.x + 7) >> 3, (bounds.max.y + 7) >> 3, (bounds.max.z + 7) >> 3);
    tbb::parallel_for(first.z, last.z, [&](int z) {
      std::vector<float> values(512 * count);
      std::vector<const float*> pointers(count);
      for (std::size_t c = 0; c < count; ++c) pointers[c] = &values[512 * c];
      for (int y = first.y; y < last.y; ++y) {
        for (int x = first.x; x < last.x; ++x) {
          const Vec3i corner(8 * x, 8 * y, 8 * z);
          for (std::size_t c = 0; c < count; ++c) {
            for (int i = 0; i < 512; ++i) {
              const Vec3i voxel = corner + Vec3i(i & 7, (i >> 3) & 7, i >> 6);
              bool inside = true;
              for (int axis = 0; axis < 3; ++axis) {
                inside = inside && voxel[axis] >= bounds.min[axis] && voxel[axis] < bounds.max[axis];
              }
              values[512 * c + static_cast<std::size_t>(i)] = inside ? field(static_cast<int>(c), voxel) : 0.0f;
            }
          }
          sink.brick(corner, pointers.data());
        }
      }
    });
  };
  return stream;
}

/// A hash of a voxel as a uniform number in (0, 1): the same field in any order of evaluation.
inline double voxel_noise(std::uint64_t seed, const Vec3i& voxel, std::uint32_t purpose = 0) {
  const std::uint64_t key = (static_cast<std::uint64_t>(static_cast<std::uint32_t>(voxel.x)) << 42) ^
                            (static_cast<std::uint64_t>(static_cast<std::uint32_t>(voxel.y)) << 21) ^
                            static_cast<std::uint64_t>(static_cast<std::uint32_t>(voxel.z));
  return Stream(seed, key, purpose).uniform();
}

/// A field with all that an octree can hold: voids of every size, uniform cells of every level, rough voxels.
inline Field patchwork(std::uint64_t seed) {
  return [seed](int channel, const Vec3i& v) {
    const auto at = [&](int level) { return Vec3i(v.x >> level, v.y >> level, v.z >> level); };
    const auto value = [&](int level) {
      return static_cast<float>(voxel_noise(seed, at(level), static_cast<std::uint32_t>(100 + 50 * level + channel)));
    };
    const double large = voxel_noise(seed, at(5), 1), medium = voxel_noise(seed, at(4), 2),
                 brick = voxel_noise(seed, at(3), 3);
    if (large < 0.2) return 0.0f;
    if (medium < 0.2) return medium < 0.1 ? 0.0f : value(4);
    if (brick < 0.3) return brick < 0.15 ? 0.0f : value(3);
    const int level = brick < 0.45 ? 2 : brick < 0.6 ? 1 : 0;
    return voxel_noise(seed, at(level), 4) < 0.3 ? 0.0f : value(level);
  };
}

inline Vec3d random_direction(Stream& random) {
  const double z = 2 * random.uniform() - 1;
  const double phi = 2 * kPi * random.uniform();
  const double r = std::sqrt(std::max(0.0, 1 - z * z));
  return {r * std::cos(phi), r * std::sin(phi), z};
}

/// Rays of every awkward kind by their number: through random points, in faces and edges, through corners,
/// parallel to axes and planes, with tiny components of either sign, from inside, backwards, cut short.
inline Ray awkward_ray(const Box3i& domain, std::uint64_t seed, std::uint64_t number) {
  Stream random(seed, number, 7);
  const Vec3d low(domain.min), size = Vec3d(domain.max) - Vec3d(domain.min);
  const auto inside = [&] {
    return low + Vec3d(random.uniform() * size.x, random.uniform() * size.y, random.uniform() * size.z);
  };
  const auto rounded = [&](Vec3d p) { return Vec3d(std::floor(p.x), std::floor(p.y), std::floor(p.z)); };
  Ray ray;
  ray.direction = random_direction(random);
  Vec3d through = inside();
  const int kind = static_cast<int>(number % 12);
  const int axis = static_cast<int>(random.bits() % 3u), other = (axis + 1) % 3;
  switch (kind) {
    case 0:
    case 1:
      break;
    case 2:
      through = rounded(through);
      break;  // through a corner
    case 3:   // along an axis, in an edge
      through = rounded(through);
      ray.direction = Vec3d(0, 0, 0);
      ray.direction[axis] = random.uniform() < 0.5 ? 1 : -1;
      break;
    case 4:  // in a face
      through[axis] = std::floor(through[axis]);
      ray.direction[axis] = 0;
      break;
    case 5:  // in a face, all but parallel
      through[axis] = std::floor(through[axis]);
      ray.direction[axis] = (random.uniform() < 0.5 ? 1 : -1) * std::pow(10.0, -3 - 300 * random.uniform());
      break;
    case 6:  // beside a face, parallel
      through[axis] = std::nextafter(std::floor(through[axis]), random.uniform() < 0.5 ? -1e9 : 1e9);
      ray.direction[axis] = 0;
      break;
    case 7:  // along an edge, all but parallel
      through = rounded(through);
      ray.direction = Vec3d(0, 0, 0);
      ray.direction[axis] = random.uniform() < 0.5 ? 1 : -1;
      ray.direction[other] = (random.uniform() < 0.5 ? 1 : -1) * std::pow(10.0, -3 - 17 * random.uniform());
      break;
    case 8:  // through many corners
      through = rounded(through);
      for (int a = 0; a < 3; ++a) ray.direction[a] = static_cast<double>(static_cast<int>(random.bits() % 5u)) - 2;
      if (ray.direction == Vec3d(0, 0, 0)) ray.direction = Vec3d(1, 1, -1);
      break;
    case 9:  // one direction very small
      ray.direction[axis] *= 1e-9;
      break;
    default:
      break;
  }
  if (kind >= 10) {
    ray.origin = through;  // starts inside
    if (kind == 11) ray.t_max = random.uniform() * 0.3 * size.length();
  } else if (kind == 8) {
    ray.origin = through - 64.0 * ray.direction;  // exact in binary
  } else {
    ray.origin = through - (kind == 3 || kind == 7 ? 128.0 : 2 * size.length()) * ray.direction;
    if (kind == 4 || kind == 5 || kind == 6) ray.origin[axis] = through[axis];
    if (kind == 7)
      ray.origin = through - 128.0 * Vec3d(axis == 0 ? ray.direction.x : 0, axis == 1 ? ray.direction.y : 0,
                                           axis == 2 ? ray.direction.z : 0);
  }
  if (kind == 1) ray.direction *= std::pow(10.0, 6 * random.uniform() - 3);  // t is not metres of index space
  if (kind == 1) ray.origin = through - (2 * size.length() / ray.direction.length()) * ray.direction;
  return ray;
}

}  // namespace obscura::test
