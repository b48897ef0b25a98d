// Cells far thicker than the layer that light leaves from: an isothermal half space shows what Chandrasekhar's H says,
// by every method, or the method says how wrong it may be.
#include <catch2/catch.hpp>
#include <cmath>
#include <numeric>

#include "scene/file/scene_io.h"
#include "scene/run/run.h"

using namespace obscura;

namespace {

/// Radiance along the normal of a half space of albedo w and source 1: sqrt(1 - w) H(1), with H of isotropic scattering
/// from its integral equation (Chandrasekhar, Radiative Transfer, 1950, sec. 38), by midpoints.
double half_space(double w) {
  constexpr int n = 2000;
  const double root = std::sqrt(1 - w);
  std::vector<double> h(n, 1.0);
  const auto next = [&](double mu) {
    double sum = 0;
    for (int j = 0; j < n; ++j) {
      const double other = (j + 0.5) / n;
      sum += other * h[static_cast<std::size_t>(j)] / (mu + other) / n;
    }
    return 1 / (root + 0.5 * w * sum);
  };
  for (int step = 0; step < 30; ++step) {
    std::vector<double> better;
    for (int i = 0; i < n; ++i) better.push_back(next((i + 0.5) / n));
    h = std::move(better);
  }
  return root * next(1);
}

std::string scene(double albedo, double extinction, const std::string& render) {
  return R"({"obscura": 1, "bands": [{"name": "b"}], "clouds": [{"grid": {"shape": "box", "size_m": [1, 1, 1],
      "voxel_m": 0.25}, "media": [{"extinction": )" +
         std::to_string(extinction) + R"(, "albedo": )" + std::to_string(albedo) +
         R"(}], "source": 1.0, "periodic": ["x", "y"]}],
      "sensor": {"position_m": [0, 0, 5], "look_at_m": [0, 0, 0], "up": [0, 1, 0], "projection": "orthographic",
        "width_m": 1, "resolution": [8, 8], "max_oversampling": 4}, "render": {)" +
         render + "}}";
}

double mean_of(std::span<const float> values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

/// The picture's mean, and what its pixels say on average of their error and bias.
struct Seen {
  double radiance, error, bias;
};
Seen seen(const Image& image) {
  double squares = 0;
  for (const float error : image.channel("b.error")) squares += error * error;
  return {mean_of(image.channel("b.radiance")), std::sqrt(squares / static_cast<double>(image.pixel_count())),
          image.has("b.bias") ? mean_of(image.channel("b.bias")) : 0.0};
}

}  // namespace

TEST_CASE("a half space of thick cells shows what the H function says", "[stability][thick]") {
  CHECK(half_space(0.5) == Approx(0.88477).epsilon(1e-4));
  CHECK(half_space(0.9) == Approx(0.58506).epsilon(1e-4));
  for (const double albedo : {0.3, 0.5, 0.8, 0.9, 0.97}) {
    const double right = half_space(albedo);
    for (const double extinction : {20.0, 100.0, 1e4}) {
      CAPTURE(albedo, extinction, right);
      const auto check = [&](const char* render, double most_error) {
        CAPTURE(render);
        const Seen shown = seen(run_scene(parse_scene(scene(albedo, extinction, render), "."), {}).image);
        CAPTURE(shown.radiance, shown.error, shown.bias);
        // Pixels share photons and cells: the mean is known no better than a pixel.
        CHECK(std::abs(shown.radiance - right) <= 1.96 * std::hypot(shown.error, shown.bias));
        CHECK(std::abs(shown.radiance - right) <= most_error * right);
      };
      check(R"("method": "ordinates")", 0.1);
      if (albedo != 0.5 && albedo != 0.9) continue;
      check(R"("samples": 32)", 0.1);
      // In cells of depth 2500 hardly a photon is in the layer: the map is noise, and says so.
      const double noise = extinction > 1e3 ? 1 : 0.12;
      check(R"("method": "photon", "photons": 200000, "final_gather": 1)", noise);
      check(R"("method": "photon", "photons": 200000, "final_gather": 0)", 2 * noise);
    }
  }
}

TEST_CASE("light that comes into thick cells from outside takes the place of theirs", "[stability][thick]") {
  // In a sky as bright as itself the half space is black: nothing near its face may be taken off.
  for (const char* method : {R"("method": "ordinates")", R"("method": "photon", "photons": 100000)"}) {
    CAPTURE(method);
    std::string text = scene(0.9, 1e3, method);
    text.insert(text.size() - 1, R"(, "environment": {"sky": {"radiance": 1}})");
    const Seen shown = seen(run_scene(parse_scene(text, "."), {}).image);
    CHECK(shown.radiance == Approx(1).margin(2 * std::hypot(shown.error, shown.bias) + 0.01));
    CHECK(shown.radiance == Approx(1).margin(0.1));
  }
}
