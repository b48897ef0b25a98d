#include "sensor/judge/agreement.h"

#include <algorithm>

#include "octree/base/error_scale.h"
#include "octree/base/statistics.h"

namespace obscura {
namespace {

/// Relative rounding error of the batched walk, whose arithmetic is float.
constexpr double kRounding = 1e-5;
/// Relative difference below which pixels without error are the same.
constexpr double kSame = 1e-4;
/// 99.9 % of normal numbers lie below this.
constexpr double kPower = 3.0902;

}  // namespace

Measured mean_of(std::span<const Measured> measurements) {
  if (measurements.empty()) return {0, std::numeric_limits<double>::infinity()};
  const auto count = static_cast<double>(measurements.size());
  Measured mean;
  double variance = 0, welch = 0;
  for (const Measured& m : measurements) {
    mean.value += m.value / count;
    mean.bias += m.bias / count;
    const double part = m.error * m.error / (count * count);
    variance += part;
    welch += part * part / m.freedom;
  }
  mean.error = std::sqrt(variance);
  if (welch > 0) mean.freedom = variance * variance / welch;
  return mean;
}

Agreement agreement(const Measured& a, const Measured& b, const AgreementRule& rule) {
  Agreement result;
  const double scale = std::max(std::abs(a.value), std::abs(b.value));
  result.difference = a.value - b.value;
  result.error = std::hypot(a.error, b.error);
  const double va = a.error * a.error, vb = b.error * b.error;
  const double welch = va * va / a.freedom + vb * vb / b.freedom;
  const double freedom = welch > 0 ? (va + vb) * (va + vb) / welch : std::numeric_limits<double>::infinity();
  result.limit = student_limit(rule.false_alarm, std::max(1.0, freedom));
  const double allowance = a.bias + b.bias + kRounding * scale;
  const double left = std::abs(result.difference) - allowance;
  result.z = result.error > 0 ? result.difference / result.error
             : left > 0       ? std::copysign(std::numeric_limits<double>::infinity(), result.difference)
                              : 0.0;
  result.agree = left <= result.limit * result.error;
  result.relative = scale > 0 ? result.difference / scale : 0.0;
  result.detectable = scale > 0 ? (allowance + (result.limit + kPower) * result.error) / scale : 0.0;
  if (rule.resolution <= 0) return result;
  result.sharp = scale > 0 && result.detectable <= rule.resolution;
  const double room = rule.resolution * scale - allowance, reach = (result.limit + kPower) * result.error;
  if (!result.sharp)
    result.samples_factor = room > 0 ? reach * reach / (room * room) : std::numeric_limits<double>::infinity();
  return result;
}

PixelAgreement pixel_agreement(const PixelView& a, const PixelView& b, double slack) {
  PixelAgreement result;
  double largest = 0;
  for (const float value : b.value) largest = std::max(largest, std::abs(static_cast<double>(value)));
  const auto bias = [](const PixelView& view, std::size_t i) {
    return view.bias.empty() ? 0.0 : std::abs(static_cast<double>(view.bias[i]));
  };
  double left2 = 0, z2 = 0, relative2 = 0;
  std::size_t inside = 0;
  bool equal = true;
  for (std::size_t i = 0; i < a.value.size(); ++i) {
    const double va = a.value[i], vb = b.value[i];
    const double difference = va - vb;
    const double floor = error_scale(vb, largest);
    if (floor > 0) relative2 += difference * difference / (floor * floor);
    const double rounding = kRounding * std::max(std::abs(va), std::abs(vb));
    const double error = std::hypot(static_cast<double>(a.error[i]), static_cast<double>(b.error[i]));
    const double left = std::max(0.0, std::abs(difference) - bias(a, i) - bias(b, i) - rounding);
    // Errors below rounding measure nothing: these pixels have to be equal.
    if (error <= rounding) {
      equal = equal && left <= error + kSame * floor;
      continue;
    }
    ++result.pixels;
    z2 += difference * difference / (error * error);
    left2 += left * left / (error * error);
    inside += left <= 1.96 * error ? 1 : 0;
  }
  const auto all = static_cast<double>(a.value.size());
  if (all > 0) result.image_error = std::sqrt(relative2 / all);
  if (result.pixels > 0) {
    const auto count = static_cast<double>(result.pixels);
    result.z = std::sqrt(z2 / count);
    result.rms_z = std::sqrt(left2 / count);
    result.inside = static_cast<double>(inside) / count;
    // The RMS of few normal numbers scatters: five of its standard deviations are allowed.
    const double scatter = slack + 5 / std::sqrt(2 * count);
    result.low = std::max(0.0, 1 - scatter);
    result.high = 1 + scatter;
    result.agree = result.rms_z <= result.high;
  }
  result.agree = result.agree && equal;
  return result;
}

}  // namespace obscura
