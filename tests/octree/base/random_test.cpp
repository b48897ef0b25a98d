#include "octree/base/random.h"

#include <catch2/catch.hpp>

#include "octree/base/statistics.h"
#include "tests/support/agree.h"
#include "tests/support/chi_square.h"

using namespace obscura;

TEST_CASE("Philox gives the published answers", "[base][random]") {
  // Random123, tests/kat_vectors: philox4x32 with 10 rounds; zeros, ones, digits of pi.
  using Block = std::array<std::uint32_t, 4>;
  CHECK(philox4x32({0, 0, 0, 0}, {0, 0}) == Block{0x6627e8d5u, 0xe169c58du, 0xbc57ac4cu, 0x9b00dbd8u});
  const std::uint32_t ones = 0xffffffffu;
  CHECK(philox4x32({ones, ones, ones, ones}, {ones, ones}) ==
        Block{0x408f276du, 0x41c83b0eu, 0xa20bc7c6u, 0x6d5451fdu});
  CHECK(philox4x32({0x243f6a88u, 0x85a308d3u, 0x13198a2eu, 0x03707344u}, {0xa4093822u, 0x299f31d0u}) ==
        Block{0xd16cfe09u, 0x94fdccebu, 0x5001e420u, 0x24126ea1u});
}

TEST_CASE("a stream is its counter block by block", "[base][random]") {
  const std::uint64_t seed = 0x0123456789abcdefu, history = 0xfedcba9876543210u;
  Stream stream(seed, history, 5);
  for (std::uint32_t block = 0; block < 3; ++block) {
    const auto expected = philox4x32({block, 5, 0x76543210u, 0xfedcba98u}, {0x89abcdefu, 0x01234567u});
    for (int i = 0; i < 4; ++i) CHECK(stream.bits() == expected[i]);
  }
}

TEST_CASE("streams differ in seed, history, purpose and what more is told of it", "[base][random]") {
  const std::uint32_t first = Stream(1, 2, 3).bits();
  CHECK(first == Stream(1, 2, 3).bits());
  CHECK(first != Stream(2, 2, 3).bits());
  CHECK(first != Stream(1, 3, 3).bits());
  CHECK(first != Stream(1, 2, 4).bits());
  CHECK(first != Stream(1ull << 32, 2, 3).bits());
  CHECK(first != Stream(1, 1ull << 32, 3).bits());
  CHECK(first == Stream(1, 2, 3, 0).bits());
  CHECK(first != Stream(1, 2, 3, 1).bits());
  CHECK(first != Stream(1, 2, 3, 1ull << 63).bits());
}

TEST_CASE("uniform numbers are uniform, open and independent of their neighbours", "[base][random]") {
  const int samples = 500000;
  Stream stream(1, 0, 0);
  std::vector<double> observed(64 * 64), expected(64 * 64, samples / 4096.0);
  Moments mean;
  double before = stream.uniform();
  bool open = true;
  for (int i = 0; i < samples; ++i) {
    const double x = stream.uniform();
    open = open && x > 0 && x < 1;
    mean.add(x);
    ++observed[static_cast<std::size_t>(before * 64) * 64 + static_cast<std::size_t>(x * 64)];
    before = x;
  }
  CHECK(open);
  CHECK(test::chi_square(observed, expected));
  CHECK(test::agree(mean.mean(), mean.standard_error(), 0.5, {.resolution = 0.01}));
  CHECK(mean.variance() == Approx(1.0 / 12).epsilon(0.01));
}

TEST_CASE("neighbouring histories are independent", "[base][random]") {
  const int samples = 200000;
  std::vector<double> observed(32 * 32), expected(32 * 32, samples / 1024.0);
  for (int i = 0; i < samples; ++i) {
    const auto h = static_cast<std::uint64_t>(2 * i);
    const double x = Stream(1, h, 0).uniform(), y = Stream(1, h + 1, 0).uniform();
    ++observed[static_cast<std::size_t>(x * 32) * 32 + static_cast<std::size_t>(y * 32)];
  }
  CHECK(test::chi_square(observed, expected));
}
