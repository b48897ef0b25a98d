// One way to an image: a method with its settings, and what it costs and errs as a function of them. The models
// behind them are in scene/METHODS.md, "Target error and time limit".
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "scene/file/description.h"

namespace obscura {

class Session;

/// How the rays of a pixel are placed.
enum class RayStyle {
  wish,     ///< as the scene's sensor wants it
  uniform,  ///< four in every pixel: where light is noisy, rays that decide cost more than they give
  fine      ///< four times as many as the scene wants, at half its thresholds
};

struct Recipe {
  MethodKind method = MethodKind::path;
  bool gather = false;        ///< of method photon
  std::uint64_t photons = 0;  ///< of a pass, per band
  int samples = 1;            ///< of a pass, per pixel
  RayStyle rays = RayStyle::wish;

  /// "photon with final gather, 200000 photons, 32 samples"
  std::string text() const;
  /// "photon", "photon with final gather", "path"
  const char* name() const noexcept;
};

/// Seconds and squared image error of a pass over the whole picture with `samples` samples:
///
///     seconds = fixed_s + sample_s * samples,   square = floor + noise / samples (+ bias once, whatever is averaged)
struct RecipeModel {
  double map_s = 0;    ///< of fixed_s, in proportion to the photons
  double fixed_s = 0;  ///< map, rays and what decides about them
  double sample_s = 0;
  double floor = 0;  ///< of rays and photon map: falls with more passes, not with more samples
  double noise = 0;
  double bias = 0;  ///< squared
  int least_samples = 1;
  int least_passes = 2;  ///< fewest that know their own error, bias included

  double pass_s(int samples) const noexcept { return fixed_s + sample_s * samples; }
  double pass_square(int samples) const noexcept { return floor + noise / samples; }
};

/// How often to repeat a pass of how many samples.
struct PassPlan {
  int samples = 1;
  int passes = 1;
  double seconds = 0;  ///< of all
  double error = 0;    ///< expected image error
};

/// Rays of a uniform pixel: fewer could not tell their own error (sensor/capture/film.h). Each has a sample at least.
inline constexpr int kUniformRays = 4;

/// An image's samples are divided into at least so many passes: if the error is still too large, one more pass is
/// needed, not all again.
inline constexpr int kFewestPasses = 2;
/// Passes that know their own error: a photon map's bias is told by two maps.
inline int least_passes(const Recipe& recipe) {
  return recipe.method == MethodKind::photon && recipe.photons > 0 ? 2 : 1;
}

/// The cheapest plan for an image error; none where the bias alone exceeds it.
std::optional<PassPlan> plan_for_error(const RecipeModel& model, double image_error);
/// The most accurate plan for a time; at least one pass of one sample, however long it takes.
PassPlan plan_for_time(const RecipeModel& model, double seconds);

/// Makes the session's next images by this recipe.
/// @param wish the scene's own settings; photons of a batch and so on stay as they are there
void apply(const Recipe& recipe, const Description& wish, std::uint64_t seed, Session& session);

}  // namespace obscura
