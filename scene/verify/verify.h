// Two referees for every picture: the photon map, the path tracer and discrete ordinates solve one scene, and
// their numbers are compared within their own errors.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "octree/base/progress.h"
#include "scene/file/description.h"
#include "sensor/judge/agreement.h"

namespace obscura {

class Session;

enum class Referee { photon, path, ordinates };
inline constexpr std::array<Referee, 3> kReferees{Referee::photon, Referee::path, Referee::ordinates};
/// "photon", "path", "ordinates"
const char* name_of(Referee method) noexcept;

/// A named scene whose verdict the program vouches for.
struct VerifyCase {
  std::string name;
  std::string about;  ///< one line
  double resolution;  ///< relative difference of the picture's mean that the comparison has to be able to see
  std::string scene;  ///< text of the scene file
};
const std::vector<VerifyCase>& verify_cases();

struct VerifySettings {
  std::uint64_t seed = 1;
  int passes = 4;             ///< independent repetitions of photon map and path tracer, each with the scene's settings
  double resolution = 0;      ///< see VerifyCase; 0: any will do
  double false_alarm = 1e-6;  ///< probability that honest methods fail, over all comparisons of all scenes
  int scenes = 1;             ///< among which it is shared
};

/// What one method found, by Referee.
template <class T>
using ByReferee = std::array<T, kReferees.size()>;

/// Two methods beside each other.
struct VerifyPair {
  Referee first, second;
  Agreement agreement;
};

/// One number.
struct VerifyRow {
  std::string quantity;  ///< "mean", "x 0-15 y 0-15", "fluence middle", "flux top forward"
  std::string band;
  double coarser = 1;                           ///< its resolution in units of that of the picture's mean
  ByReferee<std::optional<Measured>> measured;  ///< none where a method does not have it
  std::vector<VerifyPair> pairs;
};

/// One method's picture in one band.
struct VerifyPicture {
  std::vector<float> radiance, error, bias;
  PixelView view() const { return {radiance, error, bias}; }
};

struct VerifyPixels {
  std::string band;
  Referee first, second;
  PixelAgreement agreement;
};

/// What one method has found out about a scene.
struct VerifyMethod {
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
  ByReferee<VerifyMethod> methods;
  std::vector<VerifyRow> rows;
  std::vector<VerifyPixels> pixels;
  bool demands_resolution = false;
  bool partial = false;  ///< cancelled: nothing was compared

  const VerifyMethod& method(Referee which) const { return methods[static_cast<std::size_t>(which)]; }
  /// One sentence for each comparison that fails, none: all agree.
  std::vector<std::string> failures() const;
  /// Comparisons that were made.
  std::size_t comparisons() const;
};

/// Runs one method. A method that refuses the scene says so in its result; so does one that was cancelled.
VerifyMethod run_method(Session& session, Referee method, const VerifySettings& settings,
                        const Progress& progress = {});

/// Compares what methods have found about a scene, or about what each of them took for it.
VerifiedScene compare_methods(const Description& scene, ByReferee<VerifyMethod> methods,
                              const VerifySettings& settings);

/// Runs all methods. A method that refuses the scene is left out, and says why.
/// @throws InputError, ResourceError as build_world()
VerifiedScene verify_scene(const Description& scene, const VerifySettings& settings, const Progress& progress = {});

/// Makes a user's scene fit for all methods: its picture becomes at most `pixels` wide and high, with the same
/// view and the same settings per pixel.
void shrink_picture(Description& scene, int pixels);

/// For people: one line for each number, then one for each picture; for programs.
std::string verify_table(const std::vector<VerifiedScene>& scenes);
std::string verify_json(const std::vector<VerifiedScene>& scenes);
/// A page with pictures side by side and the table; needs no other file. Written under a temporary name and
/// renamed. @throws ResourceError
void write_verify_html(const std::filesystem::path& file, const std::vector<VerifiedScene>& scenes);

}  // namespace obscura
