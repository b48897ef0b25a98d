#include "photon/spot/spot.h"

#include "photon/spot/spot_search.h"

namespace obscura {

const char* name(Criterion criterion) noexcept {
  switch (criterion) {
    case Criterion::none:
      return "none";
    case Criterion::polygons:
      return "polygons";
    case Criterion::materials:
      return "materials";
    case Criterion::normal:
      return "normal";
    case Criterion::reflection:
      return "reflection";
    case Criterion::depth:
      return "depth";
    case Criterion::temperature:
      return "temperature";
    case Criterion::emissivity:
      return "emissivity";
    case Criterion::shadow:
      return "shadow";
    case Criterion::transmission:
      return "transmission";
    case Criterion::radiance:
      return "radiance";
    case Criterion::error:
      return "error";
  }
  return "none";
}

SpotQuery::SpotQuery(const World& world, const SpotThresholds& thresholds, int specular_depth)
    : search_(std::make_unique<Search>(world, thresholds, specular_depth)) {}
SpotQuery::~SpotQuery() = default;
SpotQuery::SpotQuery(SpotQuery&&) noexcept = default;
SpotQuery& SpotQuery::operator=(SpotQuery&&) noexcept = default;

Criterion SpotQuery::operator()(const Spot& spot) { return (*search_)(spot); }

}  // namespace obscura
