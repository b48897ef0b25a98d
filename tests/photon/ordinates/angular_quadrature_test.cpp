// Quadratures over directions against what they integrate exactly.
#include "photon/ordinates/angular_quadrature.h"

#include <catch2/catch.hpp>

#include "octree/base/error.h"

using namespace obscura;

namespace {

double double_factorial(int n) { return n < 2 ? 1.0 : n * double_factorial(n - 2); }

/// Integral of x^a y^b z^c over the sphere, even powers.
double moment(int a, int b, int c) {
  return 4 * kPi * double_factorial(a - 1) * double_factorial(b - 1) * double_factorial(c - 1) /
         double_factorial(a + b + c + 1);
}

double sum(const OrdinateSet& set, int a, int b, int c) {
  double result = 0;
  for (int i = 0; i < set.per_octant(); ++i) {
    const Vec3d& w = set.magnitude(i);
    result += 8 * set.weight(i) * std::pow(w.x, a) * std::pow(w.y, b) * std::pow(w.z, c);
  }
  return result;
}

constexpr AngularQuadrature kAll[] = {AngularQuadrature::product, AngularQuadrature::double_gauss,
                                      AngularQuadrature::level_symmetric};

}  // namespace

TEST_CASE("weights are positive, directions unit vectors, and the sphere has 4 pi", "[ordinates][quadrature]") {
  for (const AngularQuadrature kind : kAll) {
    for (int order = 2; order <= 32; order += 2) {
      const OrdinateSet set(kind, order);
      double whole = 0;
      for (int octant = 0; octant < 8; ++octant) {
        for (int i = 0; i < set.per_octant(); ++i) {
          REQUIRE(set.weight(i) > 0);
          const Vec3d w = set.direction(octant, i);
          REQUIRE(std::abs(w.length() - 1) < 1e-14);
          for (int axis = 0; axis < 3; ++axis) REQUIRE((w[axis] < 0) == ((octant >> axis & 1) == 1));
          whole += set.weight(i);
        }
      }
      CHECK(std::abs(whole - 4 * kPi) < 1e-12);
    }
  }
}

TEST_CASE("polynomials are integrated exactly up to each quadrature's degree", "[ordinates][quadrature]") {
  for (const AngularQuadrature kind : kAll) {
    for (const int order : {4, 8, 12, 16, 20, 32}) {
      const OrdinateSet set(kind, order);
      // Gauss-Legendre reaches 2 N - 1, each hemisphere by itself and level-symmetric sets about N.
      const int degree = kind == AngularQuadrature::product        ? 2 * order - 2
                         : kind == AngularQuadrature::double_gauss ? order - 2
                                                                   : order - 2;
      for (int a = 0; a <= degree; a += 2) {
        for (int b = 0; a + b <= degree; b += 2) {
          for (int c = 0; a + b + c <= degree; c += 2) {
            INFO("kind " << static_cast<int>(kind) << " order " << order << " x^" << a << " y^" << b << " z^" << c);
            // The sets behind LQn have few azimuths near the pole, where their error hardly weighs.
            const bool few = kind == AngularQuadrature::level_symmetric && order >= 20 && a + b > 8;
            CHECK(std::abs(sum(set, a, b, c) / moment(a, b, c) - 1) < (few ? 1e-5 : 1e-11));
          }
        }
      }
    }
  }
}

TEST_CASE("first moments of hemispheres are exact about z in double Gauss sets, and near pi elsewhere",
          "[ordinates][quadrature]") {
  for (const int order : {4, 8, 16, 32}) {
    CHECK(std::abs(OrdinateSet(AngularQuadrature::double_gauss, order).half_flux(2) - kPi) < 1e-12);
    for (const AngularQuadrature kind : kAll) {
      for (int axis = 0; axis < 3; ++axis)
        CHECK(std::abs(OrdinateSet(kind, order).half_flux(axis) / kPi - 1) < 0.8 / order);
    }
  }
}

TEST_CASE("LQn sets are alike along all axes and have the published levels", "[ordinates][quadrature]") {
  // Lewis & Miller, Computational Methods of Neutron Transport, table 4-1.
  const OrdinateSet s8(AngularQuadrature::level_symmetric, 8);
  CHECK(s8.per_octant() == 10);
  CHECK(s8.magnitude(0).z == Approx(0.2182179).epsilon(1e-6));
  CHECK(s8.weight(0) / (0.5 * kPi) == Approx(0.1209877).epsilon(1e-6));
  const OrdinateSet s12(AngularQuadrature::level_symmetric, 12);
  CHECK(s12.magnitude(0).z == Approx(0.1672126).epsilon(1e-6));
  for (int order = 2; order <= 18; order += 2) {
    const OrdinateSet set(AngularQuadrature::level_symmetric, order);
    CHECK(set.per_octant() == order * (order + 2) / 8);
    for (const int power : {1, 4, 7}) {
      CHECK(sum(set, power, 0, 0) == Approx(sum(set, 0, power, 0)).epsilon(1e-12));
      CHECK(sum(set, power, 0, 0) == Approx(sum(set, 0, 0, power)).epsilon(1e-12));
    }
  }
}

TEST_CASE("harmonics are orthonormal and add up to Legendre's polynomials", "[ordinates][quadrature]") {
  constexpr int kOrder = 7, kCount = (kOrder + 1) * (kOrder + 1);
  const OrdinateSet set(AngularQuadrature::product, 8);
  std::vector<double> products(kCount * kCount), y(kCount), other(kCount);
  for (int octant = 0; octant < 8; ++octant) {
    for (int i = 0; i < set.per_octant(); ++i) {
      spherical_harmonics(set.direction(octant, i), kOrder, y.data());
      for (std::size_t m = 0; m < kCount; ++m) {
        for (std::size_t n = 0; n < kCount; ++n) products[m * kCount + n] += set.weight(i) * y[m] * y[n];
      }
    }
  }
  for (std::size_t m = 0; m < kCount; ++m) {
    for (std::size_t n = 0; n < kCount; ++n) REQUIRE(std::abs(products[m * kCount + n] - (m == n ? 1 : 0)) < 1e-12);
  }
  const Vec3d a = Vec3d(0.3, -0.5, 0.7).normalized(), b = Vec3d(-0.2, 0.9, 0.1).normalized();
  spherical_harmonics(a, kOrder, y.data());
  spherical_harmonics(b, kOrder, other.data());
  for (int l = 0; l <= kOrder; ++l) {
    double added = 0;
    for (int m = l * l; m < (l + 1) * (l + 1); ++m)
      added += y[static_cast<std::size_t>(m)] * other[static_cast<std::size_t>(m)];
    CHECK(4 * kPi / (2 * l + 1) * added == Approx(std::legendre(static_cast<unsigned>(l), a.dot(b))).margin(1e-13));
  }
}

TEST_CASE("odd orders and orders out of range are refused", "[ordinates][quadrature]") {
  for (const int order : {-2, 0, 1, 7, 34}) {
    CHECK_THROWS_AS(OrdinateSet(AngularQuadrature::product, order), InputError);
    CHECK_THROWS_AS(OrdinateSet(AngularQuadrature::level_symmetric, order), InputError);
  }
}
