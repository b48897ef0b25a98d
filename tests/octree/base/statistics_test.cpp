#include "octree/base/statistics.h"

#include <catch2/catch.hpp>
#include <vector>

#include "octree/base/math.h"
#include "octree/base/random.h"
#include "tests/support/agree.h"

using namespace obscura;

namespace {

double normal(Stream& stream) {
  const double radius = std::sqrt(-2 * std::log(stream.uniform()));
  return radius * std::cos(2 * kPi * stream.uniform());
}

}  // namespace

TEST_CASE("moments are those of the numbers", "[base][statistics]") {
  Moments m;
  CHECK(m.count() == 0);
  CHECK(m.mean() == 0);
  CHECK(m.standard_error() == kInfinity);
  m.add(5);
  CHECK(m.mean() == 5);
  CHECK(m.variance() == 0);
  CHECK(m.standard_error() == kInfinity);
  for (const double x : {1.0, 2.0, 4.0}) m.add(x);
  CHECK(m.count() == 4);
  CHECK(m.mean() == 3);
  CHECK(m.variance() == Approx(10.0 / 3).epsilon(1e-15));
  CHECK(m.standard_error() == Approx(std::sqrt(10.0 / 12)).epsilon(1e-15));
}

TEST_CASE("moments do not cancel beside a large mean", "[base][statistics]") {
  Moments m;
  for (int i = 0; i < 1000; ++i) m.add(1e9 + (i % 2 ? 1.0 : -1.0));
  CHECK(m.mean() == Approx(1e9).epsilon(1e-15));
  CHECK(m.variance() == Approx(1000.0 / 999).epsilon(1e-6));
}

TEST_CASE("merged moments are those of the whole, in the same bits each time", "[base][statistics]") {
  Moments whole, left, right, empty;
  Stream stream(1, 0, 0);
  for (int i = 0; i < 1000; ++i) {
    const double x = normal(stream);
    whole.add(x);
    (i < 300 ? left : right).add(x);
  }
  Moments merged = left;
  merged.merge(right);
  CHECK(merged.count() == 1000);
  CHECK(merged.mean() == Approx(whole.mean()).epsilon(1e-13));
  CHECK(merged.variance() == Approx(whole.variance()).epsilon(1e-13));
  Moments again = left;
  again.merge(right);
  CHECK(again.mean() == merged.mean());
  CHECK(again.variance() == merged.variance());
  again.merge(empty);
  CHECK(again.mean() == merged.mean());
  empty.merge(left);
  CHECK(empty.variance() == left.variance());
}

TEST_CASE("a mean over batches has Student's error", "[base][statistics]") {
  // The true mean lies within t(15, 5 %) standard errors in 95 % of the cases; the normal
  // law's 1.96 would claim it in 93.1 %.
  const int trials = 20000;
  const double t = test::student_limit(0.05, 15);
  CHECK(t == Approx(2.13145).epsilon(1e-5));
  int covered = 0, covered_by_normal = 0;
  Stream stream(2, 0, 0);
  for (int trial = 0; trial < trials; ++trial) {
    std::vector<double> batches(16);
    for (double& b : batches) b = 10 + 3 * normal(stream);
    const BatchMean m = batch_mean(batches);
    covered += std::abs(m.mean - 10) <= t * m.standard_error;
    covered_by_normal += std::abs(m.mean - 10) <= 1.959964 * m.standard_error;
  }
  const double share = static_cast<double>(covered) / trials;
  const double error = std::sqrt(0.05 * 0.95 / trials);
  CHECK(test::agree(share, error, 0.95, {.resolution = 0.014}));
  CHECK_FALSE(test::agree(static_cast<double>(covered_by_normal) / trials, error, 0.95, {.resolution = 0.014}));
}

TEST_CASE("few batches say little", "[base][statistics]") {
  CHECK(batch_mean({}).mean == 0);
  CHECK(batch_mean({}).standard_error == kInfinity);
  const std::vector<double> one{4};
  CHECK(batch_mean(one).mean == 4);
  CHECK(batch_mean(one).standard_error == kInfinity);
  const std::vector<double> two{4, 6};
  CHECK(batch_mean(two).mean == 5);
  CHECK(batch_mean(two).standard_error == 1);
  const std::vector<double> equal(16, 0.1);
  CHECK(batch_mean(equal).standard_error < 1e-17);
}

TEST_CASE("a pairwise sum keeps its digits", "[base][statistics]") {
  const std::vector<double> tenths(1 << 20, 0.1);
  const double exact = 0.1 * (1 << 20);  // a power of two times the same double
  double running = 0;
  for (const double x : tenths) running += x;
  CHECK(std::abs(pairwise_sum(tenths) - exact) < 1e-14 * exact);
  CHECK(std::abs(running - exact) > 1e-12 * exact);
  CHECK(pairwise_sum({}) == 0);
  const std::vector<double> few{1, 2, 3};
  CHECK(pairwise_sum(few) == 6);
}

TEST_CASE("Student's law has the tails of its tables", "[base][statistics]") {
  // Abramowitz & Stegun, table 26.10: two-sided 5 % and 0.1 %.
  CHECK(student_limit(0.05, 1) == Approx(12.706).epsilon(1e-4));
  CHECK(student_limit(0.05, 15) == Approx(2.131).epsilon(1e-3));
  CHECK(student_limit(0.001, 60) == Approx(3.460).epsilon(1e-3));
  CHECK(student_limit(0.05) == Approx(1.959964).epsilon(1e-6));
  for (const double freedom : {1.0, 3.5, 15.0, 60.0, kInfinity}) {
    for (const double probability : {0.3, 1e-3, 1e-9}) {
      INFO(freedom << " " << probability);
      const double limit = student_limit(probability, freedom);
      CHECK(student_tail(limit, freedom) == Approx(probability).epsilon(1e-6));
      CHECK(limit == Approx(test::student_limit(probability, freedom)).epsilon(1e-9));
    }
  }
}
