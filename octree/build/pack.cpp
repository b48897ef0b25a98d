// Quantising the values of one brick.
#include <cassert>
#include <cmath>

#include "octree/build/compress.h"

namespace obscura::detail {

ChannelHeader pack(std::span<const float> values, int cell_level, double step, std::vector<std::byte>& out,
                   std::size_t record_start) {
  assert(step > 0 && values.size() == (std::size_t{512} >> (3 * cell_level)));
  float min = values[0], max = values[0];
  bool has_zero = false;
  double sum = 0;
  for (const float v : values) {
    min = std::min(min, v);
    max = std::max(max, v);
    has_zero = has_zero || v == 0;
    sum += static_cast<double>(v);
  }
  const double count = static_cast<double>(values.size());
  const double mean = sum / count;
  if (min == max) return {min, 0, static_cast<float>(mean), ChannelHeader::make_meta(0, cell_level, 0)};

  // The range is divided into 2^bits - 1 steps. Keeping the mean moves all values; where that is too far, there is one
  // bit more. Values count from the least one; in a brick of one sign that holds zeros they count from 0.
  constexpr int kMaxBits = 24;
  const double low = has_zero && min >= 0 ? 0.0 : static_cast<double>(min);
  const double range = static_cast<double>(max) - low;
  const double steps = std::ceil(range / step);
  int bits = 1;
  while (bits < kMaxBits && std::ldexp(1.0, bits) - 1 < steps) ++bits;
  std::vector<std::uint32_t> q(values.size());
  ChannelHeader header{};
  for (;; ++bits) {
    const double top = std::ldexp(1.0, bits) - 1;
    const double scale = range / top;
    double sum_q = 0;
    for (std::size_t i = 0; i < values.size(); ++i) {
      const double exact = std::round((static_cast<double>(values[i]) - low) / scale);
      q[i] = static_cast<std::uint32_t>(std::clamp(exact, 0.0, top));
      sum_q += q[i];
    }
    double kept_scale = scale, kept_low = low;
    if (low == 0) {
      kept_scale = sum_q > 0 ? sum / sum_q : 0;
    } else {
      kept_low = mean - scale * (sum_q / count);
    }
    const double moved = std::max(std::abs(kept_low - low), std::abs(kept_scale - scale) * top);
    header.offset = static_cast<float>(kept_low);
    header.scale = static_cast<float>(kept_scale);
    const bool same_sign = min < 0 || header.offset >= 0;
    if ((moved <= 0.5 * std::max(step, scale) && same_sign) || bits >= kMaxBits) break;
  }
  header.mean = static_cast<float>(mean);
  const std::size_t start = out.size();
  header.meta = ChannelHeader::make_meta(bits, cell_level, start - record_start);

  out.resize(start + packed_bytes(bits, cell_level));
  std::uint64_t pending = 0;
  int filled = 0;
  std::byte* to = out.data() + start;
  for (const std::uint32_t value : q) {
    pending |= std::uint64_t{value} << filled;
    filled += bits;
    if (filled >= 32) {
      const std::uint32_t word = static_cast<std::uint32_t>(pending);
      std::memcpy(to, &word, 4);
      to += 4;
      pending >>= 32;
      filled -= 32;
    }
  }
  if (filled > 0) {
    const std::uint32_t word = static_cast<std::uint32_t>(pending);
    std::memcpy(to, &word, 4);
  }
  return header;
}

}  // namespace obscura::detail
