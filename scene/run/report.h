// What a run tells about itself: the JSON report beside the image.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "scene/plan/plan_row.h"

namespace obscura {

/// The method that ran and the one that the plan would take.
struct MethodReport {
  std::string used;
  std::string cheaper;
  std::string reason;
};

/// Photon weight of one band, W. Emitted is the sum of the other four.
struct EnergyReport {
  double emitted_W = 0;
  double absorbed_W = 0;   ///< by clouds
  double surface_W = 0;    ///< by surfaces, both sides
  double escaped_W = 0;    ///< with sun and sky photons that meet nothing
  double truncated_W = 0;  ///< cut off by a depth limit
  /// Standard errors of these, in their order, from the scatter of the batches.
  std::array<double, 5> errors_W{};
};

struct PhotonReport {
  std::uint64_t emitted = 0;
  std::uint64_t stored = 0;
  std::uint64_t bytes = 0;
};

/// What walks through coarse cells of the clouds have saved.
struct FootprintReport {
  std::uint64_t rays = 0;          ///< that were walked so, per spectral interval
  std::uint64_t segments = 0;      ///< that they went by
  std::uint64_t coarse_cells = 0;  ///< among these
  double voxels = 0;               ///< on the rays inside coarse cells, by estimate: segments, had leaves been voxels
  double error_bound = 0;          ///< largest of any ray: of transmission, and of radiance over the largest source
};

struct OctreeReport {
  std::string name;
  std::uint64_t leaves = 0;
  std::uint64_t bytes = 0;
  std::uint64_t bytes_dense = 0;
  double tolerance = 0;
  double error_measured = 0;
  double error_bound = 0;
};

struct FluenceReport {
  double fluence = 0;
  double error = 0;
};
struct ProbeReport {
  std::string name;
  std::vector<std::pair<std::string, FluenceReport>> bands;
};

/// Power through a rectangle along its normal and against it.
struct CrossingReport {
  double forward = 0;
  double backward = 0;
  double error = 0;
};
struct FluxReport {
  std::string name;
  std::vector<std::pair<std::string, CrossingReport>> bands;
};

/// A way to the image that was tried on a part of it.
struct TrialReport {
  std::string settings;
  double seconds = 0;
  double predicted_s = 0;      ///< of the whole image; 0: the target is out of its reach
  double predicted_error = 0;  ///< image error then
};

/// Of an image with a target error or a time limit.
struct AccuracyReport {
  std::optional<double> target_error = std::nullopt, time_limit_s = std::nullopt;
  std::string unit;                         ///< of all errors: "fraction" or "K"
  double error = 0;                         ///< estimated error of the image
  std::array<double, 2> interval{0, 0};     ///< its 95 % interval
  double noise = 0, bias = 0, dropped = 0;  ///< parts of it; dropped: bound of what the plan has left out
  bool reached = false;                     ///< the interval's upper end is at most the target
  std::string ended;                        ///< "target", "time", "bias", "cancelled"
  std::string method;
  std::uint64_t photons = 0;  ///< of a pass, per band
  int samples = 0;            ///< of a pass, per pixel
  int passes = 0;
  std::vector<TrialReport> trials;
};

/// Pixels of a band that do not respond, and those cut at the ends of the detector's range.
struct DetectorReport {
  std::uint64_t dead = 0;
  std::uint64_t above_range = 0;
  std::uint64_t below_range = 0;
};

/// Lists keep their order; pairs are (name, value).
struct Report {
  std::string version, scene, hash;
  std::uint64_t seed = 0;
  std::vector<PlanRow> plan;
  BudgetReport budget;
  MethodReport method;
  std::vector<std::pair<std::string, EnergyReport>> energy;  ///< per band
  PhotonReport photons;
  std::vector<OctreeReport> octree;
  FootprintReport footprint;
  std::optional<AccuracyReport> accuracy = std::nullopt;  ///< where a target or a time was given
  double peak_MiB = 0;
  std::vector<std::pair<std::string, double>> time_s;            ///< per stage
  std::vector<std::pair<std::string, std::uint64_t>> rays;       ///< per criterion
  std::vector<std::pair<std::string, std::uint64_t>> work;       ///< how often the code of each effect ran
  std::vector<std::pair<std::string, std::uint64_t>> anomalies;  ///< per kind, none where empty
  std::vector<ProbeReport> probes;
  std::vector<FluxReport> flux;
  std::vector<std::pair<std::string, DetectorReport>> detector;  ///< per band; empty: there is none
  std::vector<std::string> warnings;
  bool partial = false;
};

/// JSON as scene/FORMAT.md, "Report", says, numbers in full precision; what is not finite is null.
std::string to_json(const Report& report);

/// {"plan": [...]}
std::string to_json(const std::vector<PlanRow>& plan);

/// Writes the report under a temporary name and renames it. @throws ResourceError
void write_report(const std::filesystem::path& file, const Report& report);

/// Most memory that this process has held at once, MiB; 0 where the system does not tell.
double peak_memory_MiB();

}  // namespace obscura
