#include "sensor/capture/strata.h"

#include <optional>

#include "photon/world/world.h"

namespace obscura {

RayCounts& RayCounts::operator+=(const RayCounts& other) noexcept {
  base += other.base;
  deciding += other.deciding;
  for (std::size_t c = 0; c < asked.size(); ++c) asked[c] += other.asked[c];
  return *this;
}

TileStrata even_strata(const World& world, const Sampler& sampler, const FilmTile& tile) {
  TileStrata result;
  const std::span<const Stratum> strata = sampler.strata();
  // Edges are those of objects, of hot spheres, and of the discs of sun and moon.
  const bool surfaces = !world.objects().empty() || !world.spheres().empty() || !world.suns().empty();
  std::optional<SpotQuery> geometry;
  if (surfaces) geometry.emplace(world, SpotThresholds{}, AdaptiveSettings{}.specular_depth);
  const auto complex = [&](double x, double y, double width, double height) {
    const std::optional<Spot> spot = sampler.camera().spot(x, y, x + width, y + height);
    return spot && (*geometry)(*spot) != Criterion::none;
  };
  for (int y = tile.y_begin(); y < tile.y_end(); ++y) {
    for (int x = tile.x_begin(); x < tile.x_end(); ++x) {
      result.first.push_back(result.strata.size());
      const bool edge = surfaces && complex(x, y, 1, 1);
      for (const Stratum& part : strata) {
        result.strata.push_back(part);
        result.complex.push_back(
            edge && (strata.size() == 1 || complex(x + part.x_min, y + part.y_min, part.width, part.height)));
      }
    }
  }
  result.rays.base = result.strata.size();
  result.criterion.assign(result.first.size(), Criterion::none);
  result.first.push_back(result.strata.size());
  return result;
}

}  // namespace obscura
