#include "scene/study/study_setting.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "photon/world/spectral_world.h"
#include "scene/file/scene_limits.h"
#include "scene/plan/plan.h"

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
      given.method.nearest *
      std::pow(photons / static_cast<double>(std::max<std::uint64_t>(1, given.method.photons)), kNearestPower);
  return std::round(std::clamp(k, static_cast<double>(kFewNearest), static_cast<double>(kMostNearest)));
}

/// Above the scene's own setting the rays of a pixel grow as the noise of its samples falls: else theirs would stay.
/// More rays than samples serve little below it.
double rays_on_ladder(const StudySetting& given, const StudySetting& s) {
  if (s.method.type == &kPhotonMap) {
    const double above =
        static_cast<double>(s.method.photons) / static_cast<double>(std::max<std::uint64_t>(1, given.method.photons));
    return given.rays * std::max(1.0, std::pow(above, kNearestPower));
  }
  return s.method.samples > given.method.samples
             ? static_cast<double>(given.rays) * s.method.samples / given.method.samples
             : std::min(given.rays, s.method.samples);
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

const char* name_of(Kernel kernel) noexcept {
  constexpr std::array<const char*, 4> names{"constant", "epanechnikov", "cone", "gaussian"};
  return names[static_cast<std::size_t>(kernel)];
}

StudySetting scaled(const StudyTraits& traits, StudySetting s, double factor) {
  if (s.method.type->cells) {
    s.method.cells = rounded(s.method.cells * std::cbrt(factor), 1, kMostCells);
  } else if (!traits.scatters) {
    s.rays = rounded(s.rays * factor, 1, traits.most_rays);
    if (s.method.samples > 0) s.method.samples = std::max(s.method.samples, s.rays);
  } else {
    const StudySetting& given = traits.given;
    const bool map = !s.method.type->samples;
    const double rays = rays_on_ladder(given, s);
    if (s.method.type->photons) {
      const double before = nearest_on_ladder(given, static_cast<double>(s.method.photons));
      s.method.photons = photons(static_cast<double>(s.method.photons) * factor);
      // Through the scene's own setting, whatever was rounded on the way.
      if (std::abs(static_cast<double>(s.method.photons) / static_cast<double>(given.method.photons) - 1) < 0.01)
        s.method.photons = given.method.photons;
      if (map)
        s.method.nearest = rounded(
            s.method.nearest * nearest_on_ladder(given, static_cast<double>(s.method.photons)) / before, 1, 100000);
    }
    if (!map) s.method.samples = rounded(s.method.samples * factor, 1, 1 << 24);
    s.rays = rounded(s.rays * rays_on_ladder(given, s) / rays, 1, traits.most_rays);
  }
  return s;
}

StudySetting first_rung(const StudyTraits& traits, const MethodType* method) {
  const StudySetting& given = traits.given;
  StudySetting s;
  s.method.type = method;
  s.rays = given.rays;
  s.octree_tolerance = given.octree_tolerance;
  s.intervals = given.intervals;
  if (method->cells) {
    s.method.cells = kFewCells;
    s.method.order = 8;
    return s;
  }
  if (method->photons) {
    s.method.photons =
        traits.scatters ? std::max<std::uint64_t>(given.method.photons, 1) : std::min(given.method.photons, kNoPhotons);
    s.method.nearest = given.method.nearest;
    s.method.kernel = given.method.kernel;
  }
  if (method->samples) s.method.samples = given.method.samples;
  if (!traits.scatters) {
    s.rays = 1;
    if (s.method.samples > 0) s.method.samples = 1;
    return s;
  }
  const double few = !method->photons ? 1
                     : method->samples
                         ? std::max(kFewPhotons, static_cast<double>(given.method.photons) / given.method.samples)
                         : kFewPhotons;
  const int below = rungs_below(method->photons ? static_cast<double>(s.method.photons) : given.method.samples, few);
  return scaled(traits, s, std::pow(kRung, -below));
}

std::vector<StudyVariation> variations(const StudyTraits& traits, const StudySetting& base) {
  std::vector<StudyVariation> result;
  const auto vary = [&](const std::string& knob, const auto& change) {
    StudySetting changed = base;
    change(changed);
    if (!(changed == base)) result.push_back({knob, changed});
  };
  const bool maps = base.method.type->photons;
  if (maps && traits.scatters) {
    for (const double factor : {0.25, 4.0}) {
      vary("nearest", [&](StudySetting& s) { s.method.nearest = rounded(s.method.nearest * factor, 2, 100000); });
    }
    for (const Kernel kernel : {Kernel::constant, Kernel::epanechnikov, Kernel::cone, Kernel::gaussian}) {
      vary("kernel", [&](StudySetting& s) { s.method.kernel = kernel; });
    }
  }
  if (traits.scatters) {
    for (const double factor : {0.25, 4.0}) {
      vary("rays", [&](StudySetting& s) { s.rays = rounded(s.rays * factor, 1, traits.most_rays); });
    }
  }
  if (maps && base.method.type->samples && traits.scatters) {
    for (const double factor : {0.25, 4.0}) {
      vary("photons",
           [&](StudySetting& s) { s.method.photons = photons(static_cast<double>(s.method.photons) * factor); });
    }
  }
  if (base.method.type->cells) {
    for (const int order : {4, 16}) vary("order", [&](StudySetting& s) { s.method.order = order; });
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
  if (knob == "nearest")
    s.method.nearest = rounded(by_ratio(s.method.nearest, base.method.nearest, changed.method.nearest), 2, 100000);
  if (knob == "kernel") s.method.kernel = changed.method.kernel;
  if (knob == "rays") s.rays = changed.rays;
  if (knob == "photons")
    s.method.photons = photons(by_ratio(static_cast<double>(s.method.photons), static_cast<double>(base.method.photons),
                                        static_cast<double>(changed.method.photons)));
  if (knob == "order") s.method.order = changed.method.order;
  if (knob == "octree_tolerance") s.octree_tolerance = changed.octree_tolerance;
  if (knob == "intervals") s.intervals = changed.intervals;
  return s;
}

StudyWork work_of(const StudySetting& s) {
  const double intervals = std::max(1, s.intervals);
  // Beside its paths a ray costs what the walk through the clouds does.
  const double rays = s.rays;
  const Method& m = s.method;
  const auto map = static_cast<double>(m.photons);
  if (m.type->cells) return {intervals * std::pow(m.cells, 3) * m.order * m.order, intervals * rays * m.cells};
  if (!m.type->samples) return {map, intervals * rays * (m.nearest + 32.0)};
  const double paths = intervals * (m.samples + 0.5 * rays);
  return m.type->photons ? StudyWork{map, paths * (m.nearest + 96.0)} : StudyWork{0, paths};
}

std::string study_label(const StudySetting& s) {
  const Method& m = s.method;
  std::string text = m.type->name;
  if (m.type->photons) text += fmt::format(", {} photons, {} nearest", grouped(m.photons), m.nearest);
  if (m.type->samples) text += fmt::format(", {} sample{}", m.samples, m.samples == 1 ? "" : "s");
  if (m.type->cells) text += fmt::format(", {} cells, S{}", m.cells, m.order);
  if (m.type->photons && m.kernel != Kernel::epanechnikov) text += fmt::format(", {} kernel", name_of(m.kernel));
  text += fmt::format(", {} ray{}", s.rays, s.rays == 1 ? "" : "s");
  if (s.octree_tolerance != 1e-3) text += fmt::format(", tolerance {:.4g}", s.octree_tolerance);
  if (s.intervals > 0) text += fmt::format(", {} interval{}", s.intervals, s.intervals == 1 ? "" : "s");
  return text;
}

std::vector<std::pair<std::string, std::string>> scene_edits(const StudySetting& s, const std::vector<bool>& grey) {
  std::vector<std::pair<std::string, std::string>> edits;
  if (!renders(s.method.type)) return edits;
  const auto edit = [&](std::string pointer, std::string value) {
    edits.emplace_back(std::move(pointer), std::move(value));
  };
  const Method& m = s.method;
  edit("/render/method", fmt::format("\"{}\"", m.type->word));
  if (m.type->photons) {
    edit("/render/photons", std::to_string(m.photons));
    edit("/render/nearest", std::to_string(m.nearest));
    edit("/render/kernel", fmt::format("\"{}\"", name_of(m.kernel)));
    edit("/render/final_gather", m.type->samples ? "1" : "0");
  }
  if (m.samples > 0) edit("/render/samples", std::to_string(m.samples));
  edit("/sensor/max_oversampling", std::to_string(s.rays));
  edit("/render/octree_tolerance", fmt::format("{:.10g}", s.octree_tolerance));
  for (std::size_t b = 0; b < grey.size() && s.intervals > 0; ++b) {
    if (!grey[b]) edit(fmt::format("/bands/{}/samples", b), std::to_string(s.intervals));
  }
  return edits;
}

Method full_method(const StudySetting& setting, const Description& scene) {
  Method method = method_of(scene, *setting.method.type);
  const Method& m = setting.method;
  if (m.photons > 0) method.photons = m.photons;
  if (m.nearest > 0) method.nearest = m.nearest;
  method.kernel = m.kernel;
  if (m.samples > 0) method.samples = m.samples;
  method.cells = m.cells;
  if (m.order > 0) method.order = m.order;
  return method;
}

StudyTraits traits_of(const Description& scene, const World& world, const Method& method) {
  StudyTraits traits;
  traits.scatters = redirects_light(world);
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

  StudySetting& given = traits.given;
  given.method = no_work(*method.type);
  given.method.photons = method.photons;
  given.method.nearest = method.nearest;
  given.method.kernel = method.kernel;
  given.method.samples = method.samples;
  given.rays = scene.sensor.max_oversampling;
  given.octree_tolerance = scene.render.octree_tolerance;
  return traits;
}

}  // namespace obscura
