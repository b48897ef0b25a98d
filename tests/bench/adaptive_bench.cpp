// Adaptive sampling against uniform sampling on three scenes that are made here: a vehicle at 2 km over terrain,
// mirrors with facets, smoke before a wire fence. What does not reflect like a mirror is black: every ray is exact, and
// the picture alone is sampled. Every row is printed, won or lost; sensor/MEASURED.md says what the columns are.
//
//   adaptive_bench [--columns 128] [--seeds 8] [--passes 3] [--only vehicle|mirrors|fence] [--pictures FOLDER]
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <fstream>
#include <string>

#include "octree/base/statistics.h"
#include "sensor/capture/render.h"
#include "tests/bench/adaptive_scenes.h"
#include "tests/support/rendered.h"

using namespace obscura;
using namespace obscura::bench;

namespace {

/// Rays per pixel of each pass of the reference, and of uniform sampling.
constexpr int kReference = 576;
constexpr int kUniform[] = {1, 4, 9, 16, 36, 64, 144, 256, 576};
constexpr int kMost[] = {16, 64, 256};

/// Of the program, all its threads: others that work on the machine hardly count.
double cpu_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

struct Picture {
  std::vector<double> radiance;
  ImageMean mean;
  double rays = 0;      // per pixel, all
  double deciding = 0;  // per pixel
  double seconds = 0;
  std::vector<float> rays_of, criterion;
  RayCounts counts;
};

Picture draw(const World& world, const Camera& camera, int most, bool adaptive, std::uint64_t seed) {
  SamplerSettings settings;
  settings.max_oversampling = most;
  if (adaptive) settings.adaptive.emplace();
  settings.seed = seed;
  RadianceSettings radiance;
  radiance.seed = seed;
  const double start = cpu_seconds();
  const Rendered image = test::render_pass(world, std::span<const PhotonMaps>{}, camera, settings, radiance);
  Picture picture;
  picture.seconds = cpu_seconds() - start;
  const std::span<const float> values = image.film.values(0, Film::Value::radiance);
  picture.radiance.assign(values.begin(), values.end());
  picture.mean = image.film.mean(0);
  const double pixels = static_cast<double>(picture.radiance.size());
  picture.deciding = static_cast<double>(image.rays.deciding) / pixels;
  picture.rays = static_cast<double>(image.film.rays()) / pixels + picture.deciding;
  picture.rays_of.assign(image.film.ray_count().begin(), image.film.ray_count().end());
  picture.criterion.assign(image.film.criterion().begin(), image.film.criterion().end());
  picture.counts = image.rays;
  return picture;
}

struct Reference {
  std::vector<double> radiance, scale;
  double mean = 0, standard_error = 0, image_error = 0;

