#include "scene/goal/pilot.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "octree/base/error.h"
#include "photon/world/spectral_world.h"
#include "sensor/judge/image_error.h"

namespace obscura {
namespace {

/// Share of the tiles that a trial renders, and how many at least and at most.
constexpr int kTileShare = 8, kFewestTiles = 4, kMostTiles = 24;
/// Samples of the two trials that a model is fitted to.
constexpr int kFewSamples = 4, kMoreSamples = 16;
/// Photons of a trial.
constexpr std::uint64_t kTrialPhotons = 100000;
/// Most bytes of a pass's maps.
constexpr double kMapBytes = 2.0 * (1u << 30);
/// What one may take, where none has been traced yet.
constexpr double kPhoton_s = 1e-6;
/// Trials take no longer than this share of what the best way so far is going to take, or this long.
constexpr double kTrialShare = 0.15, kShortTrials_s = 0.02;
/// Least share of a measurement that a fit gives to each of its two terms.
constexpr double kLeastShare = 0.05;

/// Tiles spread over the picture: Roberts' R2 sequence.
std::vector<int> spread_tiles(const Film& film) {
  const int wanted = std::min(film.tile_count(), std::clamp(film.tile_count() / kTileShare, kFewestTiles, kMostTiles));
  const int across = (film.columns() + Film::kTileSide - 1) / Film::kTileSide, down = film.tile_count() / across;
  std::vector<int> tiles;
  for (int k = 0; static_cast<int>(tiles.size()) < wanted; ++k) {
    double whole;
    const double u = std::modf(0.5 + k * 0.7548776662466927, &whole),
                 v = std::modf(0.5 + k * 0.5698402909980532, &whole);
    const int tile = static_cast<int>(v * down) * across + static_cast<int>(u * across);
    if (std::find(tiles.begin(), tiles.end(), tile) == tiles.end()) tiles.push_back(tile);
  }
  return tiles;
}

/// What one trial has shown, for the whole picture.
struct Measurement {
  double map_s = 0, image_s = 0;
  double square = 0;                      // of the image error, of the worst band
  std::vector<std::vector<double>> bias;  // per band, of blocks
};

/// How good a way is: by its seconds where the target is in reach, else by its error in the time that there is; last
/// what does not fit that time.
struct Score {
  enum Reach { target, time, none } reach = none;
  double value = std::numeric_limits<double>::infinity();
  auto operator<=>(const Score&) const = default;
};

class Trials {
 public:
  Trials(Session& session, const AccuracyGoal& goal, const RunClock& clock, const Progress& progress)
      : session_(session), goal_(goal), clock_(clock), progress_(progress), begin_(clock()) {
    const Film film({session.scene().sensor.resolution, 1});
    tiles_ = spread_tiles(film);
    double pixels = 0;
    for (const int tile : tiles_) {
      const auto box = film.tile_box(tile);
      pixels += box[2] * box[3];
    }
    whole_ = static_cast<double>(film.columns()) * film.rows() / pixels;
  }

  Pilot run() {
    best_.most_photons = goal_.most_photons;
    if (!redirects_light(session_.world())) {
      // Photons would bring nothing.
      Recipe recipe{session_.plan().method};
      recipe.method.photons = 0;
      recipe.method.samples = kMostPoints;  // no limit to the rays of a pixel
      for (const RayStyle rays : {RayStyle::as_described, RayStyle::fine, RayStyle::uniform}) {
        recipe.rays = rays;
        try_rays(recipe);
      }
    } else {
      std::vector<const MethodType*> types;
      std::ranges::copy_if(methods(), std::back_inserter(types), [this](const MethodType* t) { return may_try(*t); });
      // The cheapest to try goes first: what it promises bounds what may be spent on the others.
      std::ranges::stable_sort(types, {}, [](const MethodType* t) { return std::pair(t->photons, !t->samples); });
      for (const MethodType* type : types) {
        Recipe recipe{method_of(session_.scene(), *type), RayStyle::uniform};
        recipe.method.photons = type->photons ? std::min(kTrialPhotons, goal_.most_photons) : 0;
        recipe.method.samples = kFewSamples;
        try_samples(recipe);
      }
      if (best_.trials.empty()) refuse();
      try_style(RayStyle::as_described);
      best_.recipe.method.samples = best_.passes.samples;
    }
    if (best_.trials.empty()) refuse();
    return std::move(best_);
  }

 private:
  double time_left() const {
    return goal_.time_limit_s ? *goal_.time_limit_s - clock_() : std::numeric_limits<double>::infinity();
  }
  double target() const { return goal_.target_error ? goal_.target_error->value - goal_.dropped * whole_error_ : 0.0; }

