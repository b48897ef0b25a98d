// Scenes and ways to render them, and how the errors that images state compare with how far they are off: for the table
// of sensor/MEASURED.md, "Coverage", and the test that holds it.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <string>
#include <vector>

#include "octree/base/statistics.h"
#include "scene/file/scene_io.h"
#include "scene/session/session.h"

namespace obscura::test::coverage {

/// A way to render, as edits of the scene.
struct Way {
  std::string name;
  std::vector<SceneEdit> edits;
  int dear = 1;  ///< seeds are fewer by this factor
};

struct Case {
  std::string name;
  std::string scene;
  std::vector<Way> ways;
  int reference_samples = 1024;  ///< of each pass of the reference
};

inline constexpr int kReferencePasses = 12;

inline SceneEdit set(const std::string& key, const std::string& value) { return {key, value}; }

inline const SceneEdit kByPath = set("/render/method", "path"), kByPhoton = set("/render/method", "photon"),
                       kUniform = set("/sensor/antialiasing", R"({"polygons": 0})");

inline SceneEdit samples(int n) { return set("/render/samples", std::to_string(n)); }
inline SceneEdit rays(int n) { return set("/sensor/max_oversampling", std::to_string(n)); }
inline SceneEdit photons(int n) { return set("/render/photons", std::to_string(n)); }
inline SceneEdit gather(int n) { return set("/render/final_gather", std::to_string(n)); }

inline std::vector<Way> all_ways() {
  return {{"path", {kByPath, samples(16)}},
          {"path, uniform", {kByPath, samples(16), kUniform, rays(4)}},
          {"path, one ray", {kByPath, samples(16), rays(1)}},
          {"gather", {kByPhoton, gather(1), photons(20000), samples(16)}, 2},
          {"map", {kByPhoton, gather(0), photons(20000)}, 2},
          {"path, 3 %", {kByPath, set("/render/target_error", "0.03")}, 5}};
}

inline std::vector<Way> ray_ways() {
  return {{"path", {kByPath}}, {"path, uniform", {kByPath, kUniform, rays(4)}}, {"path, one ray", {kByPath, rays(1)}}};
}

inline const std::string kPuffs = R"("puffs": {"sources": [{"position_m": [0, 0, 0], "mass_g": 400, "burn_s": 6}],
  "wind_m_s": [0.6, 0, 0.3], "age_s": 8, "voxel_m": 0.4, "turbulence": 0.6})";
inline const std::string kSensor = R"("sensor": {"position_m": [3, -30, 6], "look_at_m": [2.5, 0, 2.5], "fov_deg": 24,
  "resolution": [32, 24]})";

