// Ray integrals through the octree against the exact solutions a1, a3 to a5, a7 and a8, converging with the voxel at
// the order that theory predicts.
#include <array>
#include <catch2/catch.hpp>
#include <cmath>

#include "octree/base/statistics.h"
#include "octree/source/shapes.h"
#include "photon/optics/planck.h"
#include "tests/physics/ray_tables.h"
#include "tests/support/csv.h"
#include "tests/support/ray_radiance.h"
#include "tests/support/verified.h"

using namespace obscura;
using namespace obscura::test;

TEST_CASE("a1: chords of a voxelised sphere converge at first order or better", "[physics][ray]") {
  const Csv csv = table("a1_sphere_chord.csv");
  const double steps[] = {1.0 / 8, 1.0 / 16, 1.0 / 32, 1.0 / 64};
  std::vector<Octree> trees;
  std::string found;
  for (const double h : steps) trees.push_back(lossless(sphere_stream(1, h)));

  for (const double b : {0.0, 0.5, 0.99, 0.999999}) {
    std::vector<double> rms;
    for (std::size_t level = 0; level < trees.size(); ++level) {
      // Rays of this distance from the centre in 400 orientations.
      Stream stream(1, static_cast<std::uint64_t>(level), 0);
      const double chord = 2 * std::sqrt((1 - b) * (1 + b));
      double sum = 0;
      for (int i = 0; i < 400; ++i) {
        const double z = 2 * stream.uniform() - 1, phi = 2 * kPi * stream.uniform();
        const double sine = std::sqrt(1 - z * z), turn = 2 * kPi * stream.uniform();
        const Vec3d w(sine * std::cos(phi), sine * std::sin(phi), z);
        const auto [u, v] = orthonormal_basis(w);
        const Ray ray = line(b * (std::cos(turn) * u + std::sin(turn) * v) - 3.0 * w, w);
        const double error = depth_along(trees[level], ray) - chord;
        sum += error * error;
      }
      rms.push_back(std::sqrt(sum / 400));
    }
    const double order = std::log2(rms.front() / rms.back()) / 3;
    INFO("b " << b << ", rms errors " << rms[0] << " " << rms[1] << " " << rms[2] << " " << rms[3]);
    // A grazing ray sees border cells alone: its chord goes with the square root of their width.
    CHECK(order > (b < 0.9 ? 0.98 : 0.48));
    CHECK(rms.back() < (b < 0.9 ? 0.003 : 0.1));
    char text[60];
    std::snprintf(text, sizeof text, "%sb %g: %.2f", found.empty() ? "" : ", ", b, order);
    found += text;
  }
  Verified verified = verified_walk("a1_sphere_chord.csv", "order of convergence of chords, voxels 1/8 to 1/64",
                                    "1 (grazing 1/2); radiance of the voxels' chord 1e-12");
  verified.within(1, 1, 1);
  verified.note("order at " + found);

  // Radiance through the same voxels, whatever the optical depth: closed form of the voxels' chord.
  for (std::size_t i = 0; i < csv.size(); ++i) {
    const double k = csv.number(i, "k"), b = csv.number(i, "b");
    const Ray ray = line(Vec3d(b, 0.001, -3), Vec3d(0, 0, 1));
    const Gathered g = gather(
        trees[2], ray, [k](const Walk& w) { return k * w.value(0); }, constant(kSource));
    const double tau = k * depth_along(trees[2], ray);
    CHECK(g.radiance == Approx(-kSource * std::expm1(-tau)).epsilon(1e-12));
    // Where a thick sphere is well met, the border does not matter.
    if (k >= 10 && b < 0.9) CHECK(g.radiance == Approx(csv.number(i, "I_noback")).epsilon(1e-6));
    if (b < 0.9) CHECK(tau == Approx(csv.number(i, "tau")).epsilon(0.02));
  }
}