  [[noreturn]] void refuse() const {
    if (refusal_) throw *refusal_;
    throw NumericalError("target_error", "no method that the scene leaves open gets better by more work",
                         "leave \"method\" or the target out");
  }

  /// Methods with a random error, by which more work makes a better image, as far as the scene leaves them open.
  bool may_try(const MethodType& type) const {
    const Description& scene = session_.scene();
    if (!type.photons && !type.samples) return false;
    if (!scene.render.method.empty() && scene.render.method != type.word) return false;
    if (!type.photons) return true;
    if (type.samples && scene.sensor.scattering_depth) return false;
    return !scene.render.final_gather || (*scene.render.final_gather > 0) == type.samples;
  }

  bool affordable(double seconds) const {
    if (best_.trials.empty()) return true;
    const double spent = clock_() - begin_;
    const double whole = best_score_.reach == Score::target ? best_score_.value : time_left();
    return !progress_.cancelled() && spent + seconds <= std::max(kShortTrials_s, kTrialShare * whole);
  }

  Measurement measure(const Recipe& recipe) {
    ++seed_;
    const Progress part = progress_.part("pilot", static_cast<std::uint64_t>(best_.trials.size()), 8);
    const double begin = clock_();
    const Light* light = session_.estimator(recipe.method, seed_, part).light;
    const double lit = clock_();
    if (light && light->bytes > 0) {
      const double photons = kMapBytes * static_cast<double>(light->emitted) / static_cast<double>(light->bytes);
      best_.most_photons = std::min(best_.most_photons, static_cast<std::uint64_t>(photons));
    }
    const Plan& plan = session_.plan();
    SamplerSettings sampling = styled(plan.sampling, recipe.rays);
    sampling.tiles = tiles_;
    const Film film = session_.render(plan.camera, sampling, recipe.method, seed_, part).film;
    Measurement result{lit - begin, (clock_() - lit) * whole_, 0, {}};
    for (int band = 0; band < film.bands(); ++band) {
      std::optional<FilmError> error = error_in_unit(session_, goal_, film, band);
      if (!error) continue;
      result.square = std::max(result.square, error->square);
      result.bias.push_back(std::move(error->bias));
      whole_error_ = std::max(whole_error_, error->whole);
    }
    return result;
  }

  static double bias_of(const Measurement& a, const Measurement& b) {
    double worst = 0;
    for (std::size_t band = 0; band < a.bias.size(); ++band)
      worst = std::max(worst, bias_square({a.bias[band], b.bias[band]}).mean);
    return worst;
  }

  /// Two numbers of samples tell both terms of time and error.
  void try_samples(Recipe recipe) {
    try {
      // What a first trial costs is not known: about as much as the one before, and its photons.
      if (!affordable(first_s_ + kPhoton_s * static_cast<double>(recipe.method.photons))) return;
      const bool sampled = recipe.method.type->samples;
      const double begin = clock_();
      const Measurement few = measure(recipe);
      first_s_ = clock_() - begin;
      if (!sampled) return consider(recipe, fixed(few), first_s_);
      RecipeModel model;
      model.map_s = model.fixed_s = few.map_s;
      model.sample_s = few.image_s / kFewSamples;
      model.noise = few.square * kFewSamples;
      if (recipe.method.type->photons) model.bias = std::max(0.0, bias_of(few, few));
      PassPlan passes;
      const Score score = score_of(model, time_left(), passes);
      const double more_s = first_s_ * kMoreSamples / kFewSamples;
      if (affordable(more_s) && (score.reach != Score::target || more_s < kTrialShare * passes.seconds)) {
        recipe.method.samples = kMoreSamples;
        const Measurement more = measure(recipe);
        const double spread = kMoreSamples - kFewSamples;
        model.map_s = std::min(few.map_s, more.map_s);
        model.bias = 0;
        model.sample_s = std::max((more.image_s - few.image_s) / spread, kLeastShare * more.image_s / kMoreSamples);
        model.fixed_s = model.map_s + std::max(0.0, more.image_s - model.sample_s * kMoreSamples);
        model.noise = std::max((few.square - more.square) * kFewSamples * kMoreSamples / spread,
                               kLeastShare * more.square * kMoreSamples);
        model.floor = std::max(0.0, more.square - model.noise / kMoreSamples);
        if (recipe.method.type->photons) model.bias = std::max(0.0, bias_of(few, more));
      }
      consider(recipe, model, clock_() - begin);
    } catch (const NumericalError& error) {
      refusal_ = error;
    }
  }

  /// Rays alone: nothing else is sampled.
  void try_rays(const Recipe& recipe) {
    if (!affordable(0)) return;
    try {
      const double begin = clock_();
      const Measurement measured = measure(recipe);
      consider(recipe, fixed(measured), clock_() - begin);
    } catch (const NumericalError& error) {
      refusal_ = error;
    }
  }

