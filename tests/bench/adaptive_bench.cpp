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
#include "octree/build/build.h"
#include "sensor/capture/render.h"
#include "tests/support/rendered.h"

using namespace obscura;

namespace {

struct Options {
  int columns = 128, seeds = 8, passes = 3;
  std::string only, pictures;
};

/// Rays per pixel of each pass of the reference, and of uniform sampling.
constexpr int kReference = 576;
constexpr int kUniform[] = {1, 4, 9, 16, 36, 64, 144, 256, 576};
constexpr int kMost[] = {16, 64, 256};

// Meshes.

void quad(Mesh& mesh, const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& d) {
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), {a, b, c, d});
  mesh.faces.push_back({first, first + 1, first + 2});
  mesh.faces.push_back({first, first + 2, first + 3});
}

void box(Mesh& mesh, const Vec3d& a, const Vec3d& b) {
  quad(mesh, {a.x, a.y, a.z}, {a.x, b.y, a.z}, {b.x, b.y, a.z}, {b.x, a.y, a.z});
  quad(mesh, {a.x, a.y, b.z}, {b.x, a.y, b.z}, {b.x, b.y, b.z}, {a.x, b.y, b.z});
  quad(mesh, {a.x, a.y, a.z}, {b.x, a.y, a.z}, {b.x, a.y, b.z}, {a.x, a.y, b.z});
  quad(mesh, {b.x, b.y, a.z}, {a.x, b.y, a.z}, {a.x, b.y, b.z}, {b.x, b.y, b.z});
  quad(mesh, {a.x, b.y, a.z}, {a.x, a.y, a.z}, {a.x, a.y, b.z}, {a.x, b.y, b.z});
  quad(mesh, {b.x, a.y, a.z}, {b.x, b.y, a.z}, {b.x, b.y, b.z}, {b.x, a.y, b.z});
}

/// A prism with n sides about the line from a to b, with its ends.
void prism(Mesh& mesh, const Vec3d& a, const Vec3d& b, double radius, int n) {
  const auto [u, v] = orthonormal_basis((b - a).normalized());
  const auto at = [&, u = u, v = v](const Vec3d& c, int i) {
    const double angle = 2 * kPi * (i + 0.5) / n;
    return c + radius * (std::cos(angle) * u + std::sin(angle) * v);
  };
  for (int i = 0; i < n; ++i) {
    quad(mesh, at(a, i), at(a, i + 1), at(b, i + 1), at(b, i));
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    mesh.vertices.insert(mesh.vertices.end(), {a, at(a, i + 1), at(a, i), b, at(b, i), at(b, i + 1)});
    mesh.faces.push_back({first, first + 1, first + 2});
    mesh.faces.push_back({first + 3, first + 4, first + 5});
  }
}

/// A ball of 2 n x n flat faces.
void ball(Mesh& mesh, const Vec3d& centre, double radius, int n) {
  const auto at = [&](int i, int j) {
    const double angle = kPi * i / n, polar = kPi * j / n;
    return centre +
           radius * Vec3d(std::sin(polar) * std::cos(angle), std::sin(polar) * std::sin(angle), std::cos(polar));
  };
  for (int i = 0; i < 2 * n; ++i) {
    for (int j = 0; j < n; ++j) quad(mesh, at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j));
  }
}

struct Scene {
  std::string name;
  WorldContents contents;
  CameraSettings camera;

  explicit Scene(std::string called) : name(std::move(called)) { contents.bands.emplace_back("LWIR", 8.0, 12.0); }
  int material(double emissivity, double specular = 0) {
    Material made;
    made.emissivity = {emissivity};
    made.specular = specular;
    contents.materials.push_back(made);
    return static_cast<int>(contents.materials.size()) - 1;
  }
  void add(Mesh mesh, int material, double kelvin, Affine placed = {}) {
    Object object;
    object.mesh = std::make_shared<const Mesh>(std::move(mesh));
    object.materials = {material};
    object.K = {kelvin};
    object.local_to_world = placed;
    contents.objects.push_back(std::move(object));
  }
  double planck(double kelvin) const { return contents.bands[0].planck(kelvin); }
  void look(const Options& options, const Vec3d& from, const Vec3d& at, double width_m) {
    camera.position_m = from;
    camera.look_at_m = at;
    camera.fov_deg = 2 * std::atan(0.5 * width_m / (at - from).length()) * 180 / kPi;
    camera.resolution = {options.columns, options.columns * 3 / 4};
  }
};

