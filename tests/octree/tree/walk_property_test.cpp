// The walks held against brute force on random octrees: the truth is a list of boxes with values, and a ray is
// clipped against each of them, one by one. Nothing of an octree or of a walk is in that.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "octree/build/build.h"
#include "octree/tree/batch_walk.h"
#include "octree/tree/walk.h"
#include "tests/support/voxel_fields.h"

using namespace obscura;
using namespace obscura::test;

namespace {

/// A cube of one value per channel.
struct TruthBox {
  Vec3i low;
  int side;
  std::array<float, 3> values;
};

/// A tree of random shape: cubes of every size from one voxel on, many of them empty.
struct Truth {
  std::vector<std::string> channels;
  Box3i domain;
  std::vector<TruthBox> boxes;  // those that are not empty, disjoint
};

std::array<float, 3> random_values(Stream& random, std::size_t channels) {
  std::array<float, 3> values{};
  // A few values come again and again, so that cells merge; some are very large or small.
  for (std::size_t c = 0; c < channels; ++c) {
    const double u = random.uniform();
    values[c] = u < 0.3 ? 0.0f : u < 0.6 ? 0.5f : static_cast<float>(std::pow(10.0, 4 * random.uniform() - 3));
  }
  return values;
}

/// Splits a cube at random. `left` is how many boxes there may still be.
void grow(Truth& truth, Stream& random, const Vec3i& low, int level, int& left) {
  const double u = random.uniform();
  if (u < 0.25) return;
  const bool split = level > 0 && left >= 8 && random.uniform() < (level > 2 ? 0.85 : 0.5);
  if (!split) {
    if (level > 0 && u < 0.4) return;
    truth.boxes.push_back({low, 1 << level, random_values(random, truth.channels.size())});
    --left;
    return;
  }
  const int half = 1 << (level - 1);
  // The children in random order: where boxes run out, it is not always at the same end.
  const unsigned turn = random.bits() & 7u;
  for (unsigned i = 0; i < 8; ++i) {
    const unsigned child = i ^ turn;
    grow(truth, random, low + half * Vec3i(child & 1, child >> 1 & 1, child >> 2), level - 1, left);
  }
}

Truth random_truth(std::uint64_t seed) {
  Stream random(seed, 0, 1);
  Truth truth;
  const int channels = 1 + static_cast<int>(random.bits() % 3u);
  for (int c = 0; c < channels; ++c) truth.channels.push_back("c" + std::to_string(c));
  const int level = 3 + static_cast<int>(random.bits() % 5u);  // 8 to 128 voxels a side
  Vec3i origin;
  for (int axis = 0; axis < 3; ++axis) origin[axis] = (static_cast<int>(random.bits() % 9u) - 4) * (1 << level);
  int left = 160;
  grow(truth, random, origin, level, left);
  if (truth.boxes.empty()) truth.boxes.push_back({origin, 1, {1, 1, 1}});
  // The domain is what the boxes span, sometimes a little more.
  const int margin = static_cast<int>(random.bits() % 3u);
  for (const TruthBox& box : truth.boxes) {
    truth.domain.extendBy(box.low - Vec3i(margin));
    truth.domain.extendBy(box.low + Vec3i(box.side + margin));
  }
  return truth;
}

/// Tiles where a cube is one, bricks where cubes are smaller.
VoxelStream stream_of(const Truth& truth) {
  VoxelStream stream;
  stream.channels = truth.channels;
  stream.bounds = truth.domain;
  stream.name = "random truth";
  stream.pour = [&truth](VoxelSink& sink) {
    const std::size_t channels = truth.channels.size();
    std::vector<std::pair<Vec3i, std::vector<float>>> bricks;
    for (const TruthBox& box : truth.boxes) {
      if (box.side >= 8) {
        sink.tile(box.low, static_cast<int>(std::lround(std::log2(box.side))), std::span(box.values).first(channels));
        continue;
      }
      const Vec3i corner(box.low.x & ~7, box.low.y & ~7, box.low.z & ~7);
      auto found = std::find_if(bricks.begin(), bricks.end(), [&](const auto& brick) { return brick.first == corner; });
      if (found == bricks.end()) found = bricks.insert(bricks.end(), {corner, std::vector<float>(512 * channels)});
      for (int i = 0; i < box.side * box.side * box.side; ++i) {
        const Vec3i v = box.low - corner + Vec3i(i % box.side, i / box.side % box.side, i / (box.side * box.side));
        for (std::size_t c = 0; c < channels; ++c) {
          found->second[512 * c + static_cast<std::size_t>(v.x + 8 * v.y + 64 * v.z)] = box.values[c];
        }
      }
    }
    for (const auto& [corner, values] : bricks) {
      std::vector<const float*> pointers;
      for (std::size_t c = 0; c < channels; ++c) pointers.push_back(&values[512 * c]);
      sink.brick(corner, pointers.data());
    }
  };
  return stream;
}

/// Where a ray is in [low, high): the slab method, one axis after the other.
std::pair<double, double> slab_clip(const Ray& ray, const Vec3d& low, const Vec3d& high) {
  double enter = ray.t_min, leave = ray.t_max;
  for (int axis = 0; axis < 3; ++axis) {
    const double o = ray.origin[axis], d = ray.direction[axis];
    if (std::abs(d) < std::numeric_limits<double>::min()) {
      if (!(o >= low[axis] && o < high[axis])) return {kInfinity, -kInfinity};
      continue;
    }
    const double a = (low[axis] - o) / d, b = (high[axis] - o) / d;
    enter = std::max(enter, std::min(a, b));
    leave = std::min(leave, std::max(a, b));
  }
  return {enter, leave};
}

struct Piece {
  double begin, end;
  std::array<float, 3> values;
  double extinction;
  double side;  // of the box, voxels
};

/// The ray's pieces in boxes, front to back.
std::vector<Piece> brute_force(const Truth& truth, const Ray& ray, std::span<const double> weights) {
  std::vector<Piece> pieces;
  for (const TruthBox& box : truth.boxes) {
    const auto [enter, leave] = slab_clip(ray, Vec3d(box.low), Vec3d(box.low + Vec3i(box.side)));
    if (!(enter < leave)) continue;
    double extinction = 0;
    for (std::size_t c = 0; c < weights.size(); ++c) extinction += weights[c] * static_cast<double>(box.values[c]);
    pieces.push_back({enter, leave, box.values, extinction, static_cast<double>(box.side)});
  }
  std::sort(pieces.begin(), pieces.end(), [](const Piece& a, const Piece& b) { return a.begin < b.begin; });
  return pieces;
}

double depth_of(const std::vector<Piece>& pieces, double until = kInfinity) {
  double depth = 0;
  for (const Piece& piece : pieces) depth += piece.extinction * std::max(0.0, std::min(piece.end, until) - piece.begin);
  return depth;
}

/// awkward_ray()'s kinds and more: from very far, with very short and very long directions, from exactly a
/// face, an edge or a corner, backwards in time.
Ray property_ray(const Box3i& domain, std::uint64_t seed, std::uint64_t number) {
  Ray ray = awkward_ray(domain, seed, number);
  Stream random(seed, number, 8);
  switch (number / 12 % 8) {
    case 0: {  // starts in a face, an edge or a corner
      const unsigned axes = 1 + random.bits() % 7u;
      for (int axis = 0; axis < 3; ++axis) {
        const double low = domain.min[axis], size = domain.max[axis] - domain.min[axis];
        ray.origin[axis] = low + size * random.uniform();
        if (axes >> axis & 1u) ray.origin[axis] = std::floor(ray.origin[axis]);
      }
      break;
    }
    case 1: {  // t is not metres of index space
      const double scale = std::pow(2.0, std::floor(120 * random.uniform()) - 60);
      ray.direction *= scale;
      ray.t_max /= scale;
      break;
    }
    case 2:  // from afar
      ray.origin -= std::pow(2.0, std::floor(20 * random.uniform())) * ray.direction;
      break;
    case 3:  // part of a line that begins behind its origin
      ray.t_min = -kInfinity;
      break;
    case 4: {  // cut at both ends, exactly at a plane or anywhere
      const auto [enter, leave] = slab_clip(ray, Vec3d(domain.min), Vec3d(domain.max));
      if (!(enter < leave) || !std::isfinite(leave)) break;
      ray.t_min = enter + random.uniform() * (leave - enter);
      ray.t_max = ray.t_min + random.uniform() * (leave - ray.t_min);
      if (random.uniform() < 0.5) ray.t_max = ray.t_min;
      break;
    }
    default:
      break;
  }
  return ray;
}

/// How far the walk's values are from the truth's: the integral over the ray of the largest difference.
double difference_of(const std::vector<Piece>& pieces, const Octree& tree, const Ray& ray, bool& tiles, double& entered,
                     double& left) {
  double sum = 0, last = 0;
  std::size_t at = 0;
  bool first = true;
  const auto size = static_cast<std::size_t>(tree.channel_count());
  Walk segments(tree, ray);
  while (segments.next()) {
    double begin = segments.begin();
    const double end = segments.end();
    tiles = tiles && end > begin && (first || begin == last);
    if (first) entered = begin;
    first = false;
    last = end;
    // Pieces and gaps of the truth below this segment.
    while (begin < end) {
      while (at < pieces.size() && pieces[at].end <= begin) ++at;
      const bool in_piece = at < pieces.size() && pieces[at].begin <= begin;
      const double to = at == pieces.size() ? end : std::min(end, in_piece ? pieces[at].end : pieces[at].begin);
      double difference = 0;
      for (std::size_t c = 0; c < size; ++c) {
        const float value = segments.value(static_cast<int>(c));
        difference =
            std::max(difference, static_cast<double>(std::abs(value - (in_piece ? pieces[at].values[c] : 0.0f))));
      }
      sum += difference * (to - begin);
      begin = to;
    }
  }
  if (first) return 0;
  left = last;
  return sum;
}

}  // namespace

