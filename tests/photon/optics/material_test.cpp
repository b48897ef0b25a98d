// Materials: Kirchhoff's law at an angle, the Lambertian part and the rough mirror.
#include "photon/optics/material.h"

#include <catch2/catch.hpp>

#include "photon/optics/sampling.h"
#include "tests/support/agree.h"
#include "tests/support/chi_square.h"
#include "tests/support/shapes_of_surfaces.h"
#include "tests/support/voxel_fields.h"

using namespace obscura;
using namespace obscura::test;

namespace {

Material by_angle(double emissivity) {
  Material material = grey_material(emissivity);
  material.angle_deg = {10, 40, 80};
  material.angle_factor = {1, 3, 0.2};
  return material;
}

double cos_deg(double degrees) { return std::cos(degrees * kPi / 180); }

/// Over a cosine-weighted hemisphere, by the midpoint rule in the angle.
template <class F>
double cosine_mean(F&& f, int steps = 200000) {
  double sum = 0;
  for (int i = 0; i < steps; ++i) {
    const double angle = 0.5 * kPi * (i + 0.5) / steps;
    sum += f(std::cos(angle)) * 2 * std::cos(angle) * std::sin(angle) * 0.5 * kPi / steps;
  }
  return sum;
}

/// Where a mirror of normal z sends it.
Vec3d mirrored(const Vec3d& arriving) { return {arriving.x, arriving.y, -arriving.z}; }

/// Integral over the unit disc of the normal law about (x, y): the share that a rough mirror scatters.
double scattered_share(double x, double y, double roughness) {
  constexpr int kSteps = 1000;
  double sum = 0;
  for (int i = 0; i < kSteps; ++i) {
    const double dx = -1 + 2 * (i + 0.5) / kSteps;
    const double half = std::sqrt(1 - dx * dx);
    // Along y exactly, by the error function.
    const double scale = 1 / (std::sqrt(2.0) * roughness);
    const double inner = 0.5 * (std::erf((half - y) * scale) - std::erf((-half - y) * scale));
    const double z = (dx - x) / roughness;
    sum += inner * std::exp(-0.5 * z * z) / (std::sqrt(2 * kPi) * roughness) * 2 / kSteps;
  }
  return sum;
}

}  // namespace

TEST_CASE("emissivity is linear in the angle between its values, constant outside, and cut at 1",
          "[photon][material]") {
  const MaterialOptics optics(by_angle(0.5), 0);
  CHECK(optics.emissivity(1) == 0.5);
  CHECK(optics.emissivity(cos_deg(5)) == 0.5);
  CHECK(optics.emissivity(cos_deg(15)) == Approx(0.5 * (1 + 2 / 6.0)).epsilon(1e-12));
  CHECK(optics.emissivity(cos_deg(22)) == Approx(0.5 * 1.8).epsilon(1e-12));
  CHECK(optics.emissivity(cos_deg(30)) == 1);  // 0.5 times 2.33
  CHECK(optics.emissivity(cos_deg(40)) == 1);
  CHECK(optics.emissivity(cos_deg(60)) == Approx(0.5 * 1.6).epsilon(1e-12));
  CHECK(optics.emissivity(cos_deg(70)) == Approx(0.5 * (3 - 0.75 * 2.8)).epsilon(1e-12));
  CHECK(optics.emissivity(cos_deg(85)) == Approx(0.1).epsilon(1e-12));
  CHECK(optics.emissivity(0) == Approx(0.1).epsilon(1e-12));
  for (const double degrees : {0.0, 15.0, 60.0, 90.0}) {
    CHECK(optics.reflectance(cos_deg(degrees)) + optics.emissivity(cos_deg(degrees)) == 1);
  }
  // Without a table all angles are alike; each interval has its own value.
  Material plain;
  plain.emissivity = {0.3, 0.8};
  plain.permeable = 0.25;
  plain.specular = 0.5;
  plain.roughness = 0.125;
  const MaterialOptics second(plain, 1);
  CHECK(second.emissivity(0.1) == 0.8);
  CHECK(second.hemispherical_emissivity() == Approx(0.8).epsilon(1e-15));
  CHECK(second.permeable() == 0.25);
  CHECK(second.specular() == 0.5);
  CHECK(second.roughness() == 0.125);
  CHECK(second.reflects());
  CHECK_FALSE(MaterialOptics(grey_material(1), 0).reflects());
}

TEST_CASE("hemispherical emissivity is the cosine-weighted mean of the angles'", "[photon][material]") {
  for (const double emissivity : {0.1, 0.5, 0.9, 1.0}) {
    const MaterialOptics optics(by_angle(emissivity), 0);
    const double mean = cosine_mean([&](double cosine) { return optics.emissivity(cosine); });
    CHECK(optics.hemispherical_emissivity() == Approx(mean).epsilon(1e-5));
    // The mean over the angle itself would be another.
    CHECK(optics.hemispherical_emissivity() != Approx(optics.emissivity(std::sqrt(0.5))).epsilon(1e-2));
  }
}

TEST_CASE("the Lambertian part is reciprocal and reflects exactly what is not emitted", "[photon][material]") {
  for (const Material& material : {by_angle(0.5), by_angle(0.2), grey_material(0.3)}) {
    const MaterialOptics optics(material, 0);
    for (const double in : {1.0, 0.8, 0.5, 0.05}) {
      for (const double out : {1.0, 0.6, 0.2})
        CHECK(optics.diffuse(in, out) == Approx(optics.diffuse(out, in)).epsilon(1e-14));
      const double albedo = kPi * cosine_mean([&](double out) { return optics.diffuse(in, out); });
      CHECK(albedo == Approx(optics.reflectance(in)).epsilon(1e-5));
    }
  }
  CHECK(MaterialOptics(grey_material(0.3), 0).diffuse(0.2, 0.7) == Approx(0.7 / kPi).epsilon(1e-14));
}

