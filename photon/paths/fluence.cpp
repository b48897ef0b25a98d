#include "photon/paths/fluence.h"

#include "photon/optics/purpose.h"
#include "photon/optics/sampling.h"

namespace obscura {

Fluence fluence(SpectralWorld world, const PhotonMaps* maps, const RadianceSettings& settings, const Vec3d& point,
                int directions, std::uint64_t history) {
  // All directions but the sun's disc, in which a single ray would outshine all others.
  const int rows = std::max(1, static_cast<int>(std::sqrt(directions / 2.0)));
  const int columns = 2 * rows;
  std::vector<Ray> rays;
  std::vector<std::uint64_t> histories;
  Stream stream = StreamName{settings.seed, history, Purpose::probe, world.interval()}.stream();
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      const double u = (row + stream.uniform()) / rows;
      const double v = (column + stream.uniform()) / columns;
      rays.push_back({point, uniform_direction(u, v), 0, kInfinity});
      histories.push_back((history + 1) << 32 | histories.size());
    }
  }
  RadianceSettings without_disc = settings;
  without_disc.parts.sun_disc = false;
  std::vector<Incoming> incoming(rays.size());
  incoming_radiance(world, maps, without_disc, rays, histories, incoming);

  Moments total;
  std::array<double, kBatches> batches{};
  double bias = 0;
  for (const Incoming& in : incoming) {
    total.add(in.total());
    bias += in.bias / static_cast<double>(rays.size());
    for (std::size_t b = 0; b < batches.size(); ++b) batches[b] += in.map[b] / static_cast<double>(rays.size());
  }
  double sunlight = 0;
  for (const Sun& sun : world->suns()) {
    if (!settings.parts.background) break;
    const Ray shadow{point, sun.toward, 0, kInfinity};
    if (world->blocked(shadow, {}, stream)) continue;
    double depth = 0;
    world.optical_depths({&shadow, 1}, {&depth, 1});
    sunlight += world.value_of(sun.irradiance) * std::exp(-depth);
  }
  // Beams have no direction that a ray could find; what they send is here where the point is inside.
  double beams = 0;
  for (const Beam& beam : world->beams()) {
    const Vec3d offset = point - beam.position;
    const double along = offset.dot(beam.direction);
    if (along < 0 || !(beam.radius > 0) || (offset - along * beam.direction).length() > beam.radius) continue;
    const Ray back{point, -beam.direction, 0, along};
    if (world->blocked(back, {}, stream)) continue;
    double depth = 0;
    world.optical_depths({&back, 1}, {&depth, 1});
    beams += world.value_of(beam.power) / (kPi * beam.radius * beam.radius) *
             std::exp(-depth - world.air_extinction() * along);
  }
  const double map_error = maps ? batch_mean(batches).standard_error : 0.0;
  const double ray_error = total.standard_error();
  return {{4 * kPi * total.mean() + sunlight + beams, 4 * kPi * std::hypot(map_error, ray_error)}, 4 * kPi * bias};
}

}  // namespace obscura
