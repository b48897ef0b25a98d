// Media without end and the searchlight: photons from a point and from a line, told by where they collide and
// what their light does next.
#include <catch2/catch.hpp>

#include "tests/support/photon_measures.h"
#include "tests/support/reference_rules.h"
#include "tests/support/reference_worlds.h"

using namespace obscura;
using namespace obscura::test;

namespace {

const char* const kMethod = "photon tracing";

/// Extinction 1 in a cube about the origin, too large for its faces to matter.
WorldContents boundless(double half_side, double albedo, const PhaseFunction& phase) {
  WorldContents contents = box_contents({1, 1, 1}, 2 * half_side, {{1, albedo}}, phase, [](const Vec3i&) { return 0; });
  contents.clouds[0].local_to_world = placement(Vec3d(-half_side), Vec3d(0), 1);
  return contents;
}

/// A glowing ball so small that it is a point: 1 W in all directions.
HotSphere point_source() {
  constexpr double kRadius = 1e-4;
  return {Vec3d(0), kRadius, {1 / (4 * kPi * kPi * kRadius * kRadius)}};
}

AgreeOptions rule(double reference, double error, double comparisons, double reference_error = 0) {
  return held_to(reference, error, comparisons, kManyBatches, reference_error);
}

/// Traces four times: kManyBatches independent batches, each with all the power.
template <class Visit>
void trace_many(const World& world, std::uint64_t photons, std::uint64_t seed, std::optional<int> depth,
                Visit&& visit) {
  for (int run = 0; run < kRuns; ++run) {
    TraceSettings settings;
    settings.photons = photons / kRuns;
    settings.seed = kRuns * seed + static_cast<std::uint64_t>(run);
    settings.scattering_depth = depth;
    visit(trace_photons({world, 0}, settings), static_cast<std::size_t>(kBatches * run));
  }
}

/// Attenuated length of a ray from x along d inside the ball of radius r about the origin, extinction 1.
double attenuated_in_ball(const Vec3d& x, const Vec3d& d, double r) {
  const double b = x.dot(d), c = x.length2() - r * r, root = b * b - c;
  if (root <= 0) return 0;
  const double far = -b + std::sqrt(root), near = std::max(0.0, -b - std::sqrt(root));
  return far > 0 ? std::exp(-near) - std::exp(-far) : 0.0;
}

}  // namespace

TEST_CASE("c1: the fluence about a point source", "[physics][reference][medium]") {
  const Csv csv = reference_table("c1_infinite_point_source_isotropic.csv");
  Verified verified("c1_infinite_point_source_isotropic.csv", kMethod,
                    "fluence at r <= 5, 0 < w < 1, expected over thin shells", "SE < 8 % each, 0.5 % together");
  for (const double albedo : {0.1, 0.5, 0.9, 0.99}) {
    WorldContents contents = boundless(150, albedo, hg(0));
    contents.particles.push_back(point_source());
    const World world(std::move(contents));
    constexpr double kThin = 0.02;  // half width of a shell over its radius
    std::vector<std::size_t> rows;
    for (std::size_t row = 0; row < csv.size(); ++row) {
      if (std::abs(csv.number(row, "w") - albedo) < 1e-12 && csv.number(row, "r") >= 0.1 && csv.number(row, "r") <= 5)
        rows.push_back(row);
    }
    REQUIRE(rows.size() == 5);
    std::vector<std::array<double, kManyBatches>> scattered(rows.size());
    for (auto& batches : scattered) batches.fill(0);
    trace_many(world, albedo > 0.95 ? 4000 : 24000, 1, {}, [&](const TraceResult& traced, std::size_t first) {
      scattered_light(world, traced.photons, [&](const Photon& photon, const Vec3d& x, const Vec3d& d, double power) {
        for (std::size_t i = 0; i < rows.size(); ++i) {
          const double r = csv.number(rows[i], "r"), in = r * (1 - kThin), out = r * (1 + kThin);
          const double volume = 4 * kPi / 3 * (out * out * out - in * in * in);
          scattered[i][first + photon.batch] +=
              kBatches * power * (attenuated_in_ball(x, d, out) - attenuated_in_ball(x, d, in)) / volume;
        }
      });
    });
    for (std::size_t i = 0; i < rows.size(); ++i) {
      INFO("w " << albedo << ", r " << csv.number(rows[i], "r"));
      const double reference = csv.number(rows[i], "fluence") - csv.number(rows[i], "uncollided");
      CHECK(verified.mean(batch_mean(scattered[i]), reference, rule(reference, 0.08 * reference, 20)));
    }
  }
  check_common(verified, 0.005);
}

TEST_CASE("c2: the moments of light about a point source", "[physics][reference][medium]") {
  const Csv csv = reference_table("c2_infinite_moments_hg.csv");
  Verified verified("c2_infinite_moments_hg.csv", kMethod, "number of collisions and mean square distance of every row",
                    "SE < 12 % (<r^2> 36 %) each, 0.3 % together");
  for (std::size_t row = 0; row < csv.size(); ++row) {
    const double albedo = csv.number(row, "w"), g = csv.number(row, "g");
    INFO("w " << albedo << ", g " << g);
    // Wide enough that nothing comes to the faces, within 40 times the root mean square distance.
    WorldContents contents = boundless(40 * std::sqrt(csv.number(row, "msd")), albedo, hg(g));
    contents.particles.push_back(point_source());
    const World world(std::move(contents));
    std::array<double, kManyBatches> collisions{}, squares{};
    trace_many(world,
               albedo > 0.995  ? 640
               : albedo > 0.95 ? 2000
                               : 12000,
               row, {}, [&](const TraceResult& traced, std::size_t first) {
                 for (const Photon& photon : traced.photons) {
                   const Vec3d x = transform_point(world.map_to_world(), Vec3d(photon.position));
                   collisions[first + photon.batch] += kBatches * static_cast<double>(photon.power);
                   squares[first + photon.batch] += kBatches * static_cast<double>(photon.power) * x.length2();
                 }
               });
    const double total = csv.number(row, "mean_collisions"), second = total * csv.number(row, "msd");
    const double loose = albedo > 0.995 ? 0.12 : albedo > 0.95 ? 0.06 : 0.03;
    CHECK(verified.mean(batch_mean(collisions), total, rule(total, loose * total, 48)));
    CHECK(verified.mean(batch_mean(squares), second, rule(second, 3 * loose * second, 48)));
  }
  check_common(verified, 0.003);
}