  std::vector<double> errors(const std::vector<double>& image) const {
    std::vector<double> all(image.size());
    for (std::size_t p = 0; p < image.size(); ++p) all[p] = (image[p] - radiance[p]) / scale[p];
    return all;
  }
  double error(const std::vector<double>& image) const {
    double sum = 0;
    for (const double e : errors(image)) sum += e * e;
    return std::sqrt(sum / static_cast<double>(image.size()));
  }
};

Reference converge(const World& world, const Camera& camera, int passes) {
  std::vector<Picture> all;
  for (int i = 0; i < passes; ++i)
    all.push_back(draw(world, camera, kReference, false, 1000 + static_cast<std::uint64_t>(i)));
  Reference reference;
  reference.radiance.resize(all[0].radiance.size());
  Moments means;
  double largest = 0;
  for (const Picture& pass : all) means.add(pass.mean.mean);
  for (std::size_t p = 0; p < reference.radiance.size(); ++p) {
    for (const Picture& pass : all) reference.radiance[p] += pass.radiance[p] / passes;
    largest = std::max(largest, std::abs(reference.radiance[p]));
  }
  reference.mean = means.mean();
  reference.standard_error = means.standard_error();
  for (const double value : reference.radiance) reference.scale.push_back(std::max(std::abs(value), 0.05 * largest));
  // Scatter of the passes about their mean: what that mean is off.
  double squares = 0;
  for (const Picture& pass : all) squares += std::pow(reference.error(pass.radiance), 2);
  reference.image_error = std::sqrt(squares / passes / (passes - 1));
  return reference;
}

/// Rays of uniform sampling for an image error, by straight lines between logarithms; the last two go on beyond.
double rays_for(double error, const std::vector<double>& rays, const std::vector<double>& errors) {
  std::size_t i = 0;
  while (i + 2 < errors.size() && errors[i + 1] > error) ++i;
  const double slope = std::log(rays[i + 1] / rays[i]) / std::log(errors[i + 1] / errors[i]);
  return rays[i] * std::pow(error / errors[i], slope);
}

void save(const std::string& path, int columns, const std::vector<double>& values, double low, double high) {
  std::ofstream file(path, std::ios::binary);
  file << "P5\n" << columns << ' ' << values.size() / static_cast<std::size_t>(columns) << "\n255\n";
  for (const double v : values) file.put(static_cast<char>(std::clamp(255 * (v - low) / (high - low), 0.0, 255.0)));
}

void measure(Scene scene, const Options& options) {
  const std::string name = scene.name;
  const Camera camera(scene.camera);
  const World world(std::move(scene.contents));
  const Reference reference = converge(world, camera, options.passes);
  fmt::print(stderr, "{}: mean {:.6f} +- {:.1e}, image error of the reference {:.1e}\n", name, reference.mean,
             reference.standard_error, reference.image_error);
  std::vector<double> rays, errors, seconds;
  for (const int n : kUniform) {
    const Picture picture = draw(world, camera, n, false, 500);
    rays.push_back(n);
    errors.push_back(reference.error(picture.radiance));
    seconds.push_back(picture.seconds);
    fmt::print(stderr, "{}: uniform {}: error {:.2e}, {:.2f} s\n", name, n, errors.back(), picture.seconds);
  }
  const std::string stem = options.pictures + "/" + name.substr(0, name.find(' '));
  const auto [low, high] = std::ranges::minmax(reference.radiance);
  if (!options.pictures.empty()) save(stem + "_reference.pgm", options.columns, reference.radiance, low, high);
  for (const int most : kMost) {
    Moments means, squares, all, deciding, time;
    double worst = 0;
    Picture picture;
    std::vector<double> variance(reference.radiance.size());
    for (int s = 0; s < options.seeds; ++s) {
      picture = draw(world, camera, most, true, 1 + static_cast<std::uint64_t>(s));
      means.add(picture.mean.mean);
      squares.add(std::pow(reference.error(picture.radiance), 2));
      all.add(picture.rays);
      deciding.add(picture.deciding);
      time.add(picture.seconds);
      const double z =
          (picture.mean.mean - reference.mean) / std::hypot(picture.mean.standard_error, reference.standard_error);
      if (std::abs(z) > std::abs(worst)) worst = z;
      const std::vector<double> off = reference.errors(picture.radiance);
      for (std::size_t p = 0; p < off.size(); ++p) variance[p] += off[p] * off[p] / options.seeds;
    }
    const double error = std::sqrt(squares.mean());
    const double z = (means.mean() - reference.mean) / std::hypot(means.standard_error(), reference.standard_error);
    const int equal = static_cast<int>(std::ceil(all.mean()));
    Moments equal_squares, equal_time;
    for (int s = 0; s < 3; ++s) {
      const Picture uniform = draw(world, camera, equal, false, 600 + static_cast<std::uint64_t>(s));
      equal_squares.add(std::pow(reference.error(uniform.radiance), 2));
      equal_time.add(uniform.seconds);
    }
    const double equal_error = std::sqrt(equal_squares.mean());
    const double needed = rays_for(error, rays, errors);
    const double per_ray = seconds.back() / rays.back();
    fmt::print(
        "| {} | {} | {:.2f} | {:.2f} | {:.2e} | {:.2e} | {:.2f} | {:.0f} | {:.1f} | {:.1f} | {:.2f} | {:+.1f} | "
        "{:+.1f} |\n",
        name, most, all.mean(), deciding.mean(), error, equal_error, error / equal_error, needed, needed / all.mean(),
        time.mean() / equal_time.mean(), time.mean() / (needed * per_ray), z, worst);
    std::fflush(stdout);
    // Where the rays went, and where the error is.
    std::vector<double> by_rays(12), pixels(12);
    double split = 0;
    for (std::size_t p = 0; p < variance.size(); ++p) {
      const auto c = static_cast<std::size_t>(picture.criterion[p]);
      by_rays[c] += variance[p];
      pixels[c] += 1;
      split += picture.rays_of[p] > 1;
    }
    for (std::size_t c = 0; c < 12; ++c) {
      if (pixels[c] == 0) continue;
      fmt::print(stderr, "    {}: {:.0f} pixels, {} more rays, {:.1f} % of the squared error\n",
                 obscura::name(static_cast<Criterion>(c)), pixels[c], picture.counts.asked[c],
                 100 * by_rays[c] / (error * error * static_cast<double>(variance.size())));
    }
    if (options.pictures.empty()) continue;
    std::vector<double> root, count(picture.rays_of.begin(), picture.rays_of.end()),
        why(picture.criterion.begin(), picture.criterion.end());
    for (const double v : variance) root.push_back(std::sqrt(v));
    const std::string prefix = fmt::format("{}_{}", stem, most);
    save(prefix + "_error.pgm", options.columns, root, 0, 8 * error);
    save(prefix + "_rays.pgm", options.columns, count, 0, most);
    save(prefix + "_why.pgm", options.columns, why, 0, 11);
  }
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  for (int i = 1; i + 1 < argc; i += 2) {
    const std::string key = argv[i];
    if (key == "--columns") options.columns = std::stoi(argv[i + 1]);
    if (key == "--seeds") options.seeds = std::stoi(argv[i + 1]);
    if (key == "--passes") options.passes = std::stoi(argv[i + 1]);
    if (key == "--only") options.only = argv[i + 1];
    if (key == "--pictures") options.pictures = argv[i + 1];
  }
  const auto wanted = [&](const char* name) { return options.only.empty() || options.only == name; };
  fmt::print(
      "| scene | max_oversampling | rays a pixel | of these deciding | image error | of as many uniform rays | ratio | "
      "uniform rays for equal error | "
      "over adaptive ones | CPU time over that of as many uniform rays | over that of equal error | z of the mean of "
      "all seeds | largest z of one image |\n");
  fmt::print("|---|---|---|---|---|---|---|---|---|---|---|---|---|\n");
  if (wanted("vehicle")) measure(vehicle(options), options);
  if (wanted("mirrors")) measure(mirrors(options), options);
  if (wanted("fence")) measure(fence(options), options);
  return 0;
}