TEST_CASE("a perfect mirror reflects in its normal and has no density", "[photon][material]") {
  Stream random(1, 0, 0);
  for (int i = 0; i < 1000; ++i) {
    const Vec3d normal = random_direction(random);
    Vec3d arriving = random_direction(random);
    if (arriving.dot(normal) > 0) arriving = -arriving;
    bool exact = false;
    const Vec3d leaving = mirror_direction(arriving, normal, 0, random, exact);
    CHECK(exact);
    CHECK(leaving.dot(normal) == Approx(-arriving.dot(normal)).margin(1e-14));
    CHECK((leaving - arriving).cross(normal).length() < 1e-14);
    CHECK(leaving.length() == Approx(1).epsilon(1e-14));
    CHECK(rough_mirror(arriving, normal, 0, leaving) == 0);
  }
}

TEST_CASE("a rough mirror scatters by its density, and leaves exact what would go below", "[photon][material]") {
  constexpr int kSamples = 200000;
  const Vec3d normal(0, 0, 1);
  for (const double roughness : {0.15, 0.5}) {
    for (const double angle : {0.0, 45.0, 80.0}) {
      const Vec3d arriving(0.8 * std::sin(angle * kPi / 180), -0.6 * std::sin(angle * kPi / 180), -cos_deg(angle));
      const Vec3d middle = mirrored(arriving);
      INFO("roughness " << roughness << ", angle " << angle);
      Stream random(7, static_cast<std::uint64_t>(angle), 0);
      std::vector<Vec3d> scattered;
      double exact_count = 0, worst = 0, lowest = 1;
      for (int i = 0; i < kSamples; ++i) {
        bool exact;
        const Vec3d leaving = mirror_direction(arriving, normal, roughness, random, exact);
        worst = std::max(worst, std::abs(leaving.length() - 1));
        if (exact) {
          worst = std::max(worst, (leaving - middle).length());
          exact_count += 1;
        } else {
          lowest = std::min(lowest, leaving.z);
          scattered.push_back(leaving);
        }
      }
      CHECK(worst < 1e-12);
      CHECK(lowest > 0);
      // What is scattered and what is not add up to everything that comes.
      const double share = scattered_share(middle.x, middle.y, roughness);
      CHECK(chi_square({exact_count, kSamples - exact_count}, {(1 - share) * kSamples, share * kSamples}, 6));
      std::size_t next = 0;
      CHECK(chi_square_directions(
          [&] { return scattered[next++]; },
          [&](const Vec3d& w) { return rough_mirror(arriving, normal, roughness, w) * std::max(w.z, 0.0) / share; },
          static_cast<int>(scattered.size()), 32, 16, 12, 6));
      // The density with a wrong roughness is found out.
      next = 0;
      const double wrong = 1.1 * roughness, wrong_share = scattered_share(middle.x, middle.y, wrong);
      CHECK(!chi_square_directions(
          [&] { return scattered[next++]; },
          [&](const Vec3d& w) { return rough_mirror(arriving, normal, wrong, w) * std::max(w.z, 0.0) / wrong_share; },
          static_cast<int>(scattered.size()), 32, 16, 12, 6));
    }
  }
}

TEST_CASE("a rough mirror's density is the same there and back, whichever way it lies", "[photon][material]") {
  Stream random(2, 0, 0);
  int above = 0;
  for (int i = 0; i < 1000; ++i) {
    const Vec3d normal = random_direction(random);
    Vec3d arriving = random_direction(random);
    if (arriving.dot(normal) > 0) arriving = -arriving;
    const Vec3d leaving = random_direction(random);
    const double there = rough_mirror(arriving, normal, 0.4, leaving);
    if (leaving.dot(normal) <= 0) {
      CHECK(there == 0);
      continue;
    }
    ++above;
    CHECK(there == Approx(rough_mirror(-leaving, normal, 0.4, -arriving)).epsilon(1e-9));
    // Turned with the surface it is the same: by coordinates in the surface's plane.
    const auto [a, b] = orthonormal_basis(normal);
    const double dx = leaving.dot(a) - arriving.dot(a), dy = leaving.dot(b) - arriving.dot(b);
    CHECK(there == Approx(std::exp(-0.5 * (dx * dx + dy * dy) / 0.16) / (2 * kPi * 0.16)).epsilon(1e-9));
  }
  CHECK(above > 400);
}

TEST_CASE("Lambertian light stays Lambertian on a rough mirror", "[photon][material]") {
  // A symmetric kernel that loses nothing leaves the even light of a furnace as it is.
  constexpr int kSamples = 400000;
  for (const double roughness : {0.1, 0.7}) {
    Stream random(3, 0, 0);
    const Vec3d normal(0, 0, 1);
    const auto draw = [&] {
      const double u = random.uniform();
      const Vec3d arriving = -cosine_direction(normal, u, random.uniform());
      bool exact;
      return mirror_direction(arriving, normal, roughness, random, exact);
    };
    CHECK(chi_square_directions(
        draw, [](const Vec3d& w) { return std::max(w.z, 0.0) / kPi; }, kSamples, 32, 8, 16, 2));
  }
}
