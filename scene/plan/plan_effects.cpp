#include "scene/plan/plan_effects.h"

#include <fmt/format.h>

#include <algorithm>

#include "photon/limits/bounds.h"

namespace obscura::detail {
namespace {

/// Share of the budget that what is dropped may use.
constexpr double kDroppedShare = 0.1;

enum Effect {
  absorption,
  emission,
  single_scattering,
  multiple_scattering,
  surfaces,
  specular,
  sun,
  sky,
  atmosphere,
  time,
  spectral,
  masking
};

/// What is believed of the darkest radiance that a few of the picture's pixels have shown: others are darker.
constexpr double kBelieved = 0.5;
/// A difference of temperature that no one sees.
constexpr double kUnseen_K = 0.01;

/// A radiance over that of a pixel; 0 stays 0, even where the picture is black.
double over(double radiance, double scale) { return radiance > 0 ? (scale > 0 ? radiance / scale : kInfinity) : 0.0; }

std::string list_of(const std::vector<std::string>& names) {
  std::string list;
  for (const std::string& name : names) list += (list.empty() ? "\"" : ", \"") + name + '"';
  return list;
}

class Decider {
 public:
  Decider(const Description& scene, const MediaSummary& summary, double budget)
      : scene_(scene), summary_(summary), most_(kDroppedShare * budget), kept_(summary.clouds.size(), true) {
    result_.budget = {budget, 0, budget};
    // Bounds speak of the picture: what probes and rectangles measure may lie anywhere.
    only_image_ = scene.probes.empty() && scene.flux.empty();
  }

  Decisions run() {
    leave_out_clouds();
    for (int i = 0; i < static_cast<int>(summary_.intervals.size()); ++i) limits_.push_back(summary_.limits(i, kept_));
    for (const std::string& name : effect_names()) result_.rows.push_back({name, false, "", std::nullopt});
    find_bounds();
    say_what_is_there();
    force();
    drop();
    make_cuts();
    result_.left_out.resize(left_out_.size());
    for (const PlanRow& row : result_.rows) {
      if (row.on || forced(row.effect) || !(row.bound.value_or(0) > 0)) continue;
      result_.budget.dropped += *row.bound;
      const auto effect = static_cast<std::size_t>(&row - result_.rows.data());
      for (std::size_t b = 0; b < left_out_.size(); ++b) result_.left_out[b].push_back(left_out_[b][effect]);
    }
    result_.budget.sampled = result_.budget.total - result_.budget.dropped;
    return std::move(result_);
  }

 private:
  PlanRow& row(Effect effect) { return result_.rows[static_cast<std::size_t>(effect)]; }
  std::optional<bool> forced(const std::string& effect) const {
    const auto found = scene_.render.effects.find(effect);
    return found == scene_.render.effects.end() ? std::nullopt : std::optional<bool>(found->second);
  }
  std::optional<bool> forced(Effect effect) const { return forced(effect_names()[static_cast<std::size_t>(effect)]); }
  template <class Test>
  bool any_interval(Test&& test) const {
    return std::any_of(limits_.begin(), limits_.end(), test);
  }

