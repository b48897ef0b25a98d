#include "octree/base/low_discrepancy.h"

#include "octree/base/random.h"

namespace obscura {
namespace {

constexpr int kDimensions = LowDiscrepancy::kDimensions;
constexpr std::uint32_t kPurpose = 0x4f57454e;  // keeps the scrambles apart from all other streams

// A primitive polynomial of degree s with inner coefficients a, and the first s direction numbers:
// the head of Joe and Kuo's file new-joe-kuo-6.21201.
struct Polynomial {
  int s;
  std::uint32_t a;
  std::uint32_t m[5];
};
constexpr Polynomial kPolynomials[kDimensions - 1] = {
    {1, 0, {1}},          {2, 1, {1, 3}},        {3, 1, {1, 3, 1}},        {3, 2, {1, 1, 1}},
    {4, 1, {1, 1, 3, 3}}, {4, 4, {1, 3, 5, 13}}, {5, 2, {1, 1, 5, 5, 17}},
};

// matrix[bit][dimension]: what a set bit of the index contributes, most significant digit first.
using Matrix = std::array<std::array<std::uint32_t, kDimensions>, 32>;

constexpr Matrix make_matrix() {
  Matrix matrix{};
  for (int bit = 0; bit < 32; ++bit) matrix[bit][0] = std::uint32_t{1} << (31 - bit);
  for (int d = 1; d < kDimensions; ++d) {
    const Polynomial& p = kPolynomials[d - 1];
    for (int bit = 0; bit < 32; ++bit) {
      if (bit < p.s) {
        matrix[bit][d] = p.m[bit] << (31 - bit);
        continue;
      }
      std::uint32_t v = matrix[bit - p.s][d] ^ (matrix[bit - p.s][d] >> p.s);
      for (int k = 1; k < p.s; ++k) {
        if ((p.a >> (p.s - 1 - k)) & 1u) v ^= matrix[bit - k][d];
      }
      matrix[bit][d] = v;
    }
  }
  return matrix;
}
constexpr Matrix kMatrix = make_matrix();

constexpr std::uint32_t reverse_bits(std::uint32_t x) noexcept {
  x = ((x >> 1) & 0x55555555u) | ((x & 0x55555555u) << 1);
  x = ((x >> 2) & 0x33333333u) | ((x & 0x33333333u) << 2);
  x = ((x >> 4) & 0x0f0f0f0fu) | ((x & 0x0f0f0f0fu) << 4);
  x = ((x >> 8) & 0x00ff00ffu) | ((x & 0x00ff00ffu) << 8);
  return (x >> 16) | (x << 16);
}

// Every bit of the result depends on itself and the bits below it only: applied to reversed digits
// this is an Owen scramble. Constants of Vegdahl, "Building a better LK hash" (2021), after Laine
// and Karras, "Stratified sampling for stochastic transparency" (EGSR 2011).
constexpr std::uint32_t nested_hash(std::uint32_t x, std::uint32_t seed) noexcept {
  x ^= x * 0x3d20adeau;
  x += seed;
  x *= (seed >> 16) | 1u;
  x ^= x * 0x05526c56u;
  x ^= x * 0x53a22864u;
  return x;
}

// Mixes all bits (finalizer of MurmurHash3).
constexpr std::uint32_t mix(std::uint32_t x) noexcept {
  x ^= x >> 16;
  x *= 0x85ebca6bu;
  x ^= x >> 13;
  x *= 0xc2b2ae35u;
  return x ^ (x >> 16);
}

}  // namespace

LowDiscrepancy::LowDiscrepancy(std::uint64_t seed, std::uint32_t batch, bool scrambled) noexcept
    : scrambled_(scrambled) {
  Stream stream(seed, batch, kPurpose);
  for (std::uint32_t& s : scramble_) s = stream.bits();
  for (std::uint32_t& s : tail_) s = stream.bits();
}

std::array<double, kDimensions> LowDiscrepancy::point(std::uint32_t index) const noexcept {
  // The digits of the sequence: one row of the matrix per set bit of the index.
  std::array<std::uint32_t, kDimensions> digits{};
  for (int bit = 0; index >> bit; ++bit) {
    const std::uint32_t mask = 0u - ((index >> bit) & 1u);
    for (int d = 0; d < kDimensions; ++d) digits[d] ^= kMatrix[bit][d] & mask;
    if (bit == 31) break;
  }

  std::array<double, kDimensions> result;
  if (!scrambled_) {
    for (int d = 0; d < kDimensions; ++d) result[d] = (digits[d] + 0.5) * 0x1p-32;
    return result;
  }
  // No two of 2^32 points share their 32 digits, so a scramble of the digits after them is plain
  // independent bits.
  for (int d = 0; d < kDimensions; ++d) {
    const std::uint64_t high = reverse_bits(nested_hash(reverse_bits(digits[d]), scramble_[d]));
    const std::uint64_t low = mix(index * 0x9e3779b9u + tail_[d]) >> 12;
    result[d] = (static_cast<double>((high << 20) | low) + 0.5) * 0x1p-52;
  }
  return result;
}

}  // namespace obscura
