// Referees for every picture: all methods solve one scene, and their numbers are compared within their own errors.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "octree/base/progress.h"
#include "photon/methods/method.h"
#include "scene/file/description.h"
#include "sensor/judge/agreement.h"

namespace obscura {

class Session;

/// A built-in scene on which the methods are known to agree.
struct VerifyCase {
  std::string name;
  std::string about;  ///< one line
  double resolution;  ///< relative difference of the picture's mean that the comparison has to be able to see
  std::string scene;  ///< text of the scene file
};
const std::vector<VerifyCase>& verify_cases();

/// Relative difference of the picture's mean that a comparison has to be able to see to say anything.
inline constexpr double kJudged = 0.1;

struct VerifySettings {
  std::uint64_t seed = 1;
  int passes = 4;             ///< independent repetitions of photon map and path tracer, each with the scene's settings
  double resolution = 0;      ///< see VerifyCase; 0: weaker comparisons than kJudged are not judged, but do not fail
  double false_alarm = 1e-6;  ///< probability that honest methods fail, over all comparisons of all scenes
  int scenes = 1;             ///< among which it is shared
};

/// Two methods beside each other, as numbers among VerifiedScene::methods.
struct VerifyPair {
  std::size_t first, second;
  Agreement agreement;
};

/// One number.
struct VerifyRow {
  std::string quantity;  ///< "mean", "x 0-15 y 0-15", "fluence middle", "flux top forward"
  std::string band;
  double coarser = 1;                             ///< its resolution in units of that of the picture's mean
  std::vector<std::optional<Measured>> measured;  ///< by each method; none where it does not have it
  std::vector<VerifyPair> pairs;
};

/// One method's picture in one band.
struct VerifyPicture {
  std::vector<float> radiance, error, bias;
  PixelView view() const { return {radiance, error, bias}; }
};

struct VerifyPixels {
  std::string band;
  std::size_t first, second;
  PixelAgreement agreement;
};

/// What one method has found out about a scene.
struct VerifyMethod {
  std::string name;     ///< the method's word
  std::string refusal;  ///< why it has found nothing; empty: it has
  double seconds = 0;
  std::string what;  ///< what was run: photons, paths, cells
  std::vector<std::optional<Measured>>
      values;                           ///< in the order of VerifiedScene::rows; none where it does not have one
  std::vector<VerifyPicture> pictures;  ///< per band
};

struct VerifiedScene {
  std::string name;
  std::string about;
  std::array<int, 2> resolution{1, 1};
  std::vector<std::string> bands;
  std::vector<bool> grey;  ///< per band: no unit
  std::vector<VerifyMethod> methods;
  std::vector<VerifyRow> rows;
  std::vector<VerifyPixels> pixels;
  bool demands_resolution = false;
  bool partial = false;  ///< cancelled: nothing was compared

  /// @pre there is one of this word
  const VerifyMethod& method(std::string_view word) const;
  /// One sentence for each comparison that fails and each band of which nothing could be judged, none: all agree.
  std::vector<std::string> failures() const;
  /// Comparisons that were made, and those of them that could see a difference.
  std::size_t comparisons() const;
  std::size_t judged() const;
};

/// The methods that judge each other: one of each word, of those that share one the plan's choice.
std::vector<Method> referees(Session& session);

/// Runs one method. A method that refuses the scene says so in its result; so does one that was cancelled.
VerifyMethod run_method(Session& session, const Method& method, const VerifySettings& settings,
                        const Progress& progress = {});

/// Compares what methods have found about a scene, or about what each of them took for it.
VerifiedScene compare_methods(const Description& scene, std::vector<VerifyMethod> methods,
                              const VerifySettings& settings);

/// Runs all methods. A method that refuses the scene is left out, and says why.
/// @throws InputError, ResourceError as build_world()
VerifiedScene verify_scene(const Description& scene, const VerifySettings& settings, const Progress& progress = {});

/// For people: one line for each number, then one for each picture; for programs.
std::string verify_table(const std::vector<VerifiedScene>& scenes);
std::string verify_json(const std::vector<VerifiedScene>& scenes);
/// A page with pictures side by side and the table; needs no other file. Written under a temporary name and
/// renamed. @throws ResourceError
void write_verify_html(const std::filesystem::path& file, const std::vector<VerifiedScene>& scenes);

}  // namespace obscura
