#include "photon/world/thickness.h"

#include <algorithm>
#include <string>

#include "photon/optics/purpose.h"
#include "photon/optics/sampling.h"

namespace obscura {
namespace {

struct LargestScattering {
  double albedo = 0;
  double mean_cosine = -1;
};

LargestScattering largest_scattering(SpectralWorld world) {
  LargestScattering largest;
  for (int c = 0; c < world->cloud_count(); ++c) {
    for (const CloudOptics::Part& part : world.optics(c).parts()) {
      if (!(part.scattering > 0)) continue;
      largest.albedo = std::max(largest.albedo, part.scattering / part.extinction);
      largest.mean_cosine = std::max(largest.mean_cosine, part.phase->mean_cosine());
    }
  }
  return largest;
}

}  // namespace

double largest_optical_depth(SpectralWorld world, int chords) {
  if (world->bounds().isEmpty()) return 0;
  const double radius = 0.5 * world->bounds().size().length();
  std::vector<Ray> rays;
  Stream stream = StreamName{0, 0, Purpose::chord, world.interval()}.stream();
  for (int i = 0; i < chords; ++i) {
    // Through a random point of the bounds; the first three along the axes through the middle.
    Vec3d through = world->bounds().center();
    Vec3d direction(i == 0, i == 1, i == 2);
    if (i >= 3) {
      for (int axis = 0; axis < 3; ++axis) through[axis] += (stream.uniform() - 0.5) * world->bounds().size()[axis];
      const double u = stream.uniform();
      direction = uniform_direction(u, stream.uniform());
    }
    rays.push_back({through - 2 * radius * direction, direction, 0, 4 * radius});
  }
  std::vector<double> depths(rays.size());
  world.optical_depths(rays, depths);
  return *std::max_element(depths.begin(), depths.end());
}

double largest_scattering_depth(SpectralWorld world, int chords) {
  const double albedo = largest_scattering(world).albedo;
  return albedo > 0 ? albedo * largest_optical_depth(world, chords) : 0.0;
}

double largest_mean_cosine(SpectralWorld world) { return std::max(0.0, largest_scattering(world).mean_cosine); }

std::optional<NumericalError> endless_histories(SpectralWorld world, std::string_view method) {
  const auto [albedo, forward] = largest_scattering(world);
  if (albedo == 0) return std::nullopt;
  const double depth = largest_optical_depth(world);
  if (!(depth * (1 - forward) > 1e4 && 1 - albedo < 1 / depth)) return std::nullopt;
  return NumericalError("method \"" + std::string(method) + "\"",
                        "an optical depth of " + std::to_string(depth) + " with an albedo of " +
                            std::to_string(albedo) + " keeps light inside for longer than it can be followed",
                        "lower the extinction or the albedo, or use discrete ordinates");
}

}  // namespace obscura
