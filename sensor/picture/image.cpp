#include "sensor/picture/image.h"

#include <fmt/format.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cassert>
#include <cmath>

namespace obscura {
namespace {

std::string text(const Vec3d& v) { return fmt::format("[{}, {}, {}]", v.x, v.y, v.z); }

// The camera as a scene file's "sensor" would give it.
std::string camera_text(const CameraSettings& camera) {
  std::string view;
  switch (camera.projection) {
    case Projection::perspective:
      view = fmt::format(R"("perspective", "fov_deg": {})", camera.fov_deg);
      break;
    case Projection::orthographic:
      view = fmt::format(R"("orthographic", "width_m": {})", camera.width_m);
      break;
    case Projection::fisheye:
      view = fmt::format(R"("fisheye", "fov_deg": {})", camera.fov_deg);
      break;
  }
  return fmt::format(R"({{"position_m": {}, "look_at_m": {}, "up": {}, "projection": {}, "resolution": [{}, {}]}})",
                     text(camera.position_m), text(camera.look_at_m), text(camera.up), view, camera.resolution[0],
                     camera.resolution[1]);
}

/// Half-width of a 95 % interval over its standard error.
constexpr double kHalfWidth = 1.96;

/// Adds what was left out to the errors of a band.
void widen(std::span<float> error, const Film& film, int band, std::span<const LeftOut> left_out) {
  const std::span<const float> radiance = film.values(band, Film::Value::radiance),
                               transmission = film.values(band, Film::Value::transmission);
  for (std::size_t p = 0; p < error.size(); ++p) {
    if (!(film.ray_count()[p] > 0)) continue;
    double bound = 0;
    for (const LeftOut& left : left_out) {
      const bool touched =
          left.sky || (left.clouds && transmission[p] < 1) || (left.surfaces && std::isfinite(film.depth_m()[p]));
      if (touched) bound += left.radiance + left.share * std::abs(radiance[p]);
    }
    if (bound > 0) error[p] = std::max(error[p] + static_cast<float>(bound / kHalfWidth), Film::kLeast);
  }
}

void copy(std::span<const float> from, std::span<float> to) { std::ranges::copy(from, to.begin()); }

}  // namespace

void fill_temperature(const Band& band, std::span<const float> radiance, std::span<float> kelvin) {
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, radiance.size(), 256), [&](const auto& range) {
    for (std::size_t i = range.begin(); i != range.end(); ++i) {
      if (!(radiance[i] > 0)) continue;
      const auto value = static_cast<float>(band.brightness_temperature(radiance[i]));
      kelvin[i] = std::isfinite(value) ? value : 0;
    }
  });
}

Image::Image(int columns, int rows) : columns_(columns), rows_(rows) { assert(columns >= 1 && rows >= 1); }

bool Image::has(std::string_view name) const noexcept { return std::ranges::find(names_, name) != names_.end(); }

std::span<float> Image::add(std::string name) {
  assert(!has(name));
  names_.push_back(std::move(name));
  return values_.emplace_back(pixel_count());
}

std::span<const float> Image::channel(std::string_view name) const {
  const auto found = std::ranges::find(names_, name);
  if (found == names_.end()) {
    throw InputError("image", fmt::format("has no channel {}", name),
                     fmt::format("it has {}", fmt::join(names_, ", ")));
  }
  return values_[static_cast<std::size_t>(found - names_.begin())];
}

Image develop(const Film& film, std::span<const Band> bands, const ImageOrigin& origin) {
  assert(static_cast<int>(bands.size()) == film.bands());
  using enum Film::Value;
  Image image(film.columns(), film.rows());
  for (int b = 0; b < film.bands(); ++b) {
    const Band& band = bands[static_cast<std::size_t>(b)];
    copy(film.values(b, radiance), image.add(band.name() + ".radiance"));
    const std::span<float> errors = image.add(band.name() + ".error");
    copy(film.values(b, error), errors);
    if (origin.bias_is_error)
      std::ranges::transform(errors, film.values(b, bias), errors.begin(),
                             [](float e, float d) { return std::hypot(e, d); });
    if (!origin.left_out.empty()) widen(errors, film, b, origin.left_out[static_cast<std::size_t>(b)]);
    if (origin.has_bias) copy(film.values(b, bias), image.add(band.name() + ".bias"));
    copy(film.values(b, transmission), image.add(band.name() + ".transmission"));
    if (origin.has_atmosphere) {
      copy(film.values(b, transmission_atmosphere), image.add(band.name() + ".transmission_atmosphere"));
    }
    if (!band.grey()) {
      fill_temperature(band, film.values(b, radiance), image.add(band.name() + ".temperature"));
    }
  }
  copy(film.depth_m(), image.add("depth.Z"));
  copy(film.object_id(), image.add("object.id"));
  copy(film.ray_count(), image.add("rays.N"));
  if (origin.has_criterion) {
    copy(film.criterion(), image.add("rays.criterion"));
    std::string names;
    for (int c = 0; c < kCriteria; ++c)
      names += fmt::format("{}{} {}", c > 0 ? ", " : "", c, name(static_cast<Criterion>(c)));
    image.metadata["obscura:rays.criterion"] = names;
  }

  std::vector<std::string> names;
  for (const Band& band : bands) {
    names.push_back(band.name());
    const std::string key = "obscura:band." + band.name();
    if (band.grey()) {
      image.metadata[key + ".units"] = "radiance and error in the scene's own unit (grey)";
    } else {
      image.metadata[key + ".um_min"] = band.um_min();
      image.metadata[key + ".um_max"] = band.um_max();
      image.metadata[key + ".units"] = "radiance, error and bias in W/m2/sr, temperature in K";
    }
  }
  image.metadata["obscura:bands"] = fmt::format("{}", fmt::join(names, ", "));
  image.metadata["obscura:units"] =
      "radiance W/m2/sr (grey: the scene's own unit), temperature K, depth m, transmission 0 to 1";
  image.metadata["obscura:version"] = OBSCURA_VERSION;
  image.metadata["obscura:seed"] = fmt::format("{}", origin.seed);
  image.metadata["obscura:scene"] = origin.scene_name;
  image.metadata["obscura:scene_hash"] = origin.scene_hash;
  image.metadata["obscura:method"] = origin.method;
  image.metadata["obscura:time_s"] = origin.time_s;
  image.metadata["obscura:dropped_bound"] = origin.dropped_bound;
  image.metadata["obscura:camera"] = camera_text(origin.camera);
  image.metadata["obscura:partial"] = film.partial() ? 1 : 0;
  image.metadata["obscura:done"] = static_cast<double>(film.pixels_done()) / static_cast<double>(image.pixel_count());
  return image;
}

std::vector<std::string> band_names(const Image& image) {
  constexpr std::string_view suffix = ".radiance";
  std::vector<std::string> result;
  for (const std::string& name : image.channels()) {
    if (name.ends_with(suffix)) result.push_back(name.substr(0, name.size() - suffix.size()));
  }
  const auto found = image.metadata.find("obscura:bands");
  if (found == image.metadata.end()) return result;
  if (const auto* names = std::get_if<std::string>(&found->second)) {
    const std::string list = ", " + *names + ", ";
    std::ranges::stable_sort(result, {}, [&](const std::string& name) { return list.find(", " + name + ", "); });
  }
  return result;
}

}  // namespace obscura
