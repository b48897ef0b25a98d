#include "octree/batch_walk.h"

#include <cassert>

namespace obscura {

void optical_depths(const Octree& tree, std::span<const Ray> index_rays, std::span<const double> weights,
                    std::span<double> depths) noexcept {
  assert(index_rays.size() == depths.size());
  for (std::size_t i = 0; i < index_rays.size(); ++i) depths[i] = optical_depth(tree, index_rays[i], weights);
}

void free_paths(const Octree& tree, std::span<const Flight> flights, std::span<const double> weights,
                std::span<FreePath> ends) noexcept {
  assert(flights.size() == ends.size());
  for (std::size_t i = 0; i < flights.size(); ++i) {
    ends[i] = free_path(tree, flights[i].ray, weights, flights[i].target_depth);
  }
}

std::string_view batch_target() { return "scalar"; }

std::vector<std::string_view> batch_targets() { return {"scalar"}; }

bool force_batch_target(std::string_view name) { return name.empty() || name == "scalar"; }

}  // namespace obscura
