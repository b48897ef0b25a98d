// Scenes of adaptive_bench: a vehicle at 2 km over terrain, mirrors with facets, smoke before a wire fence.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>

#include "octree/build/build.h"
#include "photon/world/world.h"
#include "sensor/capture/render.h"

namespace obscura::bench {

struct Options {
  int columns = 128, seeds = 8, passes = 3;
  std::string only, pictures;
};

// Meshes.

inline void quad(Mesh& mesh, const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& d) {
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), {a, b, c, d});
  mesh.faces.push_back({first, first + 1, first + 2});
  mesh.faces.push_back({first, first + 2, first + 3});
}

inline void box(Mesh& mesh, const Vec3d& a, const Vec3d& b) {
  quad(mesh, {a.x, a.y, a.z}, {a.x, b.y, a.z}, {b.x, b.y, a.z}, {b.x, a.y, a.z});
  quad(mesh, {a.x, a.y, b.z}, {b.x, a.y, b.z}, {b.x, b.y, b.z}, {a.x, b.y, b.z});
  quad(mesh, {a.x, a.y, a.z}, {b.x, a.y, a.z}, {b.x, a.y, b.z}, {a.x, a.y, b.z});
  quad(mesh, {b.x, b.y, a.z}, {a.x, b.y, a.z}, {a.x, b.y, b.z}, {b.x, b.y, b.z});
  quad(mesh, {a.x, b.y, a.z}, {a.x, a.y, a.z}, {a.x, a.y, b.z}, {a.x, b.y, b.z});
  quad(mesh, {b.x, a.y, a.z}, {b.x, b.y, a.z}, {b.x, b.y, b.z}, {b.x, a.y, b.z});
}

/// A prism with n sides about the line from a to b, with its ends.
inline void prism(Mesh& mesh, const Vec3d& a, const Vec3d& b, double radius, int n) {
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
inline void ball(Mesh& mesh, const Vec3d& centre, double radius, int n) {
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
inline Scene vehicle(const Options& options) {
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
inline Scene mirrors(const Options& options) {
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
inline Scene fence(const Options& options) {
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

}  // namespace obscura::bench
