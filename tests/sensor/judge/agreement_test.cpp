// When methods agree: right when the errors are right, and blind only to what is within them.
#include "sensor/judge/agreement.h"

#include <catch2/catch.hpp>
#include <vector>

#include "octree/base/math.h"
#include "octree/base/random.h"
#include "tests/support/distributions.h"

using namespace obscura;

namespace {

double normal(Stream& stream) {
  const double radius = std::sqrt(-2 * std::log(stream.uniform()));
  return radius * std::cos(2 * kPi * stream.uniform());
}

// Two pictures of the same thing; the first is wrong by `bias` and claims `claim` times its error.
struct Pictures {
  std::vector<float> a, ea, b, eb, bias;
  Pictures(std::size_t count, double wrong, double claim, std::uint64_t seed) {
    Stream stream(seed, 1, 2);
    for (std::size_t i = 0; i < count; ++i) {
      const double truth = 1 + 0.5 * stream.uniform();
      a.push_back(static_cast<float>(truth + wrong + 0.02 * normal(stream)));
      b.push_back(static_cast<float>(truth + 0.01 * normal(stream)));
      ea.push_back(static_cast<float>(0.02 * claim));
      eb.push_back(0.01f);
      bias.push_back(static_cast<float>(wrong));
    }
  }
  PixelAgreement judge(bool with_bias = false) const {
    return pixel_agreement({a, ea, with_bias ? std::span<const float>(bias) : std::span<const float>()}, {b, eb, {}});
  }
};

}  // namespace

TEST_CASE("honest differences agree and others do not", "[sensor][agreement]") {
  const AgreementRule rule{.false_alarm = 1e-6, .resolution = 0.1};
  const Agreement same = agreement({1.02, 0.01}, {1, 0.01}, rule);
  CHECK(same.agree);
  CHECK(same.z == Approx(0.02 / std::hypot(0.01, 0.01)));
  CHECK(same.limit == Approx(4.8916).epsilon(1e-4));  // of the normal law
  CHECK(same.relative == Approx(0.02 / 1.02));
  CHECK_FALSE(agreement({1.08, 0.01}, {1, 0.01}, rule).agree);
  // What a method knows of its bias is allowed, in either direction.
  CHECK(agreement({1.08, 0.01, kInfinity, 0.02}, {1, 0.01}, rule).agree);
  CHECK(agreement({1, 0.01}, {1.08, 0.01, kInfinity, 0.02}, rule).agree);
}

TEST_CASE("few degrees of freedom allow more", "[sensor][agreement]") {
  const AgreementRule rule{.false_alarm = 1e-6};
  CHECK(agreement({0, 1, 15}, {1, 0}, rule).limit == Approx(test::student_limit(1e-6, 15)).epsilon(1e-3));
  // The error that counts decides (Welch and Satterthwaite).
  CHECK(agreement({0, 1, 15}, {1, 1e-3, 2}, rule).limit == Approx(test::student_limit(1e-6, 15)).epsilon(1e-3));
  CHECK(agreement({0, 1, 15}, {1, 1, 15}, rule).limit < 6.5);
}

TEST_CASE("a comparison that could not have seen the resolution is not sharp", "[sensor][agreement]") {
  const Agreement weak = agreement({1, 0.02}, {1, 0}, {.false_alarm = 1e-6, .resolution = 0.1});
  CHECK(weak.agree);
  CHECK_FALSE(weak.sharp);
  CHECK(weak.detectable == Approx((4.8916 + 3.0902) * 0.02).epsilon(1e-3));
  CHECK(agreement({1, 0.01}, {1, 0}, {.false_alarm = 1e-6, .resolution = 0.1}).sharp);
  CHECK_FALSE(agreement({1, 0.01, kInfinity, 0.05}, {1, 0}, {.false_alarm = 1e-6, .resolution = 0.1}).sharp);
  CHECK(agreement({1, 0.5}, {1, 0}, {.false_alarm = 1e-6}).sharp);
}

TEST_CASE("a comparison that is too weak says how many samples would do", "[sensor][agreement]") {
  const AgreementRule rule{.false_alarm = 1e-6, .resolution = 0.1};
  const Agreement weak = agreement({1, 0.1}, {1.05, 0.1}, rule);
  CHECK(weak.agree);
  CHECK_FALSE(weak.sharp);
  CHECK_FALSE(weak.judged());
  REQUIRE(weak.samples_factor > 1);
  const double less = 0.1 / std::sqrt(weak.samples_factor);
  CHECK(agreement({1, 0.999 * less}, {1.05, 0.999 * less}, rule).sharp);
  CHECK_FALSE(agreement({1, 1.001 * less}, {1.05, 1.001 * less}, rule).sharp);
  // Biases stay whatever is sampled; where there is no light nothing can be seen.
  CHECK(std::isinf(agreement({1, 0.1, kInfinity, 0.2}, {1, 0.1}, rule).samples_factor));
  CHECK_FALSE(agreement({0, 0}, {0, 0}, rule).judged());
  // A difference is a difference, however weak the comparison.
  CHECK(agreement({3, 0.1}, {1, 0.1}, rule).judged());
}

TEST_CASE("numbers without error have to be equal", "[sensor][agreement]") {
  CHECK(agreement({0, 0}, {0, 0}, {}).agree);
  CHECK(agreement({2, 0}, {2.000001, 0}, {}).agree);
  const Agreement other = agreement({2, 0}, {2.01, 0}, {});
  CHECK_FALSE(other.agree);
  CHECK(other.z == -kInfinity);
}

TEST_CASE("a mean of measurements has the error of a mean", "[sensor][agreement]") {
  const std::vector<Measured> four(4, Measured{3, 0.2, 15, 0.1});
  const Measured mean = mean_of(four);
  CHECK(mean.value == Approx(3));
  CHECK(mean.error == Approx(0.1));
  CHECK(mean.freedom == Approx(60));
  CHECK(mean.bias == Approx(0.1));  // shared: it does not average out
  CHECK(std::isinf(mean_of({}).error));
}

TEST_CASE("pixels agree within their errors, whatever the numbers drawn", "[sensor][agreement]") {
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    const PixelAgreement honest = Pictures(900, 0, 1, seed).judge();
    CHECK(honest.agree);
    CHECK(honest.rms_z == Approx(1).margin(0.12));
    CHECK(honest.inside == Approx(0.95).margin(0.04));
    // Errors that are half of what they should be are found out, and so is an offset.
    CHECK_FALSE(Pictures(900, 0, 0.3, seed).judge().agree);
    const Pictures offset(900, 0.03, 1, seed);
    CHECK_FALSE(offset.judge().agree);
    CHECK(offset.judge(true).agree);
  }
}

TEST_CASE("pixels without error have to be equal, and few pixels may scatter", "[sensor][agreement]") {
  std::vector<float> a(100, 1.0f), b(100, 1.0f), none(100, 0.0f);
  CHECK(pixel_agreement({a, none, {}}, {b, none, {}}).agree);
  CHECK(pixel_agreement({a, none, {}}, {b, none, {}}).pixels == 0);
  b[7] = 1.001f;
  CHECK_FALSE(pixel_agreement({a, none, {}}, {b, none, {}}).agree);
  const Pictures few(4, 0, 1, 3);
  CHECK(few.judge().high > 2);
  CHECK(few.judge().agree);
}