inline std::vector<Case> cases() {
  return {
      {"sunlit cloud",
       R"({"obscura": 1, "bands": [{"name": "b"}],
          "clouds": [{)" +
           kPuffs + R"(, "media": [{"extinction": 0.6, "albedo": 0.9,
            "phase": {"type": "henyey_greenstein", "g": 0.6}}]}],
          "environment": {"sky": {"radiance": 0.1}, "sun": {"zenith_deg": 40, "azimuth_deg": 120, "irradiance": 5}},)" +
           kSensor + "}",
       all_ways()},
      {"sunlit cloud over ground",
       R"({"obscura": 1, "bands": [{"name": "b"}],
          "clouds": [{)" +
           kPuffs + R"(, "media": [{"extinction": 0.6, "albedo": 0.9,
            "phase": {"type": "henyey_greenstein", "g": 0.6}}]}],
          "materials": {"soil": {"emissivity": 0.6}},
          "objects": [{"shape": "plane", "size_m": [300, 300], "material": "soil", "radiance": 0,
            "place": {"translate_m": [0, 0, -2]}}],
          "environment": {"sky": {"radiance": 0.1}, "sun": {"zenith_deg": 40, "azimuth_deg": 120, "irradiance": 5}},)" +
           kSensor + "}",
       all_ways()},
      {"thermal puffs",
       R"({"obscura": 1, "bands": [{"name": "b", "um": [8, 12]}],
          "clouds": [{)" +
           kPuffs + R"(, "media": [{"extinction": 0.3, "albedo": 0.3}]}],
          "environment": {"sky": {"K": 250}},)" +
           kSensor + "}",
       all_ways()},
      {"smooth cloud", R"({"obscura": 1, "bands": [{"name": "b"}],
          "clouds": [{"grid": {"shape": "gaussian", "sigma_m": 2, "size_m": [14, 14, 14], "voxel_m": 0.5},
            "media": [{"extinction": 0.6, "albedo": 0.9}]}],
          "environment": {"sky": {"radiance": 0.1}, "sun": {"zenith_deg": 40, "azimuth_deg": 120, "irradiance": 5}},
          "sensor": {"position_m": [0, -30, 0], "look_at_m": [0, 0, 0], "fov_deg": 24, "resolution": [32, 24]}})",
       all_ways()},
      {"sphere over a hot plane",
       R"({"obscura": 1, "bands": [{"name": "b", "um": [8, 12]}],
          "materials": {"soil": {"emissivity": 0.7}, "paint": {"emissivity": 0.4}},
          "objects": [{"shape": "plane", "size_m": [100, 100], "material": "soil", "K": 330},
            {"shape": "sphere", "radius_m": 2, "material": "paint", "K": 290, "place": {"translate_m": [0, 0, 2.5]}}],
          "environment": {"sky": {"K": 230}},
          "sensor": {"position_m": [0, -30, 8], "look_at_m": [0, 0, 1], "fov_deg": 16, "resolution": [32, 24]}})",
       {{"path", {kByPath, samples(16)}},
        {"path, uniform", {kByPath, samples(16), kUniform, rays(4)}},
        {"path, one ray", {kByPath, samples(16), rays(1)}},
        {"gather", {kByPhoton, gather(1), photons(20000), samples(16)}, 2},
        {"map", {kByPhoton, gather(0), photons(20000)}, 2},
        {"path, 3 %", {kByPath, set("/render/target_error", "0.003")}, 5}}},
      {"net", R"({"obscura": 1, "bands": [{"name": "b"}],
          "clouds": [{"grid": {"shape": "box", "size_m": [2, 2, 2], "voxel_m": 0.5}, "media": [{"extinction": 0.5}],
            "source": 1.0}],
          "materials": {"net": {"emissivity": 0.5, "permeable": 0.6}},
          "objects": [{"shape": "plane", "size_m": [1.2, 1.2], "material": "net", "radiance": 2.0, "double_sided": true,
            "place": {"translate_m": [0, -2, 0], "rotate_deg": [90, 0, 0]}}],
          "environment": {"sky": {"radiance": 0.4}},
          "sensor": {"position_m": [0, -10, 0], "look_at_m": [0, 0, 0], "projection": "orthographic", "width_m": 1.6,
            "resolution": [24, 24]}})",
       ray_ways()},
      {"rough mirror", R"({"obscura": 1, "bands": [{"name": "b"}],
          "materials": {"mirror": {"emissivity": 0.2, "specular": 0.8, "roughness": 0.2}},
          "objects": [{"shape": "plane", "size_m": [6, 6], "material": "mirror", "radiance": 0.5},
            {"shape": "box", "size_m": [1, 1, 2], "radiance": 2, "place": {"translate_m": [0, 1, 1]}}],
          "environment": {"sky": {"radiance": 0.2}, "sun": {"zenith_deg": 60, "azimuth_deg": 0, "irradiance": 1}},
          "sensor": {"position_m": [0, -20, 8], "look_at_m": [0, 0, 0], "fov_deg": 16, "resolution": [32, 24]}})",
       ray_ways()},
      {"edges", R"({"obscura": 1, "bands": [{"name": "b"}],
          "objects": [{"shape": "box", "size_m": [1, 1, 1], "radiance": 1, "place": {"rotate_deg": [0, 27, 0]}}],
          "clouds": [{"grid": {"shape": "sphere", "radius_m": 0.8, "voxel_m": 0.05}, "media": [{"extinction": 2}],
            "source": 0.3, "place": {"translate_m": [-0.7, -1.5, 0.4]}}],
          "sensor": {"position_m": [0, -10, 0], "look_at_m": [0, 0, 0], "projection": "orthographic", "width_m": 4,
            "resolution": [32, 32]}})",
       ray_ways()},
  };
}

/// What the pixels should be, each with its standard error.
struct Truth {
  struct Value {
    double mean = 0, error = 0;
  };
  std::vector<Value> pixels;
  Value mean;
};

