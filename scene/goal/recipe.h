// One way to an image: a method with its settings, and what it costs and errs as a function of them. The models
// behind them are in scene/METHODS.md, "Target error and time limit".
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "photon/methods/method.h"
#include "sensor/capture/sampler.h"

namespace obscura {

/// How the rays of a pixel are placed.
enum class RayStyle {
  as_described,  ///< by the scene's sensor
  uniform,       ///< four in every pixel: where light is noisy, rays that decide cost more than they give
  fine           ///< four times as many as the scene describes, at half its thresholds
};

struct Recipe {
  Method method;  ///< photons and samples are those of a pass
  RayStyle rays = RayStyle::as_described;

  /// "final gather, 200000 photons, 32 samples, finer rays"
  std::string text() const;
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
inline int least_passes(const Method& method) { return method.type->photons && method.photons > 0 ? 2 : 1; }

/// The cheapest plan for an image error; none where the bias alone exceeds it.
std::optional<PassPlan> plan_for_error(const RecipeModel& model, double image_error);
/// The most accurate plan for a time; at least one pass of one sample, however long it takes.
PassPlan plan_for_time(const RecipeModel& model, double seconds);

/// The sensor's sampling in a style.
SamplerSettings styled(SamplerSettings described, RayStyle style);

}  // namespace obscura