TEST_CASE("a3: a source linear in depth converges at second order, linear weights are exact", "[physics][ray]") {
  const Csv csv = table("a3_linear_source_slab.csv");
  Verified verified = verified_walk("a3_linear_source_slab.csv",
                                    "linear weights at node values, every row; voxels are of order 2 +- 0.1", "1e-12");
  for (std::size_t i = 0; i < csv.size(); ++i) {
    const double tau = csv.number(i, "tau"), b0 = csv.number(i, "B0"), b1 = csv.number(i, "B1");
    const double reference = csv.number(i, "I_noback");
    INFO("tau " << tau << ", B " << b0 << " to " << b1);
    const auto radiance = [&](int n, double shift) {
      const Octree tree = column(
          n, 1, {"density", "B"}, [&](int c, double share) { return c == 0 ? 1.0 : b0 + (b1 - b0) * share; }, shift);
      return gather(
                 tree, kUp, [tau](const Walk& w) { return tau * w.value(0); }, channel(1))
          .radiance;
    };
    std::vector<double> errors, shifted;
    for (const int n : {32, 64, 128}) {
      errors.push_back(radiance(n, 0) - reference);
      shifted.push_back(radiance(n, 0.5) - reference);
    }
    if (tau >= 0.1 && tau <= 10) {
      for (const double order : orders(errors)) CHECK(order == Approx(2).margin(0.1));
      // The source of the voxel's end in place of its middle's: first order only.
      for (const double order : orders(shifted)) CHECK(order == Approx(1).margin(0.25));
    }
    // Thinner, the sum of the middles is exact; thicker, the eye sees half of the first voxel.
    if (tau < 1e-4) CHECK(std::abs(errors.back()) < 1e-6 * reference);
    CHECK(std::abs(errors.back()) <= std::abs(b1 - b0) * (0.5 / 128 + 1e-6));

    // Node values with the linear weights: exact at any voxel.
    for (const int n : {1, 7, 100}) {
      double sum = 0;
      for (int s = 0; s < n; ++s) {
        const LinearSourceWeights w = linear_source_weights(tau / n);
        const double near = b0 + (b1 - b0) * s / n, far = b0 + (b1 - b0) * (s + 1) / n;
        sum += std::exp(-tau * s / n) * (w.near * near + w.far * far);
      }
      CHECK(relative(sum, reference) < 1e-12);
      verified.within(sum, reference, 1e-12);
    }
  }
}

TEST_CASE("a4: a linear temperature converges at second order", "[physics][ray]") {
  const Csv csv = table("a4_linear_temperature_planck.csv");
  Verified verified = verified_walk("a4_linear_temperature_planck.csv",
                                    "256 voxels against I_exact, every row; order 2 +- 0.1", "1e-4");
  Verified linear =
      verified_walk("a4_linear_temperature_planck.csv", "one segment of linear B against I_linB, every row", "1e-12");
  for (std::size_t i = 0; i < csv.size(); ++i) {
    const double t0 = csv.number(i, "T0_K"), t1 = csv.number(i, "T1_K"), tau = csv.number(i, "tau");
    const double um = csv.number(i, "lambda_m") * 1e6;
    const double reference = csv.number(i, "I_exact") * 1e-6;
    INFO("tau " << tau << ", " << t0 << " to " << t1 << " K, " << um << " um");
    const auto radiance = [&](int n, double shift) {
      const Octree tree = column(
          n, 1, {"K"}, [&](int, double share) { return t0 + (t1 - t0) * share; }, shift);
      return gather(tree, kUp, constant(tau), [um](const Walk& w) { return planck_spectral(um, w.value(0)); }).radiance;
    };
    std::vector<double> errors, shifted;
    for (const int n : {64, 128, 256}) {
      errors.push_back(relative(radiance(n, 0), reference));
      shifted.push_back(relative(radiance(n, 0.5), reference));
    }
    if (errors.back() > 2e-6) {
      for (const double order : orders(errors)) CHECK(order == Approx(2).margin(0.1));
      for (const double order : orders(shifted)) CHECK(order == Approx(1).margin(0.25));
    }
    // Planck linear between the faces is another (wrong) model, with known values.
    const LinearSourceWeights w = linear_source_weights(tau);
    CHECK(w.near * planck_spectral(um, t0) + w.far * planck_spectral(um, t1) ==
          Approx(1e-6 * csv.number(i, "I_linB")).epsilon(1e-12));
    linear.within(w.near * planck_spectral(um, t0) + w.far * planck_spectral(um, t1), 1e-6 * csv.number(i, "I_linB"),
                  1e-12);
    verified.within(radiance(256, 0), reference, 1e-4);
    // Single precision of the temperature is worth 5e-7 of the radiance.
    CHECK(errors.back() < 1e-4);
  }
}

