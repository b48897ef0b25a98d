#include "scene/plan/plausible.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "scene/file/scene_json.h"
#include "scene/plan/unit_words.h"

namespace obscura {
namespace {

using namespace detail;

constexpr double kLongest_um = 1000;
constexpr double kColdest_K = 100, kHottest_K = 10000;
constexpr double kThinnest = 1e-4, kThickest = 1e6;
/// Extinctions that smoke, dust, fog and clouds have in m2/g: an amount in kg/m3 needs a thousand times as much.
constexpr double kLeast_m2_g = 0.01, kMost_m2_g = 10;
/// Zero degrees Celsius, and how far from it an offset may lie that is meant as it.
constexpr double kCelsius_K = 273.15, kAboutCelsius_K = 5;

std::string element(const char* list, std::size_t index) { return pointer_to(pointer_to("", list), index); }
std::string below(std::string pointer, std::initializer_list<std::string_view> keys) {
  for (const std::string_view key : keys) pointer = pointer_to(pointer, key);
  return pointer;
}
std::string text_of(const Vec3d& p) { return fmt::format("({:.4g}, {:.4g}, {:.4g})", p.x, p.y, p.z); }

/// Every spectral quantity of a scene, with its pointer.
void for_each_spectrum(const Description& scene,
                       const std::function<void(const std::string& pointer, const Spectrum&)>& visit) {
  const auto given = [&visit](const std::string& pointer, const std::optional<Spectrum>& spectrum) {
    if (spectrum) visit(pointer, *spectrum);
  };
  for (std::size_t i = 0; i < scene.bands.size(); ++i)
    visit(below(element("bands", i), {"response"}), scene.bands[i].response);
  for (std::size_t i = 0; i < scene.clouds.size(); ++i) {
    const CloudDescription& cloud = scene.clouds[i];
    const std::string pointer = element("clouds", i);
    for (std::size_t m = 0; m < cloud.media.size(); ++m) {
      const std::string medium = pointer_to(below(pointer, {"media"}), m);
      visit(below(medium, {"extinction"}), cloud.media[m].extinction);
      visit(below(medium, {"albedo"}), cloud.media[m].albedo);
    }
    given(below(pointer, {"source"}), cloud.given_radiance);
    visit(below(pointer, {"emission"}), cloud.emission);
  }
  for (std::size_t i = 0; i < scene.objects.size(); ++i)
    given(below(element("objects", i), {"radiance"}), scene.objects[i].radiance);
  for (const auto& [name, material] : scene.materials)
    visit(below("/materials", {name, "emissivity"}), material.emissivity);
  for (std::size_t i = 0; i < scene.hot_spheres.size(); ++i)
    given(below(element("sources", i), {"radiance"}), scene.hot_spheres[i].radiance);
  if (scene.sky) given("/environment/sky/radiance", scene.sky->radiance);
  if (scene.sun) visit("/environment/sun/irradiance", scene.sun->irradiance);
  if (scene.moon) visit("/environment/moon/irradiance", scene.moon->irradiance);
  if (scene.atmosphere) {
    visit("/environment/atmosphere/extinction_per_m", scene.atmosphere->extinction_per_m);
    given("/environment/atmosphere/radiance", scene.atmosphere->radiance);
  }
  for (std::size_t i = 0; i < scene.beams.size(); ++i)
    visit(below(element("beams", i), {"power"}), scene.beams[i].power);
}

/// What the octrees of one cloud say together.
struct WholeCloud {
  bool empty = true;
  double warmest_K = -kInfinity;             // of matter
  double deepest = 0;                        // largest optical depth of a line, in any band
  int deepest_band = 0;                      // where that is
  std::map<std::string, std::string> units;  // by grid
};

WholeCloud whole_cloud(const std::string& name, const MediaSummary& summary, const std::vector<OctreeRecord>& octrees) {
  WholeCloud whole;
  std::vector<double> depths(summary.intervals.size(), 0.0);
  for (const CloudSummary& part : summary.clouds) {
    if (part.name != name || part.empty) continue;
    whole.empty = false;
    whole.warmest_K = std::max(whole.warmest_K, part.warmest_K);
    for (std::size_t i = 0; i < depths.size(); ++i) depths[i] += part.intervals[i].depth_in_box;
  }
  for (std::size_t i = 0; i < depths.size(); ++i) {
    if (!(depths[i] > whole.deepest)) continue;
    whole.deepest = depths[i];
    whole.deepest_band = summary.intervals[i].band;
  }
  for (const OctreeRecord& octree : octrees) {
    if (octree.name == name) whole.units.insert(octree.units.begin(), octree.units.end());
  }
  return whole;
}

/// Looks at one cloud after another.
class CloudJudge {
 public:
  CloudJudge(const Description& scene, std::vector<std::string>& warnings) : scene_(scene), warnings_(warnings) {}

