// The photon map's radiances against the reference slabs and spheres: 1 % in the mean at default settings, and a
// bias that falls with photons and with k.
#include <catch2/catch.hpp>

#include "octree/base/low_discrepancy.h"
#include "photon/optics/sampling.h"
#include "photon/paths/radiance.h"
#include "photon/trace/light.h"
#include "tests/support/reference_rules.h"
#include "tests/support/reference_worlds.h"

using namespace obscura;
using namespace obscura::test;

namespace {

const char* const kMethod = "photon map";

struct MapRadiance {
  double mean = 0;
  double error = 0;
};

/// Mean over rays that ray_of(uniform numbers) makes: batches of the map and rays.
template <class RayOf>
MapRadiance map_average(const World& world, const Light& light, int count, const RadianceSettings& settings,
                        RayOf&& ray_of) {
  const LowDiscrepancy numbers(3, 0);
  std::vector<Ray> rays;
  std::vector<std::uint64_t> histories;
  for (int i = 0; i < count; ++i) {
    rays.push_back(ray_of(numbers.point(static_cast<std::uint32_t>(i))));
    histories.push_back(static_cast<std::uint64_t>(i));
  }
  std::vector<Incoming> incoming(rays.size());
  incoming_radiance({world, 0}, &light.maps[0], settings, rays, histories, incoming);
  Moments total;
  std::array<double, kBatches> batches{};
  for (const Incoming& in : incoming) {
    total.add(in.total());
    for (std::size_t b = 0; b < batches.size(); ++b) batches[b] += in.map[b] / count;
  }
  return {total.mean(), std::hypot(total.standard_error(), batch_mean(batches).standard_error)};
}

Light photons_of(const World& world, std::uint64_t photons) {
  TraceSettings settings;
  settings.photons = photons;
  return trace_light(world, settings);
}

}  // namespace

TEST_CASE("d1, d2: the photon map's radiances are right to 1 % in the mean at default settings",
          "[physics][reference][map]") {
  // A cell as wide as the slab is thick: the map's ball is small beside both.
  for (const char* file : {"d1_slab_isotropic_intensity.csv", "d2_slab_hg_intensity.csv"}) {
    const Csv csv = reference_table(file);
    Verified verified(file, kMethod, "radiances at mu0 >= 0.5, tau <= 5, w <= 0.99, g <= 0.75; 1e5 photons, k = 64",
                      "8 % each, 1 % in the mean");
    Moments deviation;
    double worst = 0;
    for (std::size_t row = 0; row < csv.size();) {
      const auto key = [&](std::size_t i) {
        return std::tuple(csv.number(i, "g"), csv.number(i, "tau"), csv.number(i, "w"), csv.number(i, "mu0"),
                          csv.has("phase") ? csv.text(i, "phase") : "");
      };
      std::size_t end = row;
      while (end < csv.size() && key(end) == key(row)) ++end;
      const auto number = [&](const char* column) { return csv.number(row, column); };
      if (number("tau") <= 5 && number("mu0") >= 0.5 && number("g") <= 0.75 && number("w") > 0.5 && number("w") < 1) {
        INFO(file << ", tau " << number("tau") << ", w " << number("w") << ", mu0 " << number("mu0") << ", g "
                  << number("g"));
        const World world(
            stack_contents({{{number("tau"), number("w"), row_phase(csv, row), 0}}, 1, number("mu0"), 0}));
        const Light light = photons_of(world, 100000);
        for (std::size_t i = row; i < end; ++i) {
          const double mu = csv.number(i, "mu"), phi = csv.has("phi_deg") ? csv.number(i, "phi_deg") * kPi / 180 : 0;
          const double sine = std::sqrt(1 - mu * mu);
          for (const bool up : {true, false}) {
            const double reference = csv.number(i, up ? "I_up_top" : "I_down_bottom");
            const MapRadiance found = map_average(world, light, 400, {}, [&](const auto& u) {
              const Vec3d travels(sine * std::cos(phi), sine * std::sin(phi), up ? mu : -mu);
              return Ray{{u[0], u[1], up ? 1.5 : -0.5}, -travels, 0, kInfinity};
            });
            INFO("mu " << mu << ", phi " << phi << (up ? " up " : " down ") << found.mean << " +- " << found.error
                       << " against " << reference);
            CHECK(verified.within(found.mean, reference, 0.08 + 4 * found.error / reference));
            deviation.add(found.mean / reference - 1);
            worst = std::max(worst, std::abs(found.mean / reference - 1));
          }
        }
      }
      row = end;
    }
    INFO("mean deviation " << deviation.mean() << " +- " << deviation.standard_error());
    CHECK(std::abs(deviation.mean()) < 0.01);
    char text[120];
    std::snprintf(text, sizeof text, "mean off by %+.2f %%, rms %.2f %%, worst %.1f %%", 100 * deviation.mean(),
                  100 * std::sqrt(deviation.variance()), 100 * worst);
    verified.note(text);
  }
}

