#include "scene/goal/accuracy.h"

#include <algorithm>
#include <cmath>

#include "scene/goal/pilot.h"
#include "sensor/judge/image_error.h"

namespace obscura {
namespace {

/// Of a normal law, two-sided 95 %.
constexpr double kNinetyFive = 1.96;
/// Pixels' errors may be stated too large by this, never mind their scatter (sensor/MEASURED.md, "Coverage").
constexpr double kOverstated = 1.15;
/// A pass may take so much longer than the longest before it.
constexpr double kSlowPass = 1.1;
/// Above this share of the target a bias leaves noise too little room.
constexpr double kMostBias = 0.9;
/// Photons of a pass grow by this where their bias stands in the way.
constexpr std::uint64_t kMorePhotons = 8;

/// What the passes so far know about their mean.
struct Known {
  double noise = 0, bias = 0;  // squares
  double error = 0, low = 0, high = 0;
  double least_bias = 0;  // square, lower end of its interval
  double dropped = 0;
};

Known known_of(Session& session, const AccuracyGoal& goal, const Film& film,
               const std::vector<std::vector<std::vector<double>>>& bias) {
  Known worst;
  for (int band = 0; band < film.bands(); ++band) {
    Known known;
    const std::optional<FilmError> error = error_in_unit(session, goal, film, band);
    if (!error) continue;
    known.noise = error->square;
    known.dropped = goal.dropped * error->whole;
    const double doubt = error->freedom > 0 ? kNinetyFive * std::sqrt(2 / error->freedom) : 0.0;
    double bias_doubt = 0;
    const auto& estimates = bias[static_cast<std::size_t>(band)];
    if (estimates.size() > 1) {
      const BiasSquare square = bias_square(estimates);
      known.bias = std::max(0.0, square.mean);
      bias_doubt = kNinetyFive * square.standard_error;
    }
    known.least_bias = std::max(0.0, known.bias - bias_doubt);
    known.error = known.dropped + std::sqrt(known.noise + known.bias);
    known.low = std::sqrt(known.noise * std::max(0.0, 1 - doubt) + known.least_bias) / kOverstated;
    known.high = known.dropped + std::sqrt(known.noise * (1 + doubt) + known.bias + bias_doubt);
    if (known.high >= worst.high) worst = known;
  }
  return worst;
}

/// Passes over one image by one recipe.
class Passes {
 public:
  Passes(Session& session, const RunClock& clock, Accuracy& accuracy)
      : session_(session), clock_(clock), accuracy_(accuracy) {}

  void begin(const Recipe& recipe) {
    accuracy_.recipe = recipe;
    accuracy_.passes = 0;
    image.reset();
    light = {};
    bias_.assign(session_.world().bands().size(), {});
  }

  void add(const Progress& progress) {
    const double start = clock_();
    const Method& method = accuracy_.recipe.method;
    seed = session_.scene().render.seed + 0x9E3779B97F4A7C15u * ++number_;
    if (const Light* photons = session_.estimator(method, seed, progress).light) light.add_tallies(*photons);
    const double lit = clock_();
    const Plan& plan = session_.plan();
    Rendered pass = session_.render(plan.camera, styled(plan.sampling, accuracy_.recipe.rays), method, seed, progress);
    const double end = clock_();
    accuracy_.photons_s += lit - start;
    accuracy_.image_s += end - lit;
    longest_s = std::max(longest_s, end - start);
    if (method.type->photons && !pass.film.partial()) {
      for (int band = 0; band < pass.film.bands(); ++band)
        if (auto error = error_in_unit(session_, accuracy_.goal, pass.film, band))
          bias_[static_cast<std::size_t>(band)].push_back(std::move(error->bias));
    }
    if (image) {
      image->merge(pass);
    } else {
      image = std::move(pass);
    }
    ++accuracy_.passes;
    known = known_of(session_, accuracy_.goal, image->film, bias_);
  }

  std::optional<Rendered> image;
  Light light;
  std::uint64_t seed = 1;  // of the last
  Known known;
  double longest_s = 0;

 private:
  Session& session_;
  const RunClock& clock_;
  Accuracy& accuracy_;
  std::uint64_t number_ = 0;
  std::vector<std::vector<std::vector<double>>> bias_;  // [band][pass][block]
};

/// Another way where the bias of this one stands above the target; none: there is none.
std::optional<Recipe> less_biased(const Recipe& recipe, bool method_named, const Pilot& pilot) {
  Recipe other = recipe;
  if (recipe.method.photons > 0 && recipe.method.photons * kMorePhotons <= pilot.most_photons) {
    other.method.photons *= kMorePhotons;
    return other;
  }
  if (method_named) return std::nullopt;
  for (const PilotTrial& trial : pilot.trials) {
    if (!trial.recipe.method.type->photons) return trial.recipe;
  }
  return std::nullopt;
}

}  // namespace

std::optional<FilmError> error_in_unit(Session& session, const AccuracyGoal& goal, const Film& film, int band) {
  if (!goal.target_error || goal.target_error->unit == ErrorUnit::fraction) return film_error(film, band);
  const Band& spectral = session.world().bands()[static_cast<std::size_t>(band)];
  if (spectral.grey() || spectral.um_max() <= kThermal_um) return std::nullopt;
  return film_error_K(film, band, spectral);
}

AccurateImage render_to_goal(Session& session, const AccuracyGoal& goal, const RunClock& clock,
                             const Progress& progress) {
  const Description& scene = session.scene();
  AccurateImage result{{Film({scene.sensor.resolution, static_cast<int>(scene.bands.size())}), {}, {}}, {}, 1, {}, {}};
  Accuracy& accuracy = result.accuracy;
  accuracy.goal = goal;
  const double begin = clock();
  const Pilot pilot = try_recipes(session, goal, clock, progress);
  accuracy.trials = pilot.trials;
  accuracy.pilot_s = clock() - begin;

  Passes passes(session, clock, accuracy);
  passes.begin(pilot.recipe);
  while (accuracy.ended.empty()) {
    const auto foreseen = static_cast<std::uint64_t>(std::max(accuracy.passes + 1, pilot.passes.passes));
    passes.add(progress.part("pass " + std::to_string(accuracy.passes + 1), static_cast<std::uint64_t>(accuracy.passes),
                             foreseen));
    const Known& known = passes.known;
    const double target = goal.target_error ? goal.target_error->value : 0.0;
    if (progress.cancelled()) {
      accuracy.ended = "cancelled";
    } else if (accuracy.passes >= least_passes(accuracy.recipe.method) && known.high <= target) {
      accuracy.ended = "target";
    } else if (goal.time_limit_s && clock() + kSlowPass * passes.longest_s > *goal.time_limit_s) {
      accuracy.ended = "time";
    } else if (target > 0 && std::sqrt(known.least_bias) + known.dropped > kMostBias * target) {
      if (const auto other = less_biased(accuracy.recipe, !scene.render.method.empty(), pilot)) {
        passes.begin(*other);
      } else {
        accuracy.ended = "bias";
      }
    }
  }
  accuracy.error = passes.known.error;
  accuracy.low = passes.known.low;
  accuracy.high = passes.known.high;
  accuracy.noise = std::sqrt(passes.known.noise);
  accuracy.bias = std::sqrt(passes.known.bias);
  accuracy.dropped = passes.known.dropped;
  result.rendered = std::move(*passes.image);
  result.light = std::move(passes.light);
  result.method = accuracy.recipe.method;
  result.seed = passes.seed;
  return result;
}

}  // namespace obscura