TEST_CASE("c3: where a photon is after n flights", "[physics][reference][medium]") {
  const Csv csv = reference_table("c3_random_walk_hg.csv");
  Verified verified("c3_random_walk_hg.csv", kMethod, "<z> and <r^2> after 1 to 100 flights, every row",
                    "SE < 4 % each, 0.2 % together");
  for (const double g : {-0.5, 0.0, 0.5, 0.85, 0.95, 0.999}) {
    WorldContents contents = boundless(2000, 1, hg(g));
    contents.beams.push_back({Vec3d(0), Vec3d(0, 0, 1), 1e-9, {1}});
    const World world(std::move(contents));
    for (std::size_t row = 0; row < csv.size(); ++row) {
      if (std::abs(csv.number(row, "g") - g) > 1e-12) continue;
      const int n = static_cast<int>(csv.number(row, "n"));
      INFO("g " << g << ", n " << n);
      std::array<double, kManyBatches> heights{}, squares{};
      trace_many(world, n > 10 ? 4000 : 20000, row, n, [&](const TraceResult& traced, std::size_t first) {
        for (const Photon& photon : traced.photons) {
          if (photon.collisions != n - 1) continue;
          const Vec3d x = transform_point(world.map_to_world(), Vec3d(photon.position));
          heights[first + photon.batch] += kBatches * static_cast<double>(photon.power) * x.z;
          squares[first + photon.batch] += kBatches * static_cast<double>(photon.power) * x.length2();
        }
      });
      const double z = csv.number(row, "mean_z"), r2 = csv.number(row, "msd");
      CHECK(verified.mean(batch_mean(heights), z, rule(z, std::max(0.02 * z, 0.03 * std::sqrt(r2)), 60)));
      CHECK(verified.mean(batch_mean(squares), r2, rule(r2, 0.04 * r2, 60)));
    }
  }
  check_common(verified, 0.002);
}

TEST_CASE("e3: a searchlight's rings", "[physics][reference][medium]") {
  const Csv csv = reference_table("e3_searchlight.csv");
  Verified verified("e3_searchlight.csv", kMethod,
                    "R and diffuse T of every ring, expected over the next flight; sums of r^2",
                    "SE < 20 % each ring, 0.4 % together");
  for (const char* name : {"pencil_P1", "pencil_P2"}) {
    std::size_t first_row = 0;
    while (csv.text(first_row, "case") != name) ++first_row;
    const double tau = csv.number(first_row, "tau");
    WorldContents contents = box_contents({1, 1, 1}, 1, {{1, csv.number(first_row, "w")}},
                                          hg(csv.number(first_row, "g")), [](const Vec3i&) { return 0; });
    contents.clouds[0].octree =
        exact_octree(lattice({1, 1, 1}, {4000, 4000, tau}, {"density"}, [](int, const Vec3i&) { return 1.0f; }));
    contents.clouds[0].local_to_world = placement({-2000, -2000, 0}, Vec3d(0), 1);
    contents.beams.push_back({Vec3d(0, 0, tau + 1), Vec3d(0, 0, -1), 1e-6, {1}});
    const World world(std::move(contents));
    std::vector<std::array<double, kManyBatches>> found(csv.size());
    for (auto& batches : found) batches.fill(0);
    trace_many(world, tau > 5 ? 24000 : 60000, 3, {}, [&](const TraceResult& traced, std::size_t first) {
      scattered_light(world, traced.photons, [&](const Photon& photon, const Vec3d& x, const Vec3d& d, double power) {
        const bool up = d.z > 0;
        const double flight = (up ? tau - x.z : -x.z) / d.z;
        const Vec3d exit = x + flight * d;
        const double r = std::hypot(exit.x, exit.y), escaped = kBatches * power * std::exp(-flight);
        for (std::size_t row = 0; row < csv.size(); ++row) {
          if (csv.text(row, "case") != name) continue;
          const std::string& quantity = csv.text(row, "quantity");
          const bool ring =
              quantity == (up ? "R" : "T_diffuse") && r >= csv.number(row, "r_in") && r < csv.number(row, "r_out");
          const bool moment = quantity == (up ? "R_r2" : "Tdiff_r2");
          if (ring || moment) found[row][first + photon.batch] += escaped * (moment ? r * r : 1);
        }
      });
    });
    for (std::size_t row = 0; row < csv.size(); ++row) {
      const std::string& quantity = csv.text(row, "quantity");
      if (csv.text(row, "case") != name || quantity == "A" || quantity == "T_direct") continue;
      INFO(name << " " << quantity << " from " << csv.text(row, "r_in") << " to " << csv.text(row, "r_out"));
      const double reference = csv.number(row, "value"), error = csv.number(row, "stderr");
      if (reference < 1e-4) continue;  // a dozen photons
      CHECK(verified.mean(batch_mean(found[row]), reference, rule(reference, 0.2 * reference, 44, error)));
    }
  }
  check_common(verified, 0.004);
}
