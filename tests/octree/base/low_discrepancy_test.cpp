#include "octree/base/low_discrepancy.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "octree/base/random.h"
#include "octree/base/statistics.h"
#include "tests/support/agree.h"
#include "tests/support/chi_square.h"

using namespace obscura;

namespace {

constexpr int kDimensions = LowDiscrepancy::kDimensions;

// Smooth, with all dimensions coupled; its mean over the unit cube is 1.
double smooth(const std::array<double, 8>& x) {
  double product = 1;
  for (int d = 0; d < kDimensions; ++d) product *= 1 + 0.3 * (x[d] - 0.5) + 0.2 * (x[d] * x[d] - 1.0 / 3);
  return product;
}

template <class Point>
double mean_of(Point&& point, std::uint32_t count) {
  double sum = 0;
  for (std::uint32_t i = 0; i < count; ++i) sum += smooth(point(i));
  return sum / count;
}

}  // namespace

TEST_CASE("the first points of the plain sequence are Sobol's", "[base][low_discrepancy]") {
  // Joe and Kuo's points number 4 and 16 to 20, which they list in the order of the Gray code; ours
  // lie in the middle of the last binary digit.
  const LowDiscrepancy plain(0, 0, false);
  const std::pair<std::uint32_t, std::array<double, 8>> expected[] = {
      {4, {0.375, 0.375, 0.625, 0.875, 0.375, 0.125, 0.375, 0.875}},
      {16, {0.09375, 0.46875, 0.46875, 0.65625, 0.28125, 0.96875, 0.53125, 0.84375}},
      {17, {0.59375, 0.96875, 0.96875, 0.15625, 0.78125, 0.46875, 0.03125, 0.34375}},
      {18, {0.84375, 0.21875, 0.21875, 0.90625, 0.53125, 0.21875, 0.78125, 0.09375}},
      {19, {0.34375, 0.71875, 0.71875, 0.40625, 0.03125, 0.71875, 0.28125, 0.59375}},
      {20, {0.46875, 0.09375, 0.84375, 0.28125, 0.15625, 0.84375, 0.90625, 0.21875}}};
  for (const auto& [number, point] : expected) {
    for (int d = 0; d < kDimensions; ++d) {
      INFO("point " << number << ", dimension " << d);
      CHECK(plain.point(number ^ (number >> 1))[d] == point[d] + 0x1p-33);
    }
  }
  // The first direction number that the last dimension's recurrence makes: 8 m3 ^ 32 m1 ^ m1 = 9.
  CHECK(plain.point(32)[7] == 9.0 / 64 + 0x1p-33);
}

TEST_CASE("every dyadic interval holds one of the first points", "[base][low_discrepancy]") {
  for (const bool scrambled : {false, true}) {
    for (std::uint32_t batch = 0; batch < 4; ++batch) {
      const LowDiscrepancy points(7, batch, scrambled);
      for (int k = 0; k <= 12; ++k) {
        const std::uint32_t count = 1u << k;
        // Also any later block of as many points.
        for (const std::uint32_t start : {0u, count, 5 * count}) {
          bool once = true;
          for (int d = 0; d < kDimensions; ++d) {
            std::vector<int> seen(count);
            for (std::uint32_t i = 0; i < count; ++i) {
              const double x = points.point(start + i)[d];
              once = once && x > 0 && x < 1 && ++seen[static_cast<std::size_t>(x * count)] == 1;
            }
          }
          CHECK(once);
        }
      }
    }
  }
}

TEST_CASE("any two dimensions are as even as their polynomials promise", "[base][low_discrepancy]") {
  // Sobol (1967): with polynomials of degree s, a rectangle of volume 2^(t - m), t the sum of s -
  // 1, holds 2^t of the first 2^m points. Dimensions 0 and 1 have t = 0: a (0,2)-net.
  const int degree[kDimensions] = {1, 1, 2, 3, 3, 4, 4, 5};
  const int m = 12;
  const LowDiscrepancy points(11, 0);
  for (int d = 0; d < kDimensions; ++d) {
    for (int e = 0; e < d; ++e) {
      const int t = degree[d] + degree[e] - 2;
      bool even = true;
      for (int a = 0; a <= m - t; ++a) {
        const double columns = std::exp2(a), rows = std::exp2(m - t - a);
        std::vector<int> seen(std::size_t{1} << (m - t));
        for (std::uint32_t i = 0; i < (1u << m); ++i) {
          const auto x = points.point(i);
          ++seen[static_cast<std::size_t>(x[d] * columns) * static_cast<std::size_t>(rows) +
                 static_cast<std::size_t>(x[e] * rows)];
        }
        for (const int count : seen) even = even && count == 1 << t;
      }
      INFO("dimensions " << e << " and " << d);
      CHECK(even);
    }
  }
}