  void judge(std::size_t index, const WholeCloud& whole) {
    cloud_ = &scene_.clouds[index];
    pointer_ = element("clouds", index);
    who_ = fmt::format("cloud \"{}\": ", cloud_->name);
    if (whole.empty) return judge_empty();
    judge_amounts(whole);
    if (cloud_->temperature && !judge_kelvin_units(whole)) judge_temperature(whole);
    judge_depth(whole);
  }

 private:
  void warn(std::string sentence) { warnings_.push_back(std::move(sentence)); }

  void judge_empty() {
    std::string grids;
    for (const MediumDescription& medium : cloud_->media) {
      if (grids.find('"' + medium.density + '"') == std::string::npos)
        grids += (grids.empty() ? "\"" : ", \"") + medium.density + '"';
    }
    warn(
        fmt::format("{}no voxel of its density ({}) is above 0: the cloud is not there; is it the right grid of the "
                    "right file?",
                    who_, grids));
  }

  /// Largest extinction of a medium in any of the bands.
  double largest_extinction(const MediumDescription& medium) const {
    double largest = 0;
    for (const BandDescription& band : scene_.bands)
      largest = std::max(largest,
                         band.grey() ? medium.extinction.max() : medium.extinction.max((*band.um)[0], (*band.um)[1]));
    return largest;
  }

  /// An amount in kg/m3 beside an extinction in m2/g.
  void judge_amounts(const WholeCloud& whole) {
    for (std::size_t m = 0; m < cloud_->media.size(); ++m) {
      const MediumDescription& medium = cloud_->media[m];
      const auto words = whole.units.find(medium.density);
      if (words == whole.units.end()) continue;
      const std::optional<AmountUnit> unit = amount_unit(words->second);
      const double extinction = largest_extinction(medium);
      if (!unit || unit->per_g_m3 == 1 || extinction < kLeast_m2_g || extinction > kMost_m2_g) continue;
      const std::string at = below(pointer_to(below(pointer_, {"media"}), m), {"extinction"});
      const std::string factor = unit->share_of_the_air
                                     ? fmt::format("{:g} times the air's density in kg/m3, about {:g} near the ground",
                                                   unit->per_g_m3, 1.2 * unit->per_g_m3)
                                     : fmt::format("{:g}", unit->per_g_m3);
      warn(fmt::format(
          "{}its grid \"{}\" is in {}, but {} is {:.4g}, as is usual in m2/g beside g/m3: if it is in m2/g, "
          "multiply it by {}",
          who_, medium.density, words->second, at, extinction, factor));
    }
  }

  /// The first band in which the cloud shines by its temperature and that reaches beyond `um`.
  const BandDescription* band_of_planck(double um) const {
    for (const BandDescription& band : scene_.bands) {
      const Emitter from = emitter(scene_, band, cloud_->temperature.has_value(), cloud_->given_radiance.has_value());
      if (from == Emitter::planck && (*band.um)[1] > um) return &band;
    }
    return nullptr;
  }

  /// A grid of degrees that is taken for kelvin, or the other way round. @returns whether it is
  bool judge_kelvin_units(const WholeCloud& whole) {
    const TemperatureDescription& t = *cloud_->temperature;
    const auto words = whole.units.find(t.grid);
    if (t.grid.empty() || words == whole.units.end() || !band_of_planck(0)) return false;
    const std::optional<KelvinScale> unit = kelvin_scale(words->second);
    if (!unit) return false;
    const std::string at = below(pointer_, {"temperature", "offset_K"});
    const bool about_celsius = std::abs(t.offset_K - kCelsius_K) < kAboutCelsius_K;
    if (unit->offset_K > 0 && std::abs(t.offset_K - unit->offset_K) > kAboutCelsius_K) {
      warn(fmt::format(
          "{}its grid \"{}\" is in {}, and offset_K is {:g}: its hottest voxel has {:.4g} K; give {} as {:g}{}", who_,
          t.grid, words->second, t.offset_K, whole.warmest_K, at, unit->offset_K,
          unit->scale == 1 ? "" : fmt::format(" and the scale as {:.4g}", unit->scale)));
      return true;
    }
    // What is in kelvin as a difference to 273.15 K needs that offset.
    if (unit->offset_K == 0 && about_celsius && t.scale == 1 && whole.warmest_K - t.offset_K > kColdest_K) {
      warn(fmt::format("{}its grid \"{}\" is in {}, and offset_K is {:g}: its hottest voxel has {:.4g} K; leave {} out",
                       who_, t.grid, words->second, t.offset_K, whole.warmest_K, at));
      return true;
    }
    return false;
  }