TEST_CASE("on random octrees every walk is what clipping against each box says",
          "[octree][walk][property][not_finite]") {
  constexpr int kTrees = 250, kRays = 2400;
  constexpr double kRounding = 1024 * std::numeric_limits<double>::epsilon();
  std::uint64_t met = 0, collided = 0, wrong = 0;
  for (std::uint64_t seed = 0; seed < kTrees; ++seed) {
    const Truth truth = random_truth(seed);
    BuildSettings lossless;
    lossless.tolerance = 0;
    const Octree tree = build_octree(stream_of(truth), lossless).first;
    const std::array<double, 3> all_weights{0.7, 0.02, 1.3};
    const std::span<const double> weights = std::span(all_weights).first(truth.channels.size());
    double largest = 0;
    for (const TruthBox& box : truth.boxes) {
      for (std::size_t c = 0; c < weights.size(); ++c) largest = std::max(largest, static_cast<double>(box.values[c]));
    }
    const double most = 2.1 * largest;  // extinction

    std::vector<Ray> rays;
    std::vector<Flight> flights;
    std::vector<double> expected;
    std::vector<std::vector<Piece>> all_pieces;
    for (std::uint64_t i = 0; i < kRays; ++i) {
      rays.push_back(property_ray(truth.domain, seed, i));
      all_pieces.push_back(brute_force(truth, rays.back(), weights));
      expected.push_back(depth_of(all_pieces.back()));
      Stream random(seed, i, 9);
      flights.push_back({rays.back(), -std::log(random.uniform()) * (i % 2 ? 1.0 : std::max(1e-3, expected.back())) /
                                          rays.back().direction.length()});
    }
    std::vector<double> batched(rays.size());
    std::vector<FreePath> ends(rays.size());
    optical_depths(tree, rays, weights, batched);
    free_paths(tree, flights, weights, ends);

    for (std::size_t i = 0; i < rays.size(); ++i) {
      const Ray& ray = rays[i];
      const std::vector<Piece>& pieces = all_pieces[i];
      const auto [enter, leave] = slab_clip(ray, Vec3d(truth.domain.min), Vec3d(truth.domain.max));
      const bool meets = enter < leave;
      // Rounding of a plane's time, in t; and of a float position in the lanes.
      const double length = ray.direction.length();
      const double late =
          std::isfinite(enter) && std::isfinite(leave) ? kRounding * std::max(std::abs(enter), std::abs(leave)) : 0.0;
      const double exact = 1e-13 * expected[i] + most * late;
      const double coarse = 2e-5 * expected[i] + 5e-6 * std::max(1.0, most) / length + exact;
      met += meets;

      bool ok = true, tiles = true;
      double entered = enter, left = leave;
      // The scalar walk's segments: no gap, no overlap, from entry to exit, and the truth's values in them.
      ok = ok && difference_of(pieces, tree, ray, tiles, entered, left) <= most * late && tiles;
      if (meets) ok = ok && std::abs(entered - enter) <= late && std::abs(left - leave) <= late;
      // Optical depth, scalar and batched.
      const double depth = optical_depth(tree, ray, weights);
      ok = ok && std::abs(depth - expected[i]) <= exact && std::abs(batched[i] - expected[i]) <= coarse;
      // Free paths: where they end the depth is the target, where they do not end it never gets there.
      const double target = flights[i].target_depth;
      const FreePath path = free_path(tree, ray, weights, target);
      for (const FreePath* end : {&path, static_cast<const FreePath*>(&ends[i])}) {
        double allowed = end == &path ? exact + 1e-13 * target : coarse + 1e-5 * target;
        if (end->collided) {
          // In a lane a collision is kept 2e-5 of its leaf away from the leaf's faces.
          for (const Piece& piece : pieces) {
            const bool there = end != &path && piece.begin <= end->t && end->t <= piece.end;
            if (there) allowed += 4e-5 * piece.extinction * std::max(8.0, 2 * piece.side) / length;
          }
          ok = ok && end->depth == target && std::abs(depth_of(pieces, end->t) - target) <= allowed;
        } else {
          ok = ok && expected[i] <= target + allowed && std::abs(end->depth - expected[i]) <= allowed;
        }
      }
      collided += path.collided;
      if (ok) continue;
      if (++wrong > 5) continue;
      INFO("tree " << seed << ", ray " << i << " from " << ray.origin << " along " << ray.direction << ", t "
                   << ray.t_min << " to " << ray.t_max << ": depth " << depth << ", batched " << batched[i]
                   << " instead of " << expected[i] << "; target " << target << ", path " << path.t << " "
                   << path.collided << ", batched " << ends[i].t << " " << ends[i].collided);
      CHECK(ok);
    }
  }
  CHECK(wrong == 0);
  // The test is not empty.
  INFO(met << " rays meet the domain, " << collided << " flights collide");
  CHECK(met > 400000);
  CHECK(collided > 100000);
}
