// The scenes that the program vouches for: each shape by night (it emits, and scatters half) and by day (sun and
// sky, little is absorbed).
#include <fmt/format.h>

#include "scene/verify/verify.h"

namespace obscura {
namespace {

struct Shape {
  const char* name;
  const char* about;
  /// Clouds, with {0} for what the medium does besides extinction and {1} for what makes it shine.
  std::string clouds;
  /// Position and target of the camera, probes and rectangle for the flux.
  const char* sensor;
  const char* places;
};

const char* const kNightMedium = R"("albedo": 0.5, "phase": {"type": "henyey_greenstein", "g": 0.3})";
const char* const kDayMedium = R"("albedo": 0.9, "phase": {"type": "henyey_greenstein", "g": 0.6})";

const char* const kFiniteView = R"("position_m": [0, -8, 1.5], "look_at_m": [0, 0, 0], "fov_deg": 18)";
const char* const kSlabView = R"("position_m": [0, -8, 6], "look_at_m": [0, 0, 0], "fov_deg": 24)";
const char* const kFinitePlaces =
    R"("probes": [{"name": "middle", "position_m": [0.02, 0.03, 0.05]}, {"name": "edge", "position_m": [0.1, -0.6, 0.1]}],
  "flux": [{"name": "below", "center_m": [0, 0, -1.3], "normal": [0, 0, -1], "size_m": [3, 3]}])";
const char* const kSlabPlaces =
    R"("probes": [{"name": "middle", "position_m": [0.03, 0.02, 0.05]}, {"name": "top", "position_m": [0.1, 0.3, 0.4]}],
  "flux": [{"name": "below", "center_m": [0, 0, -1.3], "normal": [0, 0, -1], "size_m": [1, 1]}])";

std::string cloud(const char* name, const char* grid, const char* extinction, const std::string& rest = "") {
  return fmt::format(R"({{"name": "{}", "grid": {}, "media": [{{"extinction": {}, MEDIUM}}], SHINE{}}})", name, grid,
                     extinction, rest);
}

std::vector<Shape> shapes() {
  const std::string periodic = R"(, "periodic": ["x", "y"], "period_m": [1, 1])";
  const auto placed = [](const char* place, double period) {
    return fmt::format(R"(, "periodic": ["x", "y"], "period_m": [{0}, {0}], "place": {{"translate_m": {1}}})", period,
                       place);
  };
  return {
      {"sphere", "a homogeneous sphere of optical diameter 5 in voxels of a sixth of its radius",
       cloud("sphere", R"({"shape": "sphere", "radius_m": 0.9, "voxel_m": 0.15})", "2.8"), kFiniteView, kFinitePlaces},
      {"cube", "a homogeneous cube of optical depth 6",
       cloud("cube", R"({"shape": "box", "size_m": [1.5, 1.5, 1.5], "voxel_m": 0.125})", "4"), kFiniteView,
       kFinitePlaces},
      {"slab", "a homogeneous layer without end, of optical depth 3",
       cloud("layer", R"({"shape": "box", "size_m": [1, 1, 1], "voxel_m": 0.125})", "3", periodic), kSlabView,
       kSlabPlaces},
      {"two_layer", "a thin layer on a thick one, without end: optical depths 0.5 and 5",
       cloud("thin", R"({"shape": "box", "size_m": [1, 1, 0.5], "voxel_m": 0.125})", "1", placed("[0, 0, 0.25]", 1)) +
           ",\n    " +
           cloud("thick", R"({"shape": "box", "size_m": [1, 1, 0.5], "voxel_m": 0.125})", "10",
                 placed("[0, 0, -0.25]", 1)),
       kSlabView, kSlabPlaces},
      {"checkerboard", "cubes of optical depth 4 and voids of the same size in turn, without end",
       cloud("white", R"({"shape": "box", "size_m": [1, 1, 1], "voxel_m": 0.25})", "4", placed("[0.5, 0.5, 0]", 2)) +
           ",\n    " +
           cloud("black", R"({"shape": "box", "size_m": [1, 1, 1], "voxel_m": 0.25})", "4",
                 placed("[-0.5, -0.5, 0]", 2)),
       kSlabView,
       R"("probes": [{"name": "cube", "position_m": [0.53, 0.52, 0.05]}, {"name": "void", "position_m": [0.47, -0.52, 0.05]}],
  "flux": [{"name": "below", "center_m": [0, 0, -1.3], "normal": [0, 0, -1], "size_m": [2, 2]}])"},
      {"gaussian", "a cloud whose density falls off as a bell, optical depth 5 through its middle",
       cloud("bell", R"({"shape": "gaussian", "sigma_m": 0.4, "size_m": [1.8, 1.8, 1.8], "voxel_m": 0.15})", "5"),
       kFiniteView, kFinitePlaces},
      {"puffs", "young smoke of two sources, torn by turbulence, with its own temperatures",
       R"({"name": "smoke", "puffs": {"sources": [{"position_m": [-1.5, 0, 0.2], "mass_g": 40, "burn_s": 6, "K": 420},
      {"position_m": [0, 0.8, 0.2], "mass_g": 40, "burn_s": 6, "K": 380}],
      "wind_m_s": [0.5, 0.1, 0], "turbulence": 0.4, "age_s": 5, "voxel_m": 0.5, "seed": 5},
      "media": [{"extinction": 0.6, MEDIUM}], PUFFSHINE})",
       R"("position_m": [0, -16, 3], "look_at_m": [0, 0.5, 1.6], "fov_deg": 22)",
       R"("probes": [{"name": "inside", "position_m": [0.5, 0.6, 1.5]}, {"name": "beside", "position_m": [0.1, -2, 1]}],
  "flux": [{"name": "above", "center_m": [0, 0.5, 8], "normal": [0, 0, 1], "size_m": [6, 6]}])"},
  };
}