TEST_CASE("d3: the photon map sees slabs emit, to 1 % in the mean", "[physics][reference][map]") {
  const Csv csv = reference_table("d3_slab_thermal.csv");
  Verified verified("d3_slab_thermal.csv", kMethod, "radiances upward, tau <= 5; 5e4 photons, k = 64",
                    "8 % each, 1 % in the mean");
  Moments deviation;
  double worst = 0;
  for (std::size_t row = 0; row < csv.size(); ++row) {
    const auto number = [&](const std::string& column) { return csv.number(row, column); };
    if (number("tau") > 5) continue;
    const Layer layer{number("tau"), number("w"), hg(number("g")), number("B_top")};
    const World world(number("B_top") == number("B_bot")
                          ? stack_contents({{layer}, 1, 0, 0})
                          : linear_source_contents(layer, number("B_top"), number("B_bot"), 32, 1));
    const Light light = photons_of(world, 50000);
    for (const char* mu : {"0.1", "0.5", "1"}) {
      const double cosine = std::atof(mu), reference = number(std::string("up_mu") + mu);
      const MapRadiance found = map_average(world, light, 400, {}, [&](const auto& u) {
        return Ray{{u[0], u[1], 1.5}, {-std::sqrt(1 - cosine * cosine), 0, -cosine}, 0, kInfinity};
      });
      INFO("row " << row << " mu " << mu << ": " << found.mean << " +- " << found.error << " against " << reference);
      CHECK(verified.within(found.mean, reference, 0.08 + 4 * found.error / reference));
      deviation.add(found.mean / reference - 1);
      worst = std::max(worst, std::abs(found.mean / reference - 1));
    }
  }
  INFO("mean deviation " << deviation.mean());
  CHECK(std::abs(deviation.mean()) < 0.01);
  char text[120];
  std::snprintf(text, sizeof text, "mean off by %+.2f %%, rms %.2f %%, worst %.1f %%", 100 * deviation.mean(),
                100 * std::sqrt(deviation.variance()), 100 * worst);
  verified.note(text);
}

