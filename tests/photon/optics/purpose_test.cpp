#include "photon/optics/purpose.h"

#include <catch2/catch.hpp>
#include <set>

using namespace obscura;

namespace {

using Block = std::array<std::uint32_t, 4>;

Block first_block(const StreamName& name) {
  Stream stream = name.stream();
  return {stream.bits(), stream.bits(), stream.bits(), stream.bits()};
}

/// The streams' names as they lay in 32 bits when these numbers were written down.
std::uint32_t packed(Purpose purpose, int interval, std::uint64_t step) {
  return static_cast<std::uint32_t>(purpose) + 256u * static_cast<std::uint32_t>(interval) +
         0x10000u * static_cast<std::uint32_t>(step);
}

}  // namespace

TEST_CASE("names that differ give streams that differ", "[photon][purpose]") {
  // One step after another, also beyond what 8 bits of the interval and 16 of the step hold: 8196 steps a mirror's
  // bounce, of which a ray may have 1e9.
  constexpr std::uint64_t kBounce = 8196;
  std::set<Block> blocks;
  std::size_t names = 0;
  for (const std::uint64_t seed : {0, 1, 2}) {
    for (const std::uint64_t history : {0, 1}) {
      for (const Purpose purpose : {Purpose::none, Purpose::emission, Purpose::radiance, Purpose::sunlight}) {
        for (const int interval : {0, 1, 2, 255, 256, 257, 511, 512, 65535, 65536, 65792, (1 << 24) - 1}) {
          for (const std::uint64_t step : {std::uint64_t{0}, std::uint64_t{1}, std::uint64_t{255}, std::uint64_t{256},
                                           std::uint64_t{65535}, std::uint64_t{65536}, std::uint64_t{65537},
                                           8 * kBounce, 8 * kBounce + 1, 1000 * kBounce, 1000000000 * kBounce}) {
            blocks.insert(first_block({seed, history, purpose, interval, step}));
            ++names;
          }
        }
      }
    }
  }
  CHECK(blocks.size() == names);

  // What the 32 bits alone cannot tell apart.
  CHECK(packed(Purpose::radiance, 256, 0) == packed(Purpose::radiance, 0, 1));
  CHECK(first_block({1, 2, Purpose::radiance, 256, 0}) != first_block({1, 2, Purpose::radiance, 0, 1}));
  CHECK(packed(Purpose::radiance, 3, 8 * kBounce) == packed(Purpose::radiance, 3, 8 * kBounce - 65536));
  CHECK(first_block({1, 2, Purpose::radiance, 3, 8 * kBounce}) !=
        first_block({1, 2, Purpose::radiance, 3, 8 * kBounce - 65536}));
}

TEST_CASE("the first 256 intervals and 65536 steps have the numbers that they always had", "[photon][purpose]") {
  for (const int interval : {0, 1, 100, 255}) {
    for (const std::uint64_t step : {0, 1, 4097, 65535}) {
      const StreamName name{0x0123456789abcdefu, 0xfedcba9876543210u, Purpose::disc, interval, step};
      Stream stream(name.seed, name.history, packed(name.purpose, interval, step));
      for (const std::uint32_t bits : first_block(name)) CHECK(bits == stream.bits());
    }
  }
  // Written down, so that no change of both goes unseen.
  CHECK(first_block({1, 2, Purpose::emission}) == Block{0x971c0b2fu, 0x2c6bc63bu, 0x11d5fd35u, 0x1e5963e7u});
  CHECK(first_block({1, 2, Purpose::radiance, 3, 4097}) == Block{0x99cf1766u, 0x7914483au, 0xfd85b2a8u, 0x737e1100u});
  CHECK(first_block({}) == Block{0x6627e8d5u, 0xe169c58du, 0xbc57ac4cu, 0x9b00dbd8u});  // Philox of nothing but zeros
}