TEST_CASE("a5: linear extinction is exact in depth and second order in radiance", "[physics][ray]") {
  const Csv csv = table("a5_linear_extinction.csv");
  Verified verified = verified_walk("a5_linear_extinction.csv",
                                    "depth of every row, single-precision voxels; radiance of order 2 +- 0.2", "1e-7");
  for (std::size_t i = 0; i < csv.size(); ++i) {
    const double k0 = csv.number(i, "k0"), k1 = csv.number(i, "k1"), d = csv.number(i, "D");
    INFO("k " << k0 << " to " << k1 << " over " << d << " m");
    std::vector<double> errors, shifted;
    for (const int n : {256, 512, 1024}) {
      const auto make = [&](double shift) {
        return column(
            n, d, {"k", "B"}, [&](int c, double share) { return c == 0 ? k0 + (k1 - k0) * share : 1 + 2 * share; },
            shift);
      };
      const Octree tree = make(0);
      // A voxel's middle is its mean: the depth of the whole is exact, to single precision.
      CHECK(depth_along(tree, kUp) == Approx(csv.number(i, "tau")).epsilon(1e-7));
      verified.within(depth_along(tree, kUp), csv.number(i, "tau"), 1e-7);
      const Gathered iso = gather(tree, kUp, channel(0), constant(kSource));
      CHECK(iso.radiance + iso.transmission() * kBackground == Approx(csv.number(i, "I_isoB")).epsilon(1e-7));
      errors.push_back(relative(gather(tree, kUp, channel(0), channel(1)).radiance, csv.number(i, "I_linB")));
      shifted.push_back(relative(gather(make(0.5), kUp, channel(0), channel(1)).radiance, csv.number(i, "I_linB")));
    }
    if (errors.back() > 2e-7) {
      for (const double order : orders(errors)) CHECK(order == Approx(2).margin(0.2));
      for (const double order : orders(shifted)) CHECK(order == Approx(1).margin(0.25));
    }
    CHECK(errors.back() < 1e-4);
  }
}

TEST_CASE("a8: an exponential atmosphere is exact from voxel means, second order from middles", "[physics][ray]") {
  const Csv csv = table("a8_exponential_atmosphere.csv");
  Verified verified =
      verified_walk("a8_exponential_atmosphere.csv",
                    "depth from voxel means, every row, single precision; middles are of order 2 +- 0.05", "1e-7");
  for (std::size_t i = 0; i < csv.size(); ++i) {
    const double k0 = csv.number(i, "k0"), height = csv.number(i, "H"), mu = csv.number(i, "mu");
    const double tau = csv.number(i, "tau");
    INFO("k0 " << k0 << ", H " << height << ", mu " << mu);
    // From the ground to 40 scale heights above z = 1, which is a voxel's face; wide enough for any
    // slant.
    const double top = 1 + 40 * height;
    const int per_metre_min = static_cast<int>(std::ceil(16 / height));
    std::vector<double> errors;
    for (const int factor : {1, 2, 4}) {
      const double h = 1.0 / (per_metre_min * factor);
      const int n = static_cast<int>(std::ceil(top / h));
      const auto make = [&](bool mean) {
        return lossless(field_stream(
            Box3i(Vec3i(0, 0, 0), Vec3i(1, 1, n)), {"k"},
            [=](int, const Vec3i& v) {
              const double middle = (v.z + 0.5) * h;
              const double spread = mean ? std::sinh(0.5 * h / height) / (0.5 * h / height) : 1;
              return static_cast<float>(k0 * std::exp(-middle / height) * spread);
            },
            scaled(Vec3d(1e7, 1e7, h), Vec3d(-5e6, -5e6, 0))));
      };
      const Ray ray = line(Vec3d(0, 0, 1), Vec3d(std::sqrt((1 - mu) * (1 + mu)), 0, mu));
      const Octree means = make(true);
      CHECK(depth_along(means, ray) == Approx(tau).epsilon(1e-7));
      verified.within(depth_along(means, ray), tau, 1e-7);
      const Gathered g = gather(means, ray, channel(0), constant(1));
      CHECK(g.transmission() == Approx(csv.number(i, "T")).epsilon(1e-6));
      CHECK(g.radiance == Approx(csv.number(i, "E")).epsilon(1e-6));
      errors.push_back(relative(depth_along(make(false), ray), tau));
    }
    for (const double order : orders(errors)) CHECK(order == Approx(2).margin(0.05));
  }
}

