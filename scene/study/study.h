// What accuracy costs: for one scene on one machine, the image error of every method over its own knobs against time
// and memory, measured against a reference whose own error is known.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "octree/base/power_law.h"
#include "octree/base/progress.h"
#include "scene/study/study_setting.h"
#include "sensor/judge/picture_error.h"

namespace obscura {

class StudyBench;

/// Errors for which settings are sought.
inline constexpr std::array<double, 5> kStudyTargets{0.1, 0.05, 0.02, 0.01, 0.005};

/// Seconds from any origin; CPU seconds of all threads.
struct StudyClock {
  std::function<double()> wall_s, cpu_s;
  static StudyClock system();
};

struct StudyRun;

struct StudySettings {
  double budget_s = 300;  ///< of wall time
  int pixels = 64;        ///< longest side of the picture
  std::uint64_t seed = 1;
  StudyClock clock = StudyClock::system();
  std::function<void(const std::string&)> tell;  ///< of each run, a line; may be empty
};

/// CPU and wall time of the stages of a picture.
struct StudySeconds {
  struct Stage {
    double cpu = 0, wall = 0;
  };
  Stage world, map, image;

  double cpu() const noexcept { return world.cpu + map.cpu + image.cpu; }
  double wall() const noexcept { return world.wall + map.wall + image.wall; }
};

struct StudyBytes {
  double octree = 0, map = 0, film = 0;
  double total() const noexcept { return octree + map + film; }
};

/// The purpose of a run that is a rung of its method's ladder.
inline constexpr const char* kLadder = "ladder";

/// One setting, measured.
struct StudyRun {
  StudySetting setting;
  std::string purpose;   ///< kLadder, the knob that was varied, "scene", "target"
  int base = -1;         ///< the run that it varies; none: -1
  StudySeconds seconds;  ///< of one picture, the World's and the map's making included
  StudySeconds full;     ///< predicted for the scene's own resolution
  StudyBytes bytes, full_bytes;
  double peak_MiB = 0;            ///< of the process so far
  std::vector<Picture> pictures;  ///< independent of each other
  PictureError error;
};

struct StudyReference {
  std::string method;  ///< "path tracer", "ordinates"
  std::string what;    ///< what was run
  ReferencePicture picture;
  StudySeconds::Stage seconds;  ///< spent on it
  RootError error;              ///< its own image error
};

/// How an error falls with the time that it costs, along a method's ladder.
struct StudySlope {
  const MethodType* method = &kPathTracer;
  std::string what;  ///< "error", "noise", "bias"
  PowerLaw law;      ///< against CPU seconds of map and image
};

/// The cheapest setting that was measured to reach an error with one standard error to spare.
struct StudyTarget {
  double error = 0;
  int run = -1;                 ///< none: -1
  std::vector<int> per_method;  ///< likewise among the runs of each method, by const MethodType*
};

struct Study {
  std::string scene, hash;
  int threads = 1;
  std::array<int, 2> resolution{1, 1}, full_resolution{1, 1};
  std::vector<std::string> bands;
  std::vector<bool> grey;  ///< per band: no unit
  double budget_s = 0, spent_s = 0;
  StudyReference reference;
  std::vector<StudyRun> runs;  ///< in the order in which they were made
  int as_given = -1;           ///< the run with the scene's own settings
  std::vector<std::pair<const MethodType*, std::string>> refusals;
  std::vector<std::string> left_out;  ///< sentences
  std::vector<StudyTarget> targets;
  std::vector<StudySlope> slopes;
  std::vector<int> front;  ///< Pareto front: no other run is both cheaper (full picture) and more accurate
  std::vector<std::string> warnings;
  bool partial = false;  ///< stopped by the user

  double pixel_ratio() const noexcept {
    return static_cast<double>(full_resolution[0]) * full_resolution[1] /
           (static_cast<double>(resolution[0]) * resolution[1]);
  }
};

/// Measures until the budget is spent or nothing is left that is worth its time.
/// @throws InputError, ResourceError as build_world(); NumericalError where no referee serves the scene
Study run_study(const Description& scene, const StudySettings& settings, const Progress& progress = {});

/// The same with another bench (tests: one that only pretends to compute).
Study run_study(StudyBench& bench, const StudySettings& settings, const Progress& progress = {});

/// What follows from the runs: errors against the reference, targets, slopes, the front.
void evaluate(Study& study);

/// A setting in a few words: "path tracer, 64 samples".
std::string study_label(const StudySetting& setting);
/// The study for people on a terminal; the settings to use, as a table in Markdown; all runs for spreadsheets and for
/// programs, which tell each run's setting as JSON pointers and values.
std::string study_table(const Study& study);
std::string study_markdown(const Study& study);
std::string study_csv(const Study& study);
std::string study_json(const Study& study);
/// Error against the CPU time of the whole picture, as an SVG file of its own.
std::string study_svg(const Study& study);
/// A page that needs no other file. Written under a temporary name and renamed. @throws ResourceError
void write_study_html(const std::filesystem::path& file, const Study& study);

}  // namespace obscura