/// Hills of 10 m posts, warmer where they face south; the vehicle is seen from a side at a quarter of its length per
/// six pixels, through 2 km of air.
Scene vehicle(const Options& options) {
  Scene scene("vehicle at 2 km");
  const int soil = scene.material(1), paint = scene.material(1), rubber = scene.material(1), steel = scene.material(1);
  scene.contents.sky = {scene.planck(240)};
  scene.contents.atmosphere = Atmosphere{{1e-4}, {scene.planck(283)}};
  const auto height = [](double x, double y) {
    const double far = std::max(0.0, (y - 2050) / 1000);
    return 6 * std::sin(x / 90 + 0.7) * std::cos(y / 130) + 2 * std::sin(x / 31) * std::sin(y / 23 + 1) +
           40 * far * far;
  };
  Mesh ground;
  constexpr std::uint32_t columns = 120, rows = 340;
  for (std::uint32_t j = 0; j <= rows; ++j) {
    for (std::uint32_t i = 0; i <= columns; ++i) {
      const double x = 10.0 * i - 600, y = 10.0 * j, z = height(x, y);
      const double south = (height(x, y - 5) - height(x, y + 5)) / 10;
      ground.vertices.push_back({x, y, z});
      ground.vertex_K.push_back(static_cast<float>(285 + 6 * -south + 0.8 * std::sin(x / 17) * std::sin(y / 19)));
    }
  }
  for (std::uint32_t j = 0; j < rows; ++j) {
    for (std::uint32_t i = 0; i < columns; ++i) {
      const std::uint32_t a = j * (columns + 1) + i, d = a + columns + 1;
      ground.faces.push_back({a, a + 1, d + 1});
      ground.faces.push_back({a, d + 1, d});
    }
  }
  scene.add(std::move(ground), soil, 285);

  double stand = -kInfinity;
  for (int i = -4; i <= 4; ++i) {
    for (int j = -2; j <= 2; ++j) stand = std::max(stand, height(i, 2000 + j));
  }
  const Affine placed = placement({0, 2000, stand}, {0, 0, 35}, 1);
  Mesh hull, turret, wheels, exhaust, engine, gun;
  box(hull, {-3.4, -1.5, 0.7}, {3.4, 1.5, 1.7});
  box(hull, {-2.6, -1.3, 1.7}, {2.2, 1.3, 2.0});
  prism(turret, {-0.3, 0, 2.0}, {-0.3, 0, 2.7}, 1.1, 12);
  prism(gun, {0.6, 0, 2.35}, {4.6, 0, 2.5}, 0.07, 8);
  for (const double y : {-1.75, 1.45}) {
    for (const double x : {-2.6, -1.3, 0.0, 1.3, 2.6}) prism(wheels, {x, y, 0.5}, {x, y + 0.3, 0.5}, 0.5, 16);
  }
  box(engine, {-3.0, -1.2, 1.7001}, {-2.62, 1.2, 1.85});
  prism(exhaust, {-3.2, -1.6, 1.3}, {-4.0, -1.6, 1.3}, 0.11, 12);
  scene.add(std::move(hull), paint, 289, placed);
  scene.add(std::move(turret), paint, 288, placed);
  scene.add(std::move(gun), steel, 287, placed);
  scene.add(std::move(wheels), rubber, 297, placed);
  scene.add(std::move(engine), paint, 320, placed);
  scene.add(std::move(exhaust), steel, 340, placed);
  scene.look(options, {0, 0, 60}, {0, 2000, stand + 3}, 32);
  return scene;
}

