// How errors fall with what they cost, for tests that judge the slopes and the bench that prints them.
#pragma once

#include <array>
#include <functional>

#include "octree/base/statistics.h"
#include "photon/map/density.h"
#include "photon/paths/path_tracer.h"
#include "tests/support/slab_ordinates.h"
#include "tests/support/slopes.h"
#include "tests/support/worlds.h"

namespace obscura::test {

/// Photons about the origin of a medium of 1/m whose fluence is 1 there and falls like exp(-y^2 / 2) from a place that
/// is `shift` metres off along x: they lie as densely as it says, of equal powers.
struct LocalLight {
  double shift = 0;
  bool face = false;  ///< the medium ends at x = 0
  bool edge_correction = true;
  double flicker = 0;  ///< a wrong input: all powers of a map are off by a common factor with this spread

  double fluence(const Vec3d& y) const noexcept {
    return std::exp(0.5 * (shift * shift - (y - Vec3d(shift, 0, 0)).length2()));
  }
};

/// One map's estimate at the origin, and what the same ball and photons make of a fluence of 1, whose expectation is 1
/// exactly: their difference shows the bias without most of the noise.
struct LocalEstimate {
  double value = 0, of_one = 0;
};

/// @param photons in a cubic metre where the fluence is 1
inline LocalEstimate local_estimate(const LocalLight& light, double photons, int k, std::uint64_t history) {
  // Only those near the origin matter to the nearest.
  const double radius = std::cbrt(k * (light.face ? 2 : 1) / (4.19 * photons));
  const double half = 1.7 * radius + 3 * radius / std::sqrt(k);
  const Vec3d low(light.face ? 0 : -half, -half, -half), side(light.face ? half : 2 * half, 2 * half, 2 * half);
  const Vec3d brightest(std::clamp(light.shift, low.x, low.x + side.x), 0, 0);
  const double most = light.fluence(brightest);
  Stream random(17, history, 3);
  const double wanted = photons * most * side.x * side.y * side.z;
  std::vector<Photon> photons_here, of_one;
  const double flicker = 1 + light.flicker * (2 * random.uniform() - 1);
  for (double reached = -std::log(random.uniform()); reached < wanted; reached -= std::log(random.uniform())) {
    const Vec3d y = low + Vec3d(random.uniform() * side.x, random.uniform() * side.y, random.uniform() * side.z);
    if (random.uniform() * most >= light.fluence(y)) continue;
    const auto batch = static_cast<std::uint16_t>(photons_here.size() % kBatches);
    const auto direction = encode_direction({0, 0, 1});
    photons_here.push_back({Vec3f(y), direction, static_cast<float>(flicker / photons), batch, 0});
    of_one.push_back({Vec3f(y), direction, static_cast<float>(1 / (photons * light.fluence(y))), batch, 0});
  }
  GatherSettings settings;
  settings.nearest = k;
  settings.edge_correction = light.edge_correction;
  const auto extinction = [&](const Vec3d& y) { return light.face && y.x < 0 ? 0.0 : 1.0; };
  const auto at = [&](std::vector<Photon> list) {
    return estimate(
               PhotonMap(std::move(list)), Vec3d(0), extinction, [](const Vec3d&) { return 1.0; }, settings)
        .value;
  };
  return {at(std::move(photons_here)), at(std::move(of_one))};
}

struct DensityErrors {
  double bias = 0, bias_error = 0;
  double noise = 0;
  double total = 0;
};
inline DensityErrors density_errors(const LocalLight& light, double photons, int k, int maps) {
  Moments difference, value;
  double squares = 0;
  for (int m = 0; m < maps; ++m) {
    const LocalEstimate e = local_estimate(light, photons, k, static_cast<std::uint64_t>(m));
    difference.add(e.value - e.of_one);
    value.add(e.value);
    squares += (e.value - 1) * (e.value - 1) / maps;
  }
  return {difference.mean(), difference.standard_error(), std::sqrt(value.variance()), std::sqrt(squares)};
}

/// Noise where k and photons grow alike, so that the ball stays the same.
inline std::vector<ErrorAt> density_noise(const LocalLight& light, int maps) {
  std::vector<ErrorAt> errors;
  for (const int k : {16, 32, 64, 128, 256, 512}) {
    errors.push_back(
        {static_cast<double>(k), density_errors(light, 20.0 * k, k, maps).noise, 1 / std::sqrt(2.0 * maps)});
  }
  return errors;
}

/// Bias over k / N, at k = 64.
inline std::vector<ErrorAt> density_bias(const LocalLight& light, int maps) {
  std::vector<ErrorAt> errors;
  for (const double share : {0.003, 0.006, 0.012, 0.025, 0.05, 0.1}) {
    const DensityErrors e = density_errors(light, 64 / share, 64, maps);
    errors.push_back({share, e.bias, e.bias_error / std::abs(e.bias)});
  }
  return errors;
}

/// Total error over N with k = factor N^exponent.
inline std::vector<ErrorAt> density_total(const LocalLight& light, double factor, double exponent, int maps) {
  std::vector<ErrorAt> errors;
  for (const double photons : {32.0, 128.0, 512.0, 2048.0, 8192.0}) {
    const int k = static_cast<int>(std::lround(factor * std::pow(photons, exponent)));
    errors.push_back({photons, density_errors(light, photons, k, maps).total, 1 / std::sqrt(2.0 * maps)});
  }
  return errors;
}

/// The path tracer's error over its work (flights), in a furnace whose radiance is 1 everywhere: through the rough
/// cloud of rough_cloud.h, over pixels and repetitions.
/// @param emission of the cloud; 1 is right
inline std::vector<ErrorAt> path_errors(double emission, int repeats) {
  WorldContents contents = grey_contents(rough_wish(0.8, 0.5, emission), 1);
  const World world(std::move(contents));
  constexpr int kPixels = 32;
  std::vector<ErrorAt> errors;
  std::uint64_t history = 0;
  for (const int samples : {4, 16, 64, 256}) {
    double squares = 0, work = 0;
    int count = 0;
    for (int repeat = 0; repeat < repeats; ++repeat) {
      std::vector<Ray> rays;
      std::vector<std::uint64_t> histories;
      for (int pixel = 0; pixel < kPixels; ++pixel) {
        Stream random(5, static_cast<std::uint64_t>(pixel), 1);
        const Vec3d at(0.3 + 2.6 * random.uniform(), 0.3 + 2.6 * random.uniform(), 1 + 2 * random.uniform());
        const Ray ray{at - 10.0 * Vec3d(0.2, 0.9, -0.1).normalized(), Vec3d(0.2, 0.9, -0.1).normalized(), 0, kInfinity};
        for (int s = 0; s < samples; ++s) {
          rays.push_back(ray);
          histories.push_back(history++);
        }
      }
      std::vector<Incoming> incoming(rays.size());
      const RadianceCounts counts = path_radiance({world, 0}, {}, rays, histories, incoming);
      work += static_cast<double>(counts.work[Work::gather]) / (repeats * kPixels);
      for (int pixel = 0; pixel < kPixels; ++pixel) {
        double mean = 0;
        for (int s = 0; s < samples; ++s)
          mean += incoming[static_cast<std::size_t>(pixel * samples + s)].total() / samples;
        squares += (mean - 1) * (mean - 1);
        ++count;
      }
    }
    errors.push_back({work, std::sqrt(squares / count), 1 / std::sqrt(2.0 * count)});
  }
  return errors;
}

/// The ordinates' error in what a slab reflects, over cells (at S_12) or over their order (at 64 cells).
inline double reflected(int cells, int order, double mu0, double g, AngularQuadrature quadrature, double depth = 2) {
  OrdinatesSettings settings = slab_settings(cells, order);
  settings.quadrature = quadrature;
  settings.tolerance = 1e-11;
  const PhaseFunction phase = g > 0 ? PhaseFunction::henyey_greenstein(g) : PhaseFunction();
  return slab_shares({{{depth, 0.9, phase}}, mu0}, settings).up;
}
inline std::vector<ErrorAt> ordinates_in_cells(AngularQuadrature quadrature = AngularQuadrature::double_gauss) {
  const double limit = reflected(512, 12, 0.5, 0, quadrature);
  std::vector<ErrorAt> errors;
  for (const int cells : {8, 16, 32, 64}) {
    errors.push_back({static_cast<double>(cells), reflected(cells, 12, 0.5, 0, quadrature) / limit - 1, 0});
  }
  return errors;
}
inline std::vector<ErrorAt> ordinates_in_angle(double g,
                                               AngularQuadrature quadrature = AngularQuadrature::double_gauss) {
  const double limit = reflected(64, 32, 0.5, g, quadrature);
  std::vector<ErrorAt> errors;
  for (const int order : {2, 4, 6, 8, 12, 16}) {
    errors.push_back({static_cast<double>(order), reflected(64, order, 0.5, g, quadrature) / limit - 1, 0});
  }
  return errors;
}

}  // namespace obscura::test