/// @param folder where references are kept from run to run; empty: nowhere
inline Truth reference_of(const Case& c, const std::string& folder, int passes = kReferencePasses) {
  Truth truth;
  const std::string path = folder + "/" + c.name;
  if (std::ifstream file(path); !folder.empty() && file >> truth.mean.mean >> truth.mean.error) {
    for (Truth::Value value; file >> value.mean >> value.error;) truth.pixels.push_back(value);
    return truth;
  }
  Session session(parse_scene(c.scene, ".", {kByPath, kUniform, samples(c.reference_samples), rays(256)}), 0);
  std::vector<Moments> pixels;
  Moments mean;
  for (int pass = 0; pass < passes; ++pass) {
    const Rendered made = session.render(session.plan().camera, session.plan().sampling, session.plan().method,
                                         static_cast<std::uint64_t>(900001 + pass));
    const auto radiance = made.film.values(0, Film::Value::radiance);
    pixels.resize(radiance.size());
    for (std::size_t p = 0; p < radiance.size(); ++p) pixels[p].add(radiance[p]);
    mean.add(made.film.mean(0).mean);
  }
  const auto value = [](const Moments& m) { return Truth::Value{m.mean(), m.standard_error()}; };
  truth.mean = value(mean);
  for (const Moments& pixel : pixels) truth.pixels.push_back(value(pixel));
  if (!folder.empty()) {
    std::ofstream file(path);
    file << fmt::format("{} {}\n", truth.mean.mean, truth.mean.error);
    for (const Truth::Value& v : truth.pixels) file << fmt::format("{} {}\n", v.mean, v.error);
  }
  return truth;
}

/// How the claims of many images compare with their deviations from the truth.
class Coverage {
 public:
  explicit Coverage(const Truth& truth) : truth_(truth), inside_(truth.pixels.size()), own_(truth.pixels.size()) {}

  void add(const Film& film) {
    ++images_;
    const auto radiance = film.values(0, Film::Value::radiance), error = film.values(0, Film::Value::error),
               bias = film.values(0, Film::Value::bias);
    for (std::size_t p = 0; p < inside_.size(); ++p) {
      const double right = truth_.pixels[p].mean, slack = truth_.pixels[p].error;
      const double off = radiance[p] - right, claim = std::hypot(double{error[p]}, double{bias[p]});
      own_[p].add(radiance[p]);
      claimed_ += claim * claim;
      deviated_ += off * off - slack * slack;
      const bool hit = std::abs(off) <= 1.96 * std::hypot(claim, slack) + 1e-6 * std::abs(right);
      inside_[p] += hit;
    }
    const ImageMean mean = film.mean(0);
    double bias_sum = 0;
    for (const float b : bias) bias_sum += b;
    bias_sum /= static_cast<double>(bias.size());
    const double z = (mean.mean - truth_.mean.mean) / std::hypot(mean.standard_error, bias_sum, truth_.mean.error);
    if (std::isfinite(z)) mean_z_.add(z);
  }

  struct Result {
    double inside = 0;                   ///< share of pixels within 95 % intervals
    double low = 0;                      ///< share of pixels that fewer than 80 % of the images hold
    double claimed_over_true = 0;        ///< roots of mean squares
    double mean_z = 0, deviation_z = 0;  ///< of the image mean in its error
  };
  Result result() const {
    Result r;
    double pixels = 0;
    for (std::size_t p = 0; p < inside_.size(); ++p) {
      // Where nothing is random nothing can be wrong: such pixels would flatter.
      if (own_[p].variance() <= 1e-12 * own_[p].mean() * own_[p].mean() && inside_[p] == images_) continue;
      const double share = static_cast<double>(inside_[p]) / images_;
      r.inside += share;
      r.low += share < 0.8;
      ++pixels;
    }
    r.inside /= pixels;
    r.low /= pixels;
    r.claimed_over_true = std::sqrt(claimed_ / std::max(deviated_, 1e-300));
    r.mean_z = mean_z_.mean();
    r.deviation_z = std::sqrt(mean_z_.variance());
    return r;
  }

  std::string row() const {
    const Result r = result();
    return fmt::format("{} | {:.1f} % | {:.1f} % | {:.2f} | {:+.2f}, {:.2f}", images_, 100 * r.inside, 100 * r.low,
                       r.claimed_over_true, r.mean_z, r.deviation_z);
  }

 private:
  const Truth& truth_;
  std::vector<int> inside_;
  std::vector<Moments> own_;
  int images_ = 0;
  double claimed_ = 0, deviated_ = 0;
  Moments mean_z_;
};

}  // namespace obscura::test::coverage
