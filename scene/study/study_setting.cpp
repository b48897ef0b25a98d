#include "scene/study/study_setting.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "photon/world/world.h"
#include "scene/file/scene_limits.h"

namespace obscura {
namespace {

/// Photons of the lowest rung, about; nearest at least and at most on a ladder.
constexpr double kFewPhotons = 5000;
constexpr int kFewNearest = 8, kMostNearest = 1024;
/// Photons where none is asked for: maps still have to be there.
constexpr std::uint64_t kNoPhotons = 1000;
constexpr double kMostPhotons = 2e8;
constexpr int kFewCells = 8, kMostCells = 64;
constexpr double kNearestPower = 4.0 / 7;

int rounded(double value, int least, int most) {
  return static_cast<int>(std::clamp(std::round(value), static_cast<double>(least), static_cast<double>(most)));
}

std::uint64_t photons(double value) {
  return static_cast<std::uint64_t>(std::clamp(std::round(value), 1.0, kMostPhotons));
}

/// The balance of noise k^(-1/2) and bias (k/N)^(2/3), through the scene's own setting.
double nearest_on_ladder(const StudySetting& given, double photons) {
  const double k =
      given.nearest * std::pow(photons / static_cast<double>(std::max<std::uint64_t>(1, given.photons)), kNearestPower);
  return std::round(std::clamp(k, static_cast<double>(kFewNearest), static_cast<double>(kMostNearest)));
}

/// Above the scene's own setting the rays of a pixel grow as the noise of its samples falls: else theirs would stay.
/// More rays than samples serve little below it.
double rays_on_ladder(const StudySetting& given, const StudySetting& s) {
  if (s.method == StudyMethod::photon) {
    const double above =
        static_cast<double>(s.photons) / static_cast<double>(std::max<std::uint64_t>(1, given.photons));
    return given.rays * std::max(1.0, std::pow(above, kNearestPower));
  }
  return s.samples > given.samples ? static_cast<double>(given.rays) * s.samples / given.samples
                                   : std::min(given.rays, s.samples);
}

/// How many rungs below a value the lowest one is.
int rungs_below(double value, double least) {
  return value > least ? static_cast<int>(std::floor(std::log(value / least) / std::log(kRung) + 1e-9)) : 0;
}

/// 2000000: "2,000,000"
std::string grouped(std::uint64_t number) {
  std::string text = std::to_string(number);
  for (std::size_t at = text.size(); at > 3; at -= 3) text.insert(at - 3, 1, ',');
  return text;
}

}  // namespace

const char* name_of(StudyMethod method) noexcept {
  constexpr std::array<const char*, 4> names{"photon map", "final gather", "path tracer", "ordinates"};
  return names[static_cast<std::size_t>(method)];
}

const char* name_of(Kernel kernel) noexcept {
  constexpr std::array<const char*, 4> names{"constant", "epanechnikov", "cone", "gaussian"};
  return names[static_cast<std::size_t>(kernel)];
}

StudySetting scaled(const StudyTraits& traits, StudySetting s, double factor) {
  if (s.method == StudyMethod::ordinates) {
    s.cells = rounded(s.cells * std::cbrt(factor), 1, kMostCells);
  } else if (!traits.scatters) {
    s.rays = rounded(s.rays * factor, 1, traits.most_rays);
    if (s.samples > 0) s.samples = std::max(s.samples, s.rays);
  } else {
    const StudySetting& given = traits.given;
    const bool map = s.method == StudyMethod::photon;
    const double rays = rays_on_ladder(given, s);
    if (s.method != StudyMethod::path) {
      const double before = nearest_on_ladder(given, static_cast<double>(s.photons));
      s.photons = photons(static_cast<double>(s.photons) * factor);
      // Through the scene's own setting, whatever was rounded on the way.
      if (std::abs(static_cast<double>(s.photons) / static_cast<double>(given.photons) - 1) < 0.01)
        s.photons = given.photons;
      if (map)
        s.nearest = rounded(s.nearest * nearest_on_ladder(given, static_cast<double>(s.photons)) / before, 1, 100000);
    }
    if (!map) s.samples = rounded(s.samples * factor, 1, 1 << 24);
    s.rays = rounded(s.rays * rays_on_ladder(given, s) / rays, 1, traits.most_rays);
  }
  return s;
}

StudySetting first_rung(const StudyTraits& traits, StudyMethod method) {
  const StudySetting& given = traits.given;
  StudySetting s;
  s.method = method;
  s.rays = given.rays;
  s.octree_tolerance = given.octree_tolerance;
  s.intervals = given.intervals;
  const bool maps = method == StudyMethod::photon || method == StudyMethod::gather;
  if (method == StudyMethod::ordinates) {
    s.cells = kFewCells;
    s.order = 8;
    return s;
  }
  if (maps) {
    s.photons = traits.scatters ? std::max<std::uint64_t>(given.photons, 1) : std::min(given.photons, kNoPhotons);
    s.nearest = given.nearest;
    s.kernel = given.kernel;
  }
  if (method != StudyMethod::photon) s.samples = given.samples;
  if (!traits.scatters) {
    s.rays = 1;
    if (s.samples > 0) s.samples = 1;
    return s;
  }
  const double few = method == StudyMethod::path ? 1
                     : method == StudyMethod::gather
                         ? std::max(kFewPhotons, static_cast<double>(given.photons) / given.samples)
                         : kFewPhotons;
  const int below = rungs_below(method == StudyMethod::path ? given.samples : static_cast<double>(s.photons), few);
  return scaled(traits, s, std::pow(kRung, -below));
}

std::vector<StudyVariation> variations(const StudyTraits& traits, const StudySetting& base) {
  std::vector<StudyVariation> result;
  const auto vary = [&](const std::string& knob, const auto& change) {
    StudySetting changed = base;
    change(changed);
    if (!(changed == base)) result.push_back({knob, changed});
  };
  const bool maps = base.method == StudyMethod::photon || base.method == StudyMethod::gather;
  if (maps && traits.scatters) {
    for (const double factor : {0.25, 4.0}) {
      vary("nearest", [&](StudySetting& s) { s.nearest = rounded(s.nearest * factor, 2, 100000); });
    }
    for (const Kernel kernel : {Kernel::constant, Kernel::epanechnikov, Kernel::cone, Kernel::gaussian}) {
      vary("kernel", [&](StudySetting& s) { s.kernel = kernel; });
    }
  }
  if (traits.scatters) {
    for (const double factor : {0.25, 4.0}) {
      vary("rays", [&](StudySetting& s) { s.rays = rounded(s.rays * factor, 1, traits.most_rays); });
    }
  }
  if (base.method == StudyMethod::gather && traits.scatters) {
    for (const double factor : {0.25, 4.0}) {
      vary("photons", [&](StudySetting& s) { s.photons = photons(static_cast<double>(s.photons) * factor); });
    }
  }
  if (base.method == StudyMethod::ordinates) {
    for (const int order : {4, 16}) vary("order", [&](StudySetting& s) { s.order = order; });
  }
  if (traits.clouds) {
    for (const double factor : {10.0, 0.1}) {
      vary("octree_tolerance",
           [&](StudySetting& s) { s.octree_tolerance = std::min(0.5, s.octree_tolerance * factor); });
    }
  }
  if (traits.spectral) {
    for (int intervals = 1; intervals <= 2 * traits.most_intervals || intervals <= 4; intervals *= 2) {
      if (intervals == (base.intervals > 0 ? base.intervals : traits.most_intervals)) continue;
      vary("intervals", [&](StudySetting& s) { s.intervals = intervals; });
    }
  }
  return result;
}

StudySetting with_knob(StudySetting s, const std::string& knob, const StudySetting& base, const StudySetting& changed) {
  const auto by_ratio = [](double value, double from, double to) { return from > 0 ? value * to / from : value; };
  if (knob == "nearest") s.nearest = rounded(by_ratio(s.nearest, base.nearest, changed.nearest), 2, 100000);
  if (knob == "kernel") s.kernel = changed.kernel;
  if (knob == "rays") s.rays = changed.rays;
  if (knob == "photons")
    s.photons = photons(by_ratio(static_cast<double>(s.photons), static_cast<double>(base.photons),
                                 static_cast<double>(changed.photons)));
  if (knob == "order") s.order = changed.order;
  if (knob == "octree_tolerance") s.octree_tolerance = changed.octree_tolerance;
  if (knob == "intervals") s.intervals = changed.intervals;
  return s;
}

StudyWork work_of(const StudySetting& s) {
  const double intervals = std::max(1, s.intervals);
  // Beside its paths a ray costs what the walk through the clouds does.
  const double rays = s.rays;
  switch (s.method) {
    case StudyMethod::photon:
      return {static_cast<double>(s.photons), intervals * rays * (s.nearest + 32.0)};
    case StudyMethod::gather:
      return {static_cast<double>(s.photons), intervals * (s.samples + 0.5 * rays) * (s.nearest + 96.0)};
    case StudyMethod::path:
      return {0, intervals * (s.samples + 0.5 * rays)};
    case StudyMethod::ordinates:
      break;
  }
  return {intervals * std::pow(s.cells, 3) * s.order * s.order, intervals * rays * s.cells};
}

std::string study_label(const StudySetting& s) {
  std::string text = name_of(s.method);
  switch (s.method) {
    case StudyMethod::photon:
      text += fmt::format(", {} photons, {} nearest", grouped(s.photons), s.nearest);
      break;
    case StudyMethod::gather:
      text += fmt::format(", {} photons, {} nearest, {} sample{}", grouped(s.photons), s.nearest, s.samples,
                          s.samples == 1 ? "" : "s");
      break;
    case StudyMethod::path:
      text += fmt::format(", {} sample{}", s.samples, s.samples == 1 ? "" : "s");
      break;
    case StudyMethod::ordinates:
      text += fmt::format(", {} cells, S{}", s.cells, s.order);
      break;
  }
  const bool maps = s.method == StudyMethod::photon || s.method == StudyMethod::gather;
  if (maps && s.kernel != Kernel::epanechnikov) text += fmt::format(", {} kernel", name_of(s.kernel));
  text += fmt::format(", {} ray{}", s.rays, s.rays == 1 ? "" : "s");
  if (s.octree_tolerance != 1e-3) text += fmt::format(", tolerance {:.4g}", s.octree_tolerance);
  if (s.intervals > 0) text += fmt::format(", {} interval{}", s.intervals, s.intervals == 1 ? "" : "s");
  return text;
}

std::vector<std::pair<std::string, std::string>> scene_edits(const StudySetting& s, const std::vector<bool>& grey) {
  std::vector<std::pair<std::string, std::string>> edits;
  if (!renders(s.method)) return edits;
  const auto edit = [&](std::string pointer, std::string value) {
    edits.emplace_back(std::move(pointer), std::move(value));
  };
  const bool path = s.method == StudyMethod::path;
  edit("/render/method", path ? "\"path\"" : "\"photon\"");
  if (!path) {
    edit("/render/photons", std::to_string(s.photons));
    edit("/render/nearest", std::to_string(s.nearest));
    edit("/render/kernel", fmt::format("\"{}\"", name_of(s.kernel)));
    edit("/render/final_gather", s.method == StudyMethod::gather ? "1" : "0");
  }
  if (s.samples > 0) edit("/render/samples", std::to_string(s.samples));
  edit("/sensor/max_oversampling", std::to_string(s.rays));
  edit("/render/octree_tolerance", fmt::format("{:.10g}", s.octree_tolerance));
  for (std::size_t b = 0; b < grey.size() && s.intervals > 0; ++b) {
    if (!grey[b]) edit(fmt::format("/bands/{}/samples", b), std::to_string(s.intervals));
  }
  return edits;
}

void apply(const StudySetting& s, Description& scene) {
  RenderDescription& render = scene.render;
  render.method = s.method == StudyMethod::path ? MethodKind::path : MethodKind::photon;
  if (s.photons > 0) render.photons = s.photons;
  if (s.nearest > 0) render.nearest = s.nearest;
  render.kernel = s.kernel;
  render.final_gather = s.method == StudyMethod::gather ? 1 : 0;
  if (s.samples > 0) render.samples = s.samples;
  render.octree_tolerance = s.octree_tolerance;
  scene.sensor.max_oversampling = s.rays;
  for (BandDescription& band : scene.bands) {
    if (!band.grey() && s.intervals > 0) band.samples = s.intervals;
  }
}

StudyTraits traits_of(const Description& scene, const World& world, bool gathers) {
  StudyTraits traits;
  traits.scatters = false;
  for (int i = 0; i < world.interval_count(); ++i)
    traits.scatters = traits.scatters || world.scatters(i) || world.surfaces_reflect(i);
  traits.clouds = !scene.clouds.empty();
  traits.depth_limited = scene.sensor.scattering_depth.has_value();

  bool optics_vary = false;
  const auto look = [&](const Spectrum& spectrum) { optics_vary = optics_vary || !spectrum.is_constant(); };
  for (const CloudDescription& cloud : scene.clouds) {
    for (const MediumDescription& medium : cloud.media) look(medium.extinction), look(medium.albedo);
  }
  for (const auto& [name, material] : scene.materials) look(material.emissivity);
  if (scene.atmosphere) look(scene.atmosphere->extinction_per_m);
  for (const BandDescription& band : scene.bands) {
    if (band.grey()) continue;
    traits.most_intervals = std::max(traits.most_intervals, band.samples);
    traits.spectral = optics_vary;
  }

  const RenderDescription& render = scene.render;
  StudySetting& given = traits.given;
  given.method = render.method == MethodKind::path ? StudyMethod::path
                 : gathers                         ? StudyMethod::gather
                                                   : StudyMethod::photon;
  given.photons = render.photons;
  given.nearest = render.nearest;
  given.kernel = render.kernel;
  given.samples = render.samples;
  given.rays = scene.sensor.max_oversampling;
  given.octree_tolerance = render.octree_tolerance;
  return traits;
}

}  // namespace obscura
