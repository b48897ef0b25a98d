#include "sensor/judge/compare.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "octree/base/error_scale.h"

namespace obscura {
namespace {

// Channels that describe the estimate, not the scene.
bool describes_estimate(const std::string& name) {
  return name.ends_with(".error") || name.ends_with(".bias") || name == "rays.N";
}

// An empty span where the image has no such channel.
std::span<const float> channel_if(const Image& image, const std::string& name) {
  return image.has(name) ? image.channel(name) : std::span<const float>();
}

struct Scatter {
  double sum = 0, sum2 = 0;
  std::uint64_t count = 0;

  void add(double z) {
    sum += z;
    sum2 += z * z;
    ++count;
  }
};

ChannelDifference compare_channel(const std::string& name, const Image& image, const Image& reference,
                                  const std::vector<bool>& done) {
  ChannelDifference result;
  result.channel = name;
  const std::span<const float> value = image.channel(name);
  const std::span<const float> expected = reference.channel(name);

  // The floor keeps dark pixels from ruling the mean.
  double largest = 0;
  for (std::size_t i = 0; i < value.size(); ++i) {
    if (done[i] && std::isfinite(expected[i])) {
      largest = std::max(largest, std::abs(static_cast<double>(expected[i])));
    }
  }
  const double floor = error_scale(0, largest);

  std::span<const float> error, error_reference;
  if (constexpr std::string_view suffix = "radiance"; name.ends_with(".radiance")) {
    const std::string twin = name.substr(0, name.size() - suffix.size()) + "error";
    error = channel_if(image, twin);
    error_reference = channel_if(reference, twin);
  }

  double sum2 = 0;
  std::uint64_t finite = 0;
  Scatter z;
  for (std::size_t i = 0; i < value.size(); ++i) {
    if (!done[i]) continue;
    ++result.pixels;
    if (!std::isfinite(value[i]) || !std::isfinite(expected[i])) {
      if (value[i] != expected[i]) ++result.mismatched;
      continue;
    }
    ++finite;
    const double difference = static_cast<double>(value[i]) - expected[i];
    const double scale = std::max(std::abs(static_cast<double>(expected[i])), floor);
    if (difference != 0) sum2 += difference * difference / (scale * scale);
    result.mean += value[i];
    result.mean_reference += expected[i];
    result.max_difference = std::max(result.max_difference, std::abs(difference));
    if (!error.empty() || !error_reference.empty()) {
      const double noise = std::hypot(error.empty() ? 0 : error[i], error_reference.empty() ? 0 : error_reference[i]);
      if (noise > 0 || difference != 0) z.add(difference / noise);
    }
  }
  if (finite > 0) {
    result.image_error = std::sqrt(sum2 / static_cast<double>(finite));
    result.mean /= static_cast<double>(finite);
    result.mean_reference /= static_cast<double>(finite);
  }
  if (result.mean != result.mean_reference) result.mean_ratio = result.mean / result.mean_reference;
  if (z.count > 0) {
    result.z_rms = std::sqrt(z.sum2 / static_cast<double>(z.count));
    result.z_mean = z.sum / static_cast<double>(z.count);
  }
  return result;
}

std::string or_dash(const std::optional<double>& value) { return value ? fmt::format("{:.3g}", *value) : "-"; }

}  // namespace

Comparison compare(const Image& image, const Image& reference) {
  if (image.columns() != reference.columns() || image.rows() != reference.rows()) {
    throw InputError("compare",
                     fmt::format("the images differ in size: {} x {} and {} x {}", image.columns(), image.rows(),
                                 reference.columns(), reference.rows()),
                     "render both at one resolution");
  }
  std::vector<bool> done(image.pixel_count(), true);
  for (const Image* one : {&image, &reference}) {
    const std::span<const float> rays = channel_if(*one, "rays.N");
    for (std::size_t i = 0; i < rays.size(); ++i) {
      if (!(rays[i] > 0)) done[i] = false;
    }
  }
  if (std::ranges::find(done, true) == done.end()) {
    throw InputError("compare", "no pixel is done in both images", "let both renderings finish");
  }

  Comparison result;
  for (const std::string& name : reference.channels()) {
    if (!image.has(name)) {
      result.only_reference.push_back(name);
    } else if (!describes_estimate(name)) {
      result.channels.push_back(compare_channel(name, image, reference, done));
    }
  }
  for (const std::string& name : image.channels()) {
    if (!reference.has(name)) result.only_image.push_back(name);
  }
  if (result.channels.empty()) {
    throw InputError("compare",
                     fmt::format("the images have no channel in common: {} and {}", fmt::join(image.channels(), ", "),
                                 fmt::join(reference.channels(), ", ")),
                     "give the same names to the bands of both scenes");
  }
  return result;
}

double Comparison::image_error() const {
  const auto largest = [&](bool radiance_only) {
    double result = -1;
    for (const ChannelDifference& c : channels) {
      if (radiance_only && !c.channel.ends_with(".radiance")) continue;
      result = std::max(result, c.mismatched > 0 ? kInfinity : c.image_error);
    }
    return result;
  };
  const double radiance = largest(true);
  return radiance >= 0 ? radiance : largest(false);
}

std::string Comparison::table() const {
  std::size_t width = 7;
  for (const ChannelDifference& c : channels) width = std::max(width, c.channel.size());
  std::string text =
      fmt::format("{:<{}}  {:>11}  {:>12}  {:>12}  {:>9}  {:>12}  {:>7}  {:>7}  {:>9}\n", "channel", width,
                  "image error", "mean", "reference", "ratio", "largest", "z rms", "z mean", "pixels");
  for (const ChannelDifference& c : channels) {
    text += fmt::format("{:<{}}  {:>10.4g}%  {:>12.6g}  {:>12.6g}  {:>9.6g}  {:>12.4g}  {:>7}  {:>7}  {:>9}\n",
                        c.channel, width, 100 * c.image_error, c.mean, c.mean_reference, c.mean_ratio, c.max_difference,
                        or_dash(c.z_rms), or_dash(c.z_mean), c.pixels);
    if (c.mismatched > 0) {
      text += fmt::format("{:<{}}  infinite in one image only: {} pixels\n", "", width, c.mismatched);
    }
  }
  if (!only_image.empty()) {
    text += fmt::format("only in the image: {}\n", fmt::join(only_image, ", "));
  }
  if (!only_reference.empty()) {
    text += fmt::format("only in the reference: {}\n", fmt::join(only_reference, ", "));
  }
  return text;
}

}  // namespace obscura