TEST_CASE("one point is uniform over the scrambles", "[base][low_discrepancy]") {
  // Over batches each point must be uniform in each pair of dimensions, or means are biased.
  const int batches = 100000;
  const std::vector<std::uint32_t> indexes{0, 1, 6, 12345};
  for (const std::uint32_t index : indexes) {
    for (const auto& [a, b] : {std::pair{0, 1}, {2, 3}, {4, 7}, {5, 6}}) {
      std::vector<double> observed(16 * 16), expected(16 * 16, batches / 256.0);
      for (int batch = 0; batch < batches; ++batch) {
        const auto x = LowDiscrepancy(3, static_cast<std::uint32_t>(batch)).point(index);
        ++observed[static_cast<std::size_t>(x[a] * 16) * 16 + static_cast<std::size_t>(x[b] * 16)];
      }
      INFO("point " << index << ", dimensions " << a << " and " << b);
      CHECK(test::chi_square(observed, expected, 16));
    }
  }
}

TEST_CASE("scrambled digits below the first are fair as well", "[base][low_discrepancy]") {
  // The n-th binary digit of a point, over batches: a fair coin for all 52 digits.
  const int batches = 20000;
  std::vector<double> ones(52 * kDimensions);
  for (int batch = 0; batch < batches; ++batch) {
    const auto x = LowDiscrepancy(5, static_cast<std::uint32_t>(batch)).point(77);
    for (int d = 0; d < kDimensions; ++d) {
      const auto digits = static_cast<std::uint64_t>(x[d] * 0x1p52);
      for (int n = 0; n < 52; ++n) ones[static_cast<std::size_t>(52 * d + n)] += (digits >> n) & 1;
    }
  }
  const double limit = test::student_limit(1e-6 / static_cast<double>(ones.size()));
  for (const double count : ones) {
    CHECK(std::abs(count - 0.5 * batches) < limit * 0.5 * std::sqrt(batches));
  }
}

TEST_CASE("batches are unbiased and independent, for any number of points", "[base][low_discrepancy]") {
  for (const std::uint32_t count : {16u, 37u, 100u}) {
    const int batches = 4000;
    Moments moments, neighbours, seeds;
    double previous = 0;
    std::vector<double> errors;
    for (int b = 0; b < batches; ++b) {
      const LowDiscrepancy points(42, static_cast<std::uint32_t>(b));
      const LowDiscrepancy other(43, static_cast<std::uint32_t>(b));
      const double e = mean_of([&](std::uint32_t i) { return points.point(i); }, count) - 1;
      const double f = mean_of([&](std::uint32_t i) { return other.point(i); }, count) - 1;
      moments.add(e);
      if (b > 0) neighbours.add(e * previous);
      seeds.add(e * f);
      previous = e;
    }
    // The mean is right; the products of different batches' errors have mean 0.
    INFO(count << " points");
    const double limit = test::student_limit(1e-6 / 9);
    CHECK(std::abs(moments.mean()) < limit * moments.standard_error());
    CHECK(std::abs(neighbours.mean()) < limit * neighbours.standard_error());
    CHECK(std::abs(seeds.mean()) < limit * seeds.standard_error());
    // The same batch twice is not independent: the test would see it.
    CHECK(moments.variance() > limit * seeds.standard_error());
  }
}

TEST_CASE("the error falls faster than that of random points", "[base][low_discrepancy]") {
  const auto variance = [](auto&& make, std::uint32_t count) {
    Moments m;
    for (std::uint32_t b = 0; b < 64; ++b) m.add(mean_of(make(b), count));
    return m.variance();
  };
  const auto scrambled = [](std::uint32_t batch) {
    return [points = LowDiscrepancy(9, batch)](std::uint32_t i) { return points.point(i); };
  };
  const auto random = [](std::uint32_t batch) {
    return [stream = Stream(9, batch, 1)](std::uint32_t) mutable {
      std::array<double, 8> x;
      for (double& v : x) v = stream.uniform();
      return x;
    };
  };
  // 64 scrambles give a variance to about 18 %. From 64 to 4096 points, random's falls 64 times.
  const double gain = variance(scrambled, 64) / variance(scrambled, 4096);
  const double plain_gain = variance(random, 64) / variance(random, 4096);
  CHECK(gain > 64 * 8);
  CHECK(plain_gain < 64 * 2.5);
  CHECK(variance(random, 4096) / variance(scrambled, 4096) > 100);
}

TEST_CASE("points are named by seed, batch and index", "[base][low_discrepancy]") {
  CHECK(LowDiscrepancy(1, 2).point(3) == LowDiscrepancy(1, 2).point(3));
  CHECK(LowDiscrepancy(1, 2).point(3) != LowDiscrepancy(1, 3).point(3));
  CHECK(LowDiscrepancy(1, 2).point(3) != LowDiscrepancy(2, 2).point(3));
  CHECK(LowDiscrepancy(1, 2).point(3) != LowDiscrepancy(1, 2).point(4));
  CHECK(LowDiscrepancy(1, 2, false).point(3) == LowDiscrepancy(5, 6, false).point(3));
  const auto last = LowDiscrepancy(1, 2).point(0xffffffffu);
  for (const double x : last) CHECK((x > 0 && x < 1));
}