  void judge_temperature(const WholeCloud& whole) {
    const BandDescription* const band = band_of_planck(kThermal_um);
    const double K = whole.warmest_K;
    if (!band || (K >= kColdest_K && K <= kHottest_K)) return;
    const TemperatureDescription& t = *cloud_->temperature;
    const std::string at = below(pointer_, {"temperature"});
    if (t.grid.empty()) {
      warn(K < kColdest_K
               ? fmt::format("{}{}/K is {:.4g} in the thermal band \"{}\": is it in degC? Give {:.5g}", who_, at, K,
                             band->name, K + kCelsius_K)
               : fmt::format("{}{}/K is {:.4g} in the thermal band \"{}\": give kelvin", who_, at, K, band->name));
      return;
    }
    std::string likely;
    if (K > kHottest_K || t.offset_K != 0) {
      likely = fmt::format("{0}/scale ({1:g}) and {0}/offset_K ({2:g}) have to make kelvin of the grid \"{3}\"", at,
                           t.scale, t.offset_K, t.grid);
    } else if (K == 0) {
      likely = fmt::format(
          "does the grid \"{}\" hold nothing where the density is, or is it in degC? Then give "
          "{}/offset_K as {:g}",
          t.grid, at, kCelsius_K);
    } else {
      likely = fmt::format("is the grid \"{}\" in degC? Then give {}/offset_K as {:g}", t.grid, at, kCelsius_K);
    }
    warn(fmt::format("{}its hottest voxel has {:.4g} K in the thermal band \"{}\": {}", who_, K, band->name, likely));
  }

  /// By the band in which the cloud is deepest: a wrong unit is wrong in all of them.
  void judge_depth(const WholeCloud& whole) {
    const std::string& band = scene_.bands[static_cast<std::size_t>(whole.deepest_band)].name;
    const bool glows = !(cloud_->emission == Spectrum::constant(0));
    if (whole.deepest > 0 && whole.deepest < kThinnest && !glows) {
      warn(
          fmt::format("{}its deepest ray has an optical depth of {:.2g} at most, in band \"{}\": it does not show; "
                      "density times {}/media/0/extinction has to be in 1/m: is the density in kg/m3 beside an "
                      "extinction in m2/g (a factor of 1000), or the lattice in km ({}/place/scale)?",
                      who_, whole.deepest, band, pointer_, pointer_));
    }
    if (whole.deepest > kThickest) {
      warn(
          fmt::format("{}its deepest ray has an optical depth of up to {:.2g}, in band \"{}\": it is as good as a "
                      "wall; density times {}/media/0/extinction has to be in 1/m: is the density in mg/m3 beside an "
                      "extinction in m2/g or the extinction in 1/km (a factor of 0.001), or the lattice in mm "
                      "({}/place/scale)?",
                      who_, whole.deepest, band, pointer_, pointer_));
    }
  }

  const Description& scene_;
  std::vector<std::string>& warnings_;
  const CloudDescription* cloud_ = nullptr;
  std::string pointer_, who_;
};

void judge_view(const Description& scene, const MediaSummary& summary, std::vector<std::string>& warnings) {
  if (!summary.box_out_of_view || std::ranges::find(summary.disc_in_view, true) != summary.disc_in_view.end()) return;
  const Box3d& box = *summary.box_out_of_view;
  warnings.push_back(fmt::format(
      "/sensor: no ray meets a cloud, an object or a source: they lie between {} and {} m, and the sensor "
      "at {} m looks at {} m: are all of them in metres, and the clouds upright?",
      text_of(box.min), text_of(box.max), text_of(scene.sensor.position_m), text_of(scene.sensor.look_at_m)));
}

}  // namespace

std::vector<std::string> detail::implausible_wavelengths(const Description& scene) {
  std::vector<std::string> warnings;
  const auto judge = [&warnings](const std::string& pointer, double first, double last) {
    if (!(last > kLongest_um)) return;
    warnings.push_back(
        fmt::format("{}: wavelengths of {:g} to {:g} um: if they are in nm, give {:g} to {:g}; if they are wavenumbers "
                    "in 1/cm, {:.4g} to {:.4g}",
                    pointer, first, last, 1e-3 * first, 1e-3 * last, 1e4 / last, 1e4 / first));
  };
  for (std::size_t i = 0; i < scene.bands.size(); ++i) {
    const auto& um = scene.bands[i].um;
    if (um) judge(below(element("bands", i), {"um"}), (*um)[0], (*um)[1]);
  }
  for_each_spectrum(scene, [&](const std::string& pointer, const Spectrum& spectrum) {
    const std::vector<double>& um = spectrum.nodes_um();
    if (!um.empty()) judge(pointer, um.front(), um.back());
  });
  return warnings;
}

std::vector<std::string> implausible_values(const Description& scene, const MediaSummary& summary,
                                            const std::vector<OctreeRecord>& octrees) {
  std::vector<std::string> warnings = detail::implausible_wavelengths(scene);
  CloudJudge clouds(scene, warnings);
  for (std::size_t c = 0; c < scene.clouds.size(); ++c)
    clouds.judge(c, whole_cloud(scene.clouds[c].name, summary, octrees));
  judge_view(scene, summary, warnings);
  return warnings;
}

}  // namespace obscura
