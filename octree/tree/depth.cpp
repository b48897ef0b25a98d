// Optical depths and free paths of single rays, in double: the sums over a ray's bricks.
#include <algorithm>
#include <cassert>
#include <cmath>

#include "octree/tree/line.h"
#include "octree/tree/walk.h"

namespace obscura {
namespace {

using detail::ChannelHeader;
using detail::Line;
using detail::TreeData;

const ChannelHeader* headers_of(const TreeData& tree, std::uint32_t word) noexcept {
  return reinterpret_cast<const ChannelHeader*>(tree.record(word));
}

// Calls use(factor, value), where value(i) * factor is the extinction in leaf i of a record.
// @param only  the one channel with a weight, or -1
template <class Use>
auto with_values(const std::byte* record, const ChannelHeader* headers, std::span<const double> weights, int only,
                 Use&& use) noexcept {
  if (only < 0) {
    return use(1.0, [=](std::ptrdiff_t i) {
      double sum = 0;
      for (std::size_t c = 0; c < weights.size(); ++c) {
        if (weights[c] != 0)
          sum += weights[c] * static_cast<double>(detail::unpack(record, headers[c], static_cast<unsigned>(i)));
      }
      return sum;
    });
  }
  const double weight = weights[static_cast<std::size_t>(only)];
  const ChannelHeader& header = headers[only];
  const std::byte* data = record + header.data_offset();
  const int bits = header.bits();
  if (bits == 32) {
    return use(weight, [data](std::ptrdiff_t i) {
      float v;
      std::memcpy(&v, data + 4 * i, 4);
      return static_cast<double>(v);
    });
  }
  const float offset = header.offset, scale = header.scale;
  const std::uint32_t mask = (std::uint32_t{1} << bits) - 1;
  return use(weight, [=](std::ptrdiff_t i) {
    const std::ptrdiff_t at = i * bits;
    std::uint32_t q;
    std::memcpy(&q, data + (at >> 3), 4);
    return static_cast<double>(offset + scale * static_cast<float>(static_cast<std::int32_t>(q >> (at & 7) & mask)));
  });
}

// The extinction of a record that is one leaf; negative where it has several leaves.
double uniform_extinction(const ChannelHeader* headers, std::span<const double> weights, int only) noexcept {
  if (only >= 0) {
    return headers[only].bits() == 0
               ? weights[static_cast<std::size_t>(only)] * static_cast<double>(headers[only].offset)
               : -1.0;
  }
  double sum = 0;
  for (std::size_t c = 0; c < weights.size(); ++c) {
    if (weights[c] == 0) continue;
    if (headers[c].bits() != 0) return -1;
    sum += weights[c] * static_cast<double>(headers[c].offset);
  }
  return sum;
}

// The one channel that has a weight; -1 where there are several.
int only_channel(std::span<const double> weights) noexcept {
  int only = -1;
  for (std::size_t c = 0; c < weights.size(); ++c) {
    if (weights[c] == 0) continue;
    if (only >= 0) return -1;
    only = static_cast<int>(c);
  }
  return std::max(only, 0);
}

// Optical depth of a block from begin to end.
double block_depth(const TreeData& tree, const Line& line, std::uint32_t word, double begin, double end,
                   std::span<const double> weights, int only) noexcept {
  const std::byte* record = tree.record(word);
  const ChannelHeader* headers = headers_of(tree, word);
  const double uniform = uniform_extinction(headers, weights, only);
  if (uniform >= 0) return uniform * (end - begin);
  const detail::LeafSteps steps = line.leaves(begin, headers[0].cell_level());
  return with_values(record, headers, weights, only, [&](double factor, auto&& value) {
    double sum = 0;
    detail::for_each_leaf(steps, begin, end, [&](std::ptrdiff_t i, double from, double to) {
      sum += value(i) * (to - from);
      return true;
    });
    return factor * sum;
  });
}

// Where in a block the optical depth from `begin` on reaches `target`. @pre it does before `end`
double collision(const TreeData& tree, const Line& line, std::uint32_t word, double begin, double end, double target,
                 std::span<const double> weights, int only) noexcept {
  const auto inside = [](double from, double to, double t) {
    return std::min(std::max(t, from), std::nextafter(to, from));
  };
  const std::byte* record = tree.record(word);
  const ChannelHeader* headers = headers_of(tree, word);
  const double uniform = uniform_extinction(headers, weights, only);
  if (uniform >= 0) return inside(begin, end, begin + target / uniform);
  const detail::LeafSteps steps = line.leaves(begin, headers[0].cell_level());
  return with_values(record, headers, weights, only, [&](double factor, auto&& value) {
    double sum = 0, where = begin;
    detail::for_each_leaf(steps, begin, end, [&](std::ptrdiff_t i, double from, double to) {
      const double v = value(i), next = sum + v * (to - from);
      if (v > 0 && to > from) {
        where = inside(from, to, from + (target / factor - sum) / v);
        if (factor * next >= target) return false;
      }
      sum = next;
      return true;
    });
    return where;
  });
}

}  // namespace

double optical_depth(const Octree& tree, const Ray& index_ray, std::span<const double> weights) noexcept {
  assert(weights.size() == tree.channels().size());
  const TreeData& data = tree.data();
  const int only = only_channel(weights);
  double depth = 0;
  Line::walk(data, index_ray, [&](const Line& line, std::uint32_t word, double begin, double end) {
    depth += block_depth(data, line, word, begin, end, weights, only);
    return true;
  });
  return depth;
}

FreePath free_path(const Octree& tree, const Ray& index_ray, std::span<const double> weights,
                   double target_depth) noexcept {
  assert(weights.size() == tree.channels().size());
  assert(target_depth >= 0);
  const TreeData& data = tree.data();
  const int only = only_channel(weights);
  FreePath path{index_ray.t_min, 0, false};
  const double left = Line::walk(data, index_ray, [&](const Line& line, std::uint32_t word, double begin, double end) {
    const double here = block_depth(data, line, word, begin, end, weights, only);
    if (here > 0 && path.depth + here >= target_depth) {
      path.t = collision(data, line, word, begin, end, target_depth - path.depth, weights, only);
      path.depth = target_depth;
      path.collided = true;
      return false;
    }
    path.depth += here;
    return true;
  });
  if (!path.collided) path.t = left;
  return path;
}

}  // namespace obscura
