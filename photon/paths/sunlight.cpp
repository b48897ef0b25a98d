#include "photon/paths/sunlight.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "photon/optics/purpose.h"
#include "photon/world/spectral_world.h"

namespace obscura {
namespace {

double irradiance(SpectralWorld world) noexcept {
  double sum = 0;
  for (const Sun& sun : world->suns()) sum += world.value_of(sun.irradiance);
  return sum;
}

}  // namespace

void sunlit_shares(const World& world, std::uint64_t seed, std::span<const Ray> rays,
                   std::span<const std::uint64_t> histories, std::span<float> shares) {
  std::fill(shares.begin(), shares.end(), 0.0f);
  int brightest = 0;
  for (int i = 1; i < world.interval_count(); ++i) {
    if (irradiance({world, i}) > irradiance({world, brightest})) brightest = i;
  }
  const SpectralWorld lit(world, brightest);
  const double all = irradiance(lit);
  if (!(all > 0)) return;

  struct Shadow {
    std::size_t ray;
    double share;
  };
  std::vector<Ray> toward;
  std::vector<Shadow> shadows;
  for (std::size_t r = 0; r < rays.size(); ++r) {
    Stream stream = StreamName{seed, histories[r], Purpose::sunlight}.stream();
    const SurfaceHit hit = world.meet(rays[r], {}, stream);
    if (!hit.exists()) continue;
    const SurfacePoint at = lit.surface_at(rays[r], hit);
    if (!at.reflects()) continue;
    for (const Sun& sun : world.suns()) {
      if (!(sun.toward.dot(at.normal) > 0)) continue;
      const Ray ray{at.position, sun.toward, world.surfaces().clearance(), kInfinity};
      if (world.blocked(ray, hit.id, stream)) continue;
      toward.push_back(ray);
      shadows.push_back({r, lit.value_of(sun.irradiance) / all});
    }
  }
  std::vector<double> depths(toward.size());
  lit.optical_depths(toward, depths);
  for (std::size_t i = 0; i < toward.size(); ++i) {
    shares[shadows[i].ray] += static_cast<float>(shadows[i].share * std::exp(-depths[i]));
  }
}

}  // namespace obscura