/// A wall mirror, a column of 24 facets and a ball of 288 show warm things beside the camera, the ground and the sky.
Scene mirrors(const Options& options) {
  Scene scene("mirrors and facets");
  const int soil = scene.material(1), metal = scene.material(0.05, 1), paint = scene.material(1);
  scene.contents.sky = {scene.planck(240)};
  Mesh ground, wall, column, sphere, crate, stove, pole;
  quad(ground, {-500, -500, 0}, {500, -500, 0}, {500, 500, 0}, {-500, 500, 0});
  quad(wall, {-4.2, 11, 0.3}, {-0.6, 11.6, 0.3}, {-0.6, 11.6, 3.3}, {-4.2, 11, 3.3});
  prism(column, {1.0, 10, 0}, {1.0, 10, 3.4}, 0.6, 24);
  ball(sphere, {3.2, 9.5, 1.3}, 1.1, 12);
  box(crate, {-2.2, 5.5, 0}, {-1.3, 6.4, 0.9});
  box(stove, {1.6, 6.4, 0}, {2.1, 6.9, 0.8});
  prism(pole, {-0.2, 7.5, 0}, {-0.2, 7.5, 2.4}, 0.06, 10);
  scene.add(std::move(ground), soil, 288);
  scene.add(std::move(wall), metal, 288);
  scene.add(std::move(column), metal, 288);
  scene.add(std::move(sphere), metal, 288);
  scene.add(std::move(crate), paint, 300);
  scene.add(std::move(stove), paint, 330);
  scene.add(std::move(pole), paint, 310);
  scene.look(options, {0, 0, 1.8}, {0, 10, 1.7}, 10);
  return scene;
}

/// Smoke at 310 K that absorbs and emits, of optical depth 2 in its middle, 20 m before a fence of 2.5 mm wires, 15 cm
/// apart: a twentieth of a pixel at 128 columns. Its voxels are a pixel wide; the horizon is behind the fence.
Scene fence(const Options& options) {
  Scene scene("smoke before a wire fence");
  const int soil = scene.material(1), zinc = scene.material(1), wood = scene.material(1);
  scene.contents.sky = {scene.planck(250)};
  Mesh ground, wires, posts;
  quad(ground, {-2000, -100, 0}, {2000, -100, 0}, {2000, 4000, 0}, {-2000, 4000, 0});
  constexpr double y = 100, top = 1.5;
  for (double z = 0.1; z < top + 0.01; z += 0.15) prism(wires, {-6, y, z}, {6, y, z}, 0.00125, 4);
  for (double x = -5.95; x < 6; x += 0.15) prism(wires, {x, y, 0}, {x, y, top}, 0.00125, 4);
  for (double x = -5; x < 6; x += 2.5) prism(posts, {x, y + 0.1, 0}, {x, y + 0.1, top + 0.15}, 0.05, 8);
  scene.add(std::move(ground), soil, 290);
  scene.add(std::move(wires), zinc, 284);
  scene.add(std::move(posts), wood, 286);

  constexpr int side = 128;
  constexpr double voxel = 0.05;
  const auto density = [](int i, int j, int k) {
    const double x = (i + 0.5) * voxel - 2.6, d = (j + 0.5) * voxel - 3.2, z = (k + 0.5) * voxel;
    const double drift = x + 0.5 * z, width = 0.5 + 0.16 * z,
                 lumps = 1 + 0.6 * std::sin(3 * x + z) * std::sin(2.3 * z + 1.7 * d);
    return std::exp(-0.5 * (drift * drift + d * d) / (width * width)) * lumps * std::exp(-z / 6);
  };
  VoxelStream stream;
  stream.channels = {"density"};
  for (int i = 0; i < 3; ++i) stream.index_to_local[i][i] = voxel;
  stream.bounds = Box3i(Vec3i(0), Vec3i(side));
  stream.name = "smoke";
  stream.pour = [&](VoxelSink& sink) {
    for (int x = 0; x < side; x += 8) {
      for (int d = 0; d < side; d += 8) {
        for (int z = 0; z < side; z += 8) {
          float values[512];
          const float* channels[] = {values};
          bool any = false;
          for (int i = 0; i < 512; ++i) {
            const double v = density(x + (i & 7), d + (i >> 3 & 7), z + (i >> 6));
            values[i] = v > 1e-3 ? static_cast<float>(v) : 0.0f;
            any = any || values[i] > 0;
          }
          if (any) sink.brick({x, d, z}, channels);
        }
      }
    }
  };
  BuildSettings lossless;
  lossless.tolerance = 0;
  Cloud smoke;
  smoke.name = "smoke";
  smoke.octree = std::make_shared<const Octree>(build_octree(stream, lossless).first);
  smoke.local_to_world = placement({-2, 76, 0}, {0, 0, 0.3}, 1);
  smoke.media.push_back({0, {1.5}, {0.0}, PhaseFunction::isotropic()});
  smoke.temperature.constant_K = 310;
  scene.contents.clouds.push_back(smoke);
  scene.look(options, {0, 0, 1.1}, {0, 100, 1.4}, 6.4);
  return scene;
}

// Measuring.

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