TEST_CASE("d1: the photon map's bias falls with photons and with k", "[physics][reference][map]") {
  // A thick slab under a low sun: its light falls off within a small part of a mean free path, and the ball
  // reaches over the face. Few photons and many neighbours blur it; more photons or fewer neighbours do not.
  const Csv csv = reference_table("d1_slab_isotropic_intensity.csv");
  std::size_t row = 0;
  while (csv.number(row, "tau") != 16 || csv.number(row, "w") != 0.9 || csv.number(row, "mu0") != 0.1 ||
         csv.number(row, "mu") != 0.1)
    ++row;
  const double reference = csv.number(row, "I_up_top");
  const World world(stack_contents({{{16, 0.9, hg(0), 0}}, 1, 0.1, 0}));
  const auto off = [&](std::uint64_t photons, int nearest) {
    RadianceSettings settings;
    settings.gather.nearest = nearest;
    Moments mean;
    for (std::uint64_t seed = 1; seed <= 4; ++seed) {
      TraceSettings trace;
      trace.photons = photons;
      trace.seed = seed;
      const Light light = trace_light(world, trace);
      mean.add(map_average(
                   world, light, 4000, settings,
                   [&](const auto& u) {
                     return Ray{{u[0], u[1], 1.5}, {-std::sqrt(0.99), 0, -0.1}, 0, kInfinity};
                   }).mean /
                   reference -
               1);
    }
    return BatchMean{mean.mean(), mean.standard_error()};
  };
  const BatchMean few = off(2000, 256), some = off(16000, 256), many = off(128000, 256), narrow = off(2000, 32);
  INFO("2e3: " << few.mean << " +- " << few.standard_error << ", 16e3: " << some.mean << " +- " << some.standard_error
               << ", 128e3: " << many.mean << " +- " << many.standard_error << "; k 32: " << narrow.mean << " +- "
               << narrow.standard_error);
  CHECK(std::abs(some.mean) < 0.8 * std::abs(few.mean));
  CHECK(std::abs(many.mean) < 0.8 * std::abs(some.mean) + 2 * many.standard_error);
  CHECK(std::abs(narrow.mean) < 0.8 * std::abs(few.mean));
  CHECK(std::abs(few.mean) > 4 * few.standard_error);
  Verified verified("d1_slab_isotropic_intensity.csv", kMethod,
                    "bias at tau 16, w 0.9, mu0 = mu = 0.1: 2e3, 16e3, 128e3 photons at k = 256; 2e3 at k = 32",
                    "falls");
  verified.within(many.mean, 0, 1, 1);
  char text[160];
  std::snprintf(text, sizeof text, "%+.1f, %+.1f, %+.1f %% (+- %.1f); %+.1f %%", 100 * few.mean, 100 * some.mean,
                100 * many.mean, 100 * many.standard_error, 100 * narrow.mean);
  verified.note(text);
}

TEST_CASE("b2: the photon map sees spheres to 1 % in the mean", "[physics][reference][map]") {
  const Csv csv = reference_table("b2_sphere_isothermal_scattering.csv");
  Verified verified("b2_sphere_isothermal_scattering.csv", kMethod,
                    "radiance at cosines 0.7 and 1, R 0.5 to 5; 3e5 photons, 48 voxels across",
                    "4 % each, 1 % in the mean");
  Moments deviation;
  for (std::size_t row = 0; row < csv.size(); ++row) {
    const double radius = csv.number(row, "R"), albedo = csv.number(row, "w");
    if (radius < 0.3 || radius > 6 || albedo == 0 || albedo > 0.95) continue;
    WorldContents contents = sphere_contents(radius, albedo, hg(0), 48);
    contents.clouds[0].source = {1};
    const World world(std::move(contents));
    const Light light = photons_of(world, 300000);
    for (const char* mu : {"0.7", "1"}) {
      const double cosine = std::atof(mu), reference = csv.number(row, std::string("L_mu") + mu);
      const MapRadiance found = map_average(world, light, 1000, {}, [&](const auto& u) {
        const Vec3d travels = uniform_direction(u[0], u[1]);
        const auto [a, b] = orthonormal_basis(travels);
        const Vec3d through =
            radius * std::sqrt(1 - cosine * cosine) * (std::cos(2 * kPi * u[2]) * a + std::sin(2 * kPi * u[2]) * b);
        return Ray{through + 2 * radius * travels, -travels, 0, kInfinity};
      });
      INFO("R " << radius << ", w " << albedo << ", mu " << mu << ": " << found.mean << " +- " << found.error
                << " against " << reference);
      CHECK(verified.within(found.mean, reference, 0.04 + 4 * found.error / reference));
      deviation.add(found.mean / reference - 1);
    }
  }
  INFO("mean deviation " << deviation.mean());
  CHECK(std::abs(deviation.mean()) < 0.01);
  char text[120];
  std::snprintf(text, sizeof text, "mean off by %+.2f %%, rms %.2f %%", 100 * deviation.mean(),
                100 * std::sqrt(deviation.variance()));
  verified.note(text);
}