std::string replaced(std::string text, const std::string& word, const std::string& by) {
  for (std::size_t at = text.find(word); at != std::string::npos; at = text.find(word, at + by.size())) {
    text.replace(at, word.size(), by);
  }
  return text;
}

VerifyCase make_case(const Shape& shape, bool day) {
  std::string clouds = replaced(shape.clouds, "MEDIUM", day ? kDayMedium : kNightMedium);
  clouds = replaced(clouds, ", PUFFSHINE", day ? "" : R"(, "temperature": {"grid": "temperature"})");
  clouds = replaced(clouds, ", SHINE", day ? "" : R"(, "temperature": {"K": 300})");
  const char* const band = day ? R"({"name": "vis"})" : R"({"name": "lwir", "um": [8, 12]})";
  const char* const light =
      day ? R"("sky": {"radiance": 0.1}, "sun": {"zenith_deg": 40, "azimuth_deg": 150, "irradiance": 1})"
          : R"("sky": {"K": 260})";
  VerifyCase result;
  result.name = fmt::format("{}_{}", shape.name, day ? "day" : "night");
  result.about =
      fmt::format("{}; {}", shape.about, day ? "albedo 0.9, g 0.6, in sun and sky" : "albedo 0.5, g 0.3, it emits");
  result.resolution = 0.03;
  result.scene = fmt::format(R"({{
  // {}: {}.
  "obscura": 1,
  "name": "{}",
  "bands": [{}],
  "clouds": [
    {}],
  "environment": {{{}}},
  "sensor": {{{}, "resolution": [32, 32], "max_oversampling": 16}},
  {},
  "render": {{"photons": 250000, "samples": 64, "octree_tolerance": 0}}
}}
)",
                             result.name, result.about, result.name, band, clouds, light, shape.sensor, shape.places);
  return result;
}

}  // namespace

const std::vector<VerifyCase>& verify_cases() {
  static const std::vector<VerifyCase> cases = [] {
    std::vector<VerifyCase> all;
    for (const Shape& shape : shapes()) {
      all.push_back(make_case(shape, false));
      all.push_back(make_case(shape, true));
    }
    return all;
  }();
  return cases;
}

}  // namespace obscura