  /// Leaves out clouds beside the picture where nothing in sight scatters or reflects: neither their light nor their
  /// shadow can reach it then.
  void leave_out_clouds() {
    if (!only_image_) return;
    for (const Effect effect : {absorption, emission, single_scattering, multiple_scattering}) {
      if (forced(effect) == true) return;
    }
    const auto scatters = [](const CloudLimits& limits) { return limits.scattering_depth > 0; };
    for (const CloudSummary& cloud : summary_.clouds) {
      if (cloud.in_view && std::any_of(cloud.intervals.begin(), cloud.intervals.end(), scatters)) return;
    }
    for (const IntervalLimits& limits : summary_.intervals) {
      if (limits.reflectance_max > 0) return;
    }
    for (std::size_t c = 0; c < kept_.size(); ++c) {
      kept_[c] = summary_.clouds[c].in_view;
      // A cloud whose grids lie on several lattices goes whole.
      for (const CloudSummary& cloud : summary_.clouds)
        kept_[c] = kept_[c] || (cloud.in_view && cloud.name == summary_.clouds[c].name);
      std::vector<std::string>& names = result_.cuts.clouds;
      const std::string& name = summary_.clouds[c].name;
      if (!kept_[c] && std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
    }
  }

  /// What each effect may contribute to the image at most.
  void find_bounds() {
    std::vector<EffectBounds> sums(summary_.bands.size());
    for (const IntervalLimits& limits : limits_) {
      const bool disc =
          std::find(summary_.disc_in_view.begin(), summary_.disc_in_view.end(), true) != summary_.disc_in_view.end();
      sums[static_cast<std::size_t>(limits.band)] += effect_bounds(limits, summary_.reach_m, disc);
    }
    left_out_.resize(sums.size());
    for (std::size_t b = 0; b < sums.size(); ++b) {
      const auto raise = [&](Effect effect, double radiance, double share = 0) {
        LeftOut& left = left_out_[b][static_cast<std::size_t>(effect)];
        left = where_of(effect);
        left.radiance = radiance;
        left.share = share;
        double& largest = bounds_[static_cast<std::size_t>(effect)];
        largest = std::max(largest, share + over(radiance, darkest(b, left)));
      };
      raise(emission, sums[b].emission);
      raise(single_scattering, sums[b].single_scattering);
      raise(multiple_scattering, sums[b].multiple_scattering);
      raise(sun, sums[b].sun);
      raise(sky, sums[b].sky);
      raise(specular, sums[b].specular);
      raise(atmosphere, std::max(sums[b].air_lost, sums[b].air_gained), sums[b].air_share);
    }
  }

  /// The pixels that an effect touches. What clouds do reaches others only by surfaces that reflect.
  LeftOut where_of(Effect effect) const {
    LeftOut where;
    const bool reflects = any_interval([](const IntervalLimits& limits) { return limits.reflectance_max > 0; });
    const bool scatters = any_interval([](const IntervalLimits& limits) { return limits.scattering_depth > 0; });
    const bool disc_in_view = std::ranges::find(summary_.disc_in_view, true) != summary_.disc_in_view.end();
    const bool clouds = any_interval([](const IntervalLimits& limits) { return limits.depth > 0; });
    where.clouds = clouds && (effect != specular || scatters);
    where.surfaces = !scene_.objects.empty() && (effect == atmosphere || effect == specular || reflects);
    where.sky = effect == sky || (effect == sun && disc_in_view);
    return where;
  }

  /// The least radiance that a pixel there may be taken to have.
  double darkest(std::size_t b, const LeftOut& where) const {
    const BandScale& band = summary_.bands[b];
    const double nedt_K = scene_.sensor.detector.of_band(scene_.bands[b].name).nedt_K;
    const double unseen = scene_.bands[b].grey() ? scene_.render.floor : std::max(kUnseen_K, nedt_K) * band.per_kelvin;
    double seen = where.sky ? band.least : kInfinity;
    if (where.clouds) seen = std::min(seen, band.least_cloudy);
    if (where.surfaces) seen = std::min(seen, band.least_on_surfaces);
    return std::max({band.floor, unseen, kBelieved * seen});
  }

  double& bound_of(Effect effect) { return bounds_[static_cast<std::size_t>(effect)]; }

  void say(Effect effect, bool on, std::string reason) {
    row(effect).on = on;
    row(effect).reason = std::move(reason);
  }
  void say_nothing_lost(Effect effect, std::string reason) {
    say(effect, false, std::move(reason));
    row(effect).bound = 0;
  }

  void say_what_is_there() {
    const bool left_out = !result_.cuts.clouds.empty();
    const std::string away = left_out ? list_of(result_.cuts.clouds) + " out of every ray's way" : "";
    // Of clouds: on, or gone with those that are left out, or absent.
    const auto cloudy = [&](Effect effect, bool on, bool present, const char* there, const char* absent) {
      if (on) return say(effect, true, there);
      if (present) return say_nothing_lost(effect, away);
      say(effect, false, absent);
    };
    const auto all = [this](auto&& test) {
      return std::any_of(summary_.intervals.begin(), summary_.intervals.end(), test);
    };
    const auto absorbs = [](const IntervalLimits& limits) { return limits.absorption_depth > 0; };
    const auto emits = [](const IntervalLimits& limits) { return limits.emits; };
    const auto scatters = [](const IntervalLimits& limits) { return limits.scattering_depth > 0; };
    cloudy(absorption, any_interval(absorbs), all(absorbs), "a cloud absorbs", "no cloud absorbs");
    if (row(absorption).on && left_out) row(absorption).reason += "; left out: " + away;
    cloudy(emission, any_interval(emits), all(emits), "a cloud emits",
           "no cloud has a temperature, source or emission");
    const bool limited = scene_.sensor.scattering_depth == 0;
    cloudy(single_scattering, any_interval(scatters) && !limited, all(scatters) && !limited, "a cloud scatters",
           all(scatters) ? "scattering_depth is 0" : "no cloud scatters");
    cloudy(multiple_scattering, row(single_scattering).on, all(scatters) && !limited,
           "a cloud scatters, and what it scatters may be scattered again",
           all(scatters) ? "scattering_depth is 0" : "no cloud scatters");

    const bool objects = !scene_.objects.empty();
    const bool mirrors = any_interval([](const IntervalLimits& limits) { return limits.mirror_max > 0; });
    const bool spheres = any_interval([](const IntervalLimits& limits) { return limits.sphere_min < kInfinity; });
    say(surfaces, objects, objects ? "the scene has objects" : "the scene has no objects");
    say(specular, mirrors && scene_.sensor.specular_depth > 0,
        !objects                                               ? "the scene has no objects"
        : !mirrors                                             ? "no object's material is mirror-like"
        : row(specular).on || scene_.sensor.specular_depth > 0 ? "a material is mirror-like"
                                                               : "specular_depth is 0");
    say_of_suns();
    const bool bright = any_interval([](const IntervalLimits& limits) { return limits.sky > 0; });
    say(sky, bright, bright ? "the sky is bright" : "the sky is dark");
    const bool air = any_interval([](const IntervalLimits& limits) { return limits.air_extinction > 0; });
    say(atmosphere, air,
        air                 ? "the air absorbs"
        : scene_.atmosphere ? "the air's extinction is 0"
                            : "the scene has no atmosphere");
    say(time, false, "nothing in the scene changes with time");
    say_of_intervals();
    say(masking, objects || spheres,
        objects && spheres ? "objects and hot spheres hide what is behind them"
        : objects          ? "objects hide what is behind them"
        : spheres          ? "hot spheres hide what is behind them"
                           : "nothing opaque is in the scene");
  }

  /// Sun and moon: each may be dark in these bands, hidden from everything, or without anything to shine on.
  void say_of_suns() {
    const bool shines = any_interval([](const IntervalLimits& limits) { return limits.sun > 0; });
    const bool acts = any_interval(
        [](const IntervalLimits& limits) { return limits.scattering_depth > 0 || limits.reflectance_max > 0; });
    if (!scene_.sun && !scene_.moon) return say(sun, false, "the scene has no sun and no moon");
    if (!shines) return say_nothing_lost(sun, "the bands have no solar part");
    std::string useless;
    std::size_t number = 0;
    const auto is_useless = [&](const std::optional<SunDescription>& wish) {
      if (!wish) return false;
      const std::size_t n = number++;
      if (!only_image_) return false;
      if (summary_.shaded[n]) {
        useless = wish->toward.z < 0 ? "below the horizon: the ground keeps its light from everything"
                                     : "a surface keeps its light from everything";
        return true;
      }
      if (acts || summary_.disc_in_view[n]) return false;
      useless = "nothing scatters or reflects its light, and its disc is beside the picture";
      return true;
    };
    const bool no_sun = is_useless(scene_.sun), no_moon = is_useless(scene_.moon);
    const bool with_sun = scene_.sun && !no_sun, with_moon = scene_.moon && !no_moon;
    if (!with_sun && !with_moon) return say_nothing_lost(sun, useless);
    if (forced(sun) != true) {
      result_.cuts.sun = no_sun;
      result_.cuts.moon = no_moon;
    }
    const bool low = (!with_sun || scene_.sun->toward.z < 0) && (!with_moon || scene_.moon->toward.z < 0);
    say(sun, true,
        with_sun && with_moon ? "the scene has a sun and a moon"
        : with_sun            ? "the scene has a sun"
                              : "the scene has a moon");
    if (low) row(sun).reason += ", below the horizon: nothing keeps its light from everything";
  }

  void say_of_intervals() {
    std::vector<int> solved(scene_.bands.size(), 0);
    for (const IntervalLimits& limits : limits_) ++solved[static_cast<std::size_t>(limits.band)];
    std::vector<std::string> alike;
    bool several = false;
    for (std::size_t b = 0; b < scene_.bands.size(); ++b) {
      several = several || solved[b] > 1;
      if (scene_.bands[b].samples > 1 && !scene_.bands[b].grey() && solved[b] == 1)
        alike.push_back(scene_.bands[b].name);
    }
    if (several) {
      say(spectral, true, "a band has several intervals");
    } else if (alike.empty()) {
      say(spectral, false, "every band is one interval");
    } else if (forced(spectral) == false) {
      say(spectral, true, "a band has several intervals");  // force() turns it off
    } else {
      say_nothing_lost(spectral, "no optics change within a band: its intervals are solved as one");
    }
  }

  /// The user's word.
  void force() {
    for (const auto& [name, wanted] : scene_.render.effects) {
      const auto at = std::find(effect_names().begin(), effect_names().end(), name);
      if (at == effect_names().end()) continue;
      const auto effect = static_cast<Effect>(at - effect_names().begin());
      PlanRow& here = row(effect);
      const bool present = here.on || here.bound;
      if (!present) {
        if (wanted) result_.warnings.push_back("the effect \"" + name + "\" cannot be forced on: " + here.reason);
        continue;
      }
      if (wanted) {
        here.on = true;
        here.bound.reset();
        here.reason = "forced on: " + (effect == spectral ? std::string("every interval by itself") : here.reason);
        continue;
      }
      if (!here.on) continue;  // nothing of it is left anyway
      switch_off(effect);
    }
    if (forced(absorption) == false && row(emission).on)
      switch_off(emission, "absorption is forced off, and what does not absorb does not emit");
    if (forced(single_scattering) == false && row(multiple_scattering).on)
      switch_off(multiple_scattering, "single scattering is forced off");
    if (forced(masking) == false) {
      for (const Effect effect : {surfaces, specular}) {
        if (row(effect).on) switch_off(effect, "masking is forced off: nothing opaque is left");
      }
    }
    if (forced(surfaces) == false && row(specular).on) switch_off(specular, "surfaces are forced off");
  }

  void switch_off(Effect effect, const std::string& why = "forced off") {
    PlanRow& here = row(effect);
    here.on = false;
    here.reason = why;
    const bool bounded = droppable(effect) && bound_of(effect) < kInfinity;
    here.bound = bounded ? std::optional<double>(bound_of(effect)) : std::nullopt;
    taken_.push_back(effect);
    if (why != "forced off") return;
    result_.warnings.push_back("the effect \"" + here.effect + "\" is forced off: " +
                               (bounded
                                    ? fmt::format("the image may be wrong by up to {:.2g} of its values", *here.bound)
                                    : std::string("how wrong the image is, no bound says")));
  }

  static bool droppable(Effect effect) {
    return effect == emission || effect == single_scattering || effect == multiple_scattering || effect == specular ||
           effect == sun || effect == sky || effect == atmosphere;
  }

  /// Smallest bounds first, while their sum fits.
  void drop() {
    std::vector<Effect> candidates;
    for (int e = 0; e < static_cast<int>(result_.rows.size()); ++e) {
      const auto effect = static_cast<Effect>(e);
      if (!row(effect).on || !droppable(effect) || forced(effect)) continue;
      // A bound on all that clouds scatter is one on what they scatter again.
      if (effect == single_scattering && forced(multiple_scattering) == true) continue;
      candidates.push_back(effect);
    }
    std::stable_sort(candidates.begin(), candidates.end(),
                     [this](Effect a, Effect b) { return bound_of(a) < bound_of(b); });
    double sum = 0;
    bool fits = true;
    for (const Effect effect : candidates) {
      const double bound = bound_of(effect);
      // With probes or rectangles only effects of bound 0 are dropped: bounds speak of the image.
      fits = fits && (only_image_ || bound == 0) && sum + bound <= most_;
      if (!fits) {
        row(effect).reason +=
            bound < 1 ? fmt::format("; its bound is {:.2g}", bound) : std::string("; its share has no useful bound");
        continue;
      }
      sum += bound;
      row(effect).on = false;
      row(effect).bound = bound;
      row(effect).reason =
          bound > 0 ? fmt::format("{}: at most {:.2g} of any pixel", too_little(effect), bound) : too_little(effect);
    }
    if (!row(single_scattering).on && row(multiple_scattering).on && forced(multiple_scattering) != true) {
      say(multiple_scattering, false, "single scattering is off");
    }
  }

  std::string too_little(Effect effect) const {
    switch (effect) {
      case emission:
        return "clouds emit too little to show";
      case single_scattering:
        return "clouds scatter too little to show";
      case multiple_scattering:
        return "too little is scattered again to show";
      case specular:
        return "mirrors reflect too little to show";
      case sun:
        return "too little of it is scattered or reflected to show";
      case sky:
        return "the sky is too dark to show";
      case atmosphere:
        return fmt::format("within {:.4g} m the air changes too little to show", summary_.reach_m);
      default:
        return "";
    }
  }

  void make_cuts() {
    Cuts& cuts = result_.cuts;
    const auto off = [this](Effect effect) { return !row(effect).on; };
    const auto taken = [this](Effect effect) {
      return std::find(taken_.begin(), taken_.end(), effect) != taken_.end();
    };
    cuts.absorption = taken(absorption);
    cuts.emission = off(emission) && any_interval([](const IntervalLimits& limits) { return limits.emits; });
    // A specular_depth of 0 ends camera rays at mirrors; photons still go by them.
    cuts.specular = off(specular) && (row(specular).bound || taken(specular));
    cuts.surfaces = taken(surfaces) || taken(masking);
    cuts.spheres = taken(masking);
    cuts.sun = scene_.sun && (cuts.sun || off(sun));
    cuts.moon = scene_.moon && (cuts.moon || off(sun));
    cuts.sky = off(sky) && any_interval([](const IntervalLimits& limits) { return limits.sky > 0; });
    cuts.atmosphere =
        off(atmosphere) && any_interval([](const IntervalLimits& limits) { return limits.air_extinction > 0; });
  }

  const Description& scene_;
  const MediaSummary& summary_;
  double most_;
  bool only_image_ = true;
  std::vector<bool> kept_;
  std::vector<IntervalLimits> limits_;
  std::array<double, 12> bounds_{};
  std::vector<std::array<LeftOut, 12>> left_out_;  // of each band
  std::vector<Effect> taken_;                      // by force
  Decisions result_;
};

}  // namespace

bool Decisions::on(const std::string& effect) const {
  return std::any_of(rows.begin(), rows.end(), [&](const PlanRow& row) { return row.effect == effect && row.on; });
}

Decisions decide(const Description& scene, const MediaSummary& summary, double budget) {
  return Decider(scene, summary, budget).run();
}

}  // namespace obscura::detail