namespace {

struct Blob {
  double k0;
  Vec3d centre;
  double sigma;
};

const std::vector<std::vector<Blob>> kBlobs = {{{1, {0, 0, 0}, 0.5}},
                                               {{4, {0.3, -0.2, 0.1}, 0.25}, {2, {-0.4, 0.3, 0}, 0.6}},
                                               {{1e-10, {0, 0, 0}, 1}},
                                               {{1e4, {0, 0, 0}, 1}}};

// The blobs on a lattice of n^3 voxels of width h, each voxel with its exact mean.
Octree blob_tree(const std::vector<Blob>& blobs, int n, double h, const Vec3d& corner) {
  // A Gaussian is a product, so its mean is one of means along the axes.
  std::vector<std::array<std::vector<double>, 3>> means(blobs.size());
  for (std::size_t b = 0; b < blobs.size(); ++b) {
    const double scale = 1 / (std::sqrt(2.0) * blobs[b].sigma);
    for (int axis = 0; axis < 3; ++axis) {
      for (int i = 0; i < n; ++i) {
        const double low = corner[axis] + h * i - blobs[b].centre[axis];
        means[b][static_cast<std::size_t>(axis)].push_back(blobs[b].sigma * std::sqrt(kPi / 2) *
                                                           (std::erf((low + h) * scale) - std::erf(low * scale)) / h);
      }
    }
  }
  return lossless(field_stream(
      Box3i(Vec3i(0, 0, 0), Vec3i(n, n, n)), {"k"},
      [&](int, const Vec3i& v) {
        double sum = 0;
        for (std::size_t b = 0; b < blobs.size(); ++b) {
          const auto at = [&](std::size_t axis, int i) { return means[b][axis][static_cast<std::size_t>(i)]; };
          sum += blobs[b].k0 * at(0, v.x) * at(1, v.y) * at(2, v.z);
        }
        return static_cast<float>(sum);
      },
      scaled(Vec3d(h), corner)));
}

// Mean error of the depth over nine places of the lattice beside the ray, over the depth. A single
// line sees the voxels beside it and errs to first order, by either sign; the mean is second order.
// @param offset moves the field against its lattice, in voxels
double mean_error(const std::vector<Blob>& blobs, const Ray& ray, double tau, int n, double offset) {
  const double h = 7.0 / n;
  Moments error;
  for (int a = 0; a < 3; ++a) {
    for (int b = 0; b < 3; ++b) {
      const Vec3d phase((a + 0.5) / 3, (b + 0.5) / 3, ((a + b) % 3 + 0.5) / 3);
      Vec3d corner;
      for (int axis = 0; axis < 3; ++axis) {
        const double voxels = std::round((-3.5 - ray.origin[axis]) / h);
        corner[axis] = ray.origin[axis] + h * (voxels - phase[axis]);
      }
      Ray seen = ray;
      seen.origin += Vec3d(offset * h);
      error.add(depth_along(blob_tree(blobs, n, h, corner), seen) / tau - 1);
    }
  }
  return std::abs(error.mean());
}

}  // namespace

TEST_CASE("a7: lines through Gaussian blobs converge at second order", "[physics][ray]") {
  const Csv csv = table("a7_gaussian_blob_lines.csv");
  Moments coarse, fine, shifted;  // of the squared errors over the lines
  for (std::size_t i = 0; i < csv.size(); ++i) {
    const std::size_t set = static_cast<std::size_t>(csv.number(i, "set"));
    const double tau = csv.number(i, "tau");
    const Ray ray = row_ray(csv, i, csv.number(i, "t0"), csv.number(i, "t1"));
    INFO("set " << set << ", row " << i << ", tau " << tau);
    if (set < 2) {
      const std::vector<double> errors{mean_error(kBlobs[set], ray, tau, 36, 0),
                                       mean_error(kBlobs[set], ray, tau, 72, 0)};
      // Line by line the second-order terms may nearly cancel; over all lines they don't.
      CHECK(errors.back() < errors.front());
      CHECK(errors.back() < 0.009);
      coarse.add(errors[0] * errors[0]);
      fine.add(errors[1] * errors[1]);
      const double off = mean_error(kBlobs[set], ray, tau, 72, 0.5);
      shifted.add(off * off);
    } else {
      // The same blob, thin as air and thick as stone.
      const Octree tree = blob_tree(kBlobs[set], 100, 0.1, Vec3d(-5));
      const Gathered g = gather(tree, ray, channel(0), constant(kSource));
      CHECK(g.depth == Approx(tau).epsilon(0.02));
      CHECK(g.radiance == Approx(-kSource * std::expm1(-g.depth)).epsilon(1e-12));
      CHECK(g.radiance == Approx(csv.number(i, "I")).epsilon(0.02));
    }
  }
  const double order = 0.5 * std::log2(coarse.mean() / fine.mean());
  CHECK(order == Approx(2).margin(0.1));
  Verified verified =
      verified_walk("a7_gaussian_blob_lines.csv", "order of convergence over all lines, 36 and 72 voxels", "2 +- 0.1");
  verified.within(order, 2, 0.1);
  char text[60];
  std::snprintf(text, sizeof text, "order %.3f", order);
  verified.note(text);
  CHECK(shifted.mean() > 100 * fine.mean());  // half a voxel off is first order: noticed
}