  static RecipeModel fixed(const Measurement& measured) {
    RecipeModel model;
    model.map_s = measured.map_s;
    model.fixed_s = measured.map_s + measured.image_s;
    model.floor = measured.square;
    model.bias = std::max(0.0, bias_of(measured, measured));
    return model;
  }

  /// The best way so far with other rays: samples cost and bring what they did.
  void try_style(RayStyle style) {
    Recipe recipe = best_.recipe;
    recipe.rays = style;
    recipe.method.photons = std::min(recipe.method.photons, kTrialPhotons);
    recipe.method.samples = std::clamp(best_.passes.samples, kFewSamples, kMoreSamples);
    const RecipeModel& known = best_.model;
    if (!affordable((known.fixed_s - known.map_s + known.sample_s * recipe.method.samples) / whole_)) return;
    const double begin = clock_();
    const Measurement measured = measure(recipe);
    RecipeModel model = known;
    model.fixed_s = known.map_s + std::max(0.0, measured.image_s - known.sample_s * recipe.method.samples);
    model.floor = std::max(0.0, measured.square - known.noise / recipe.method.samples);
    recipe.method.photons = best_.recipe.method.photons;
    consider(recipe, model, clock_() - begin, false);
  }

  /// Photons are in proportion to time, and the bias falls as the square of the radius does: (k / N)^(2/3).
  void consider(Recipe recipe, const RecipeModel& measured, double seconds, bool vary_photons = true) {
    PilotTrial trial{recipe, seconds, 0, 0};
    Score best_of_trial;
    const double left = time_left();
    const std::uint64_t photons = recipe.method.photons;
    for (double times = 1; times <= 256; times *= 2) {
      if (times > 1 && (!recipe.method.type->photons || !vary_photons ||
                        static_cast<double>(photons) * times > static_cast<double>(best_.most_photons)))
        break;
      RecipeModel model = measured;
      model.least_samples = recipe.rays == RayStyle::uniform ? kUniformRays : 1;
      model.least_passes = least_passes(recipe.method);
      model.map_s *= times;
      model.fixed_s += model.map_s - measured.map_s;
      model.bias *= std::pow(times, -4.0 / 3.0);
      recipe.method.photons = static_cast<std::uint64_t>(static_cast<double>(photons) * times);
      PassPlan passes;
      const Score score = score_of(model, left, passes);
      if (score < best_of_trial) {
        best_of_trial = score;
        trial.recipe = recipe;
        trial.recipe.method.samples = passes.samples;
        trial.predicted_s = score.reach == Score::target ? passes.seconds : 0.0;
        trial.predicted_error = passes.error;
      }
      if (score < best_score_ || (best_.trials.empty() && times == 1)) {
        best_score_ = score;
        best_.recipe = recipe;
        best_.passes = passes;
        best_.model = model;
      }
    }
    best_.trials.push_back(trial);
  }

  Score score_of(const RecipeModel& model, double left, PassPlan& passes) const {
    if (goal_.target_error) {
      if (const auto plan = plan_for_error(model, target()); plan && plan->seconds <= left) {
        passes = *plan;
        return {Score::target, plan->seconds};
      }
    }
    if (goal_.time_limit_s) {
      passes = plan_for_time(model, std::max(0.0, left));
      // The photons of a pass too are to be repeated, lest a pass that takes longer than foreseen takes all.
      const bool fits = kFewestPasses * model.pass_s(passes.samples) <= left;
      return {fits ? Score::time : Score::none, fits ? passes.error : passes.seconds};
    }
    // The target is beyond this way: what its bias leaves, with as much noise.
    const auto plan = plan_for_error(model, std::sqrt(2 * model.bias));
    if (plan) passes = *plan;
    return {Score::time, std::sqrt(2 * model.bias)};
  }

  Session& session_;
  const AccuracyGoal& goal_;
  const RunClock& clock_;
  const Progress& progress_;
  double begin_;
  double first_s_ = 0;  // of the latest first trial
  std::vector<int> tiles_;
  double whole_ = 1;        // pixels of the picture for each of a trial
  double whole_error_ = 0;  // largest FilmError::whole of any trial
  std::uint64_t seed_ = std::uint64_t{1} << 40;
  Pilot best_;
  Score best_score_;
  std::optional<NumericalError> refusal_;
};

}  // namespace

Pilot try_recipes(Session& session, const AccuracyGoal& goal, const RunClock& clock, const Progress& progress) {
  return Trials(session, goal, clock, progress).run();
}

}  // namespace obscura
