#include "photon/paths/path_tracer.h"

#include "photon/optics/purpose.h"
#include "photon/optics/sampling.h"
#include "photon/world/thickness.h"

namespace obscura {

RadianceCounts path_radiance(SpectralWorld world, const PathSettings& settings, std::span<const Ray> rays,
                             std::span<const std::uint64_t> histories, std::span<Incoming> incoming) {
  RadianceSettings all;
  all.points = settings.paths;
  all.gather_bounces = kAllBounces;
  all.specular_depth = settings.specular_depth;
  all.scattering_depth = settings.scattering_depth;
  all.seed = settings.seed;
  all.parts = settings.parts;
  return incoming_radiance(world, nullptr, all, rays, histories, incoming);
}

PathFlux path_flux(SpectralWorld world, const PathSettings& settings, const FluxRectangle& rectangle, int rays,
                   std::uint64_t history) {
  const int rows = std::max(1, static_cast<int>(std::sqrt(rays)));
  const double area = rectangle.side_u.length() * rectangle.side_v.length();
  const Vec3d normal = rectangle.side_u.cross(rectangle.side_v).normalized();
  // Rays look where light comes from. The sun's disc would outshine all else: it has a shadow ray of its own.
  PathSettings without_disc = settings;
  without_disc.parts.sun_disc = false;
  const auto side = [&](const Vec3d& facing, std::uint64_t name) {
    Stream stream = StreamName{settings.seed, name, Purpose::probe, world.interval()}.stream();
    std::vector<Ray> places;
    std::vector<std::uint64_t> histories;
    for (int row = 0; row < rows; ++row) {
      for (int column = 0; column < rows; ++column) {
        const double a = (column + stream.uniform()) / rows - 0.5, b = (row + stream.uniform()) / rows - 0.5;
        const double u = stream.uniform();
        const Vec3d place = rectangle.center + a * rectangle.side_u + b * rectangle.side_v;
        places.push_back({place, cosine_direction(facing, u, stream.uniform()), 0, kInfinity});
        histories.push_back((name + 1) << 32 | histories.size());
      }
    }
    std::vector<Incoming> incoming(places.size());
    path_radiance(world, without_disc, places, histories, incoming);
    Moments power;
    for (std::size_t i = 0; i < places.size(); ++i) {
      double irradiance = kPi * incoming[i].total();
      for (const Sun& sun : world->suns()) {
        const double cosine = sun.toward.dot(facing);
        const double u = stream.uniform(), v = stream.uniform();
        const Ray shadow{places[i].origin, cone_direction(sun.toward, std::sin(0.5 * sun.diameter), u, v).first, 0,
                         kInfinity};
        if (!(cosine > 0) || world->blocked(shadow, {}, stream)) continue;
        double depth = 0;
        world.optical_depths({&shadow, 1}, {&depth, 1});
        irradiance += cosine * world.value_of(sun.irradiance) * std::exp(-depth);
      }
      power.add(area * irradiance);
    }
    return BatchMean{power.mean(), power.standard_error()};
  };
  return {side(-normal, 2 * history), side(normal, 2 * history + 1)};
}

std::optional<NumericalError> unfit_for_paths(const World& world) {
  for (const Beam& beam : world.beams()) {
    if (beam.radius > 0) continue;
    return NumericalError("method \"path\"", "a beam without width is a line that no path meets",
                          "give beams a \"radius_m\", or use method \"photon\" without final gather");
  }
  for (int i = 0; i < world.interval_count(); ++i) {
    if (auto endless = endless_histories({world, i}, "path")) return endless;
  }
  return std::nullopt;
}

}  // namespace obscura
