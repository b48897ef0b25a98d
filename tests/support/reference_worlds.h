// Worlds of the reference tables: stacks of layers without end, boxes of cells, spheres of voxels.
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "octree/build/build.h"
#include "octree/source/shapes.h"
#include "photon/world/world.h"
#include "tests/support/verified.h"
#include "tests/support/voxel_fields.h"

namespace obscura::test {

/// The phase function of a table's row.
inline PhaseFunction hg(double g) { return g == 0 ? PhaseFunction::isotropic() : PhaseFunction::henyey_greenstein(g); }

/// From the moments (2 l + 1) chi_l that file f6 has published for "hazeL" or "cloudC1", as a table of 2881
/// angles.
inline PhaseFunction published_phase(const std::string& name) {
  const Csv csv = reference_table("f6_mie_polydisperse_moments.csv");
  std::vector<double> moments{1};
  for (std::size_t i = 0; i < csv.size(); ++i) {
    if (csv.text(i, "name") == name && !csv.text(i, "published").empty()) moments.push_back(csv.number(i, "published"));
  }
  std::vector<double> angles, values;
  constexpr int kSteps = 2880;
  for (int i = 0; i <= kSteps; ++i) {
    const double cosine = std::cos(kPi * i / kSteps);
    double before = 0, legendre = 1, sum = 0;
    for (std::size_t l = 0; l < moments.size(); ++l) {
      sum += moments[l] * legendre;
      const double next = ((2.0 * static_cast<double>(l) + 1) * cosine * legendre - static_cast<double>(l) * before) /
                          (static_cast<double>(l) + 1);
      before = legendre;
      legendre = next;
    }
    angles.push_back(180.0 * i / kSteps);
    values.push_back(std::max(0.0, sum));  // the series is cut off: it may swing below 0 by a little
  }
  return PhaseFunction::table(angles, values, nullptr);
}

/// Of a row of d1 (no column "phase") or d2.
inline PhaseFunction row_phase(const Csv& csv, std::size_t row) {
  return csv.has("phase") && csv.text(row, "phase") == "rayleigh" ? PhaseFunction::rayleigh()
                                                                  : hg(csv.number(row, "g"));
}

/// Of a problem of DISORT's, by its number in file d6.
inline PhaseFunction disort_phase(char problem) {
  switch (problem) {
    case '1':
      return hg(0);
    case '2':
      return PhaseFunction::rayleigh();
    case '3':
      return hg(0.75);
    case '4':
      return published_phase("hazeL");
    default:
      return published_phase("cloudC1");
  }
}

inline std::shared_ptr<const Octree> exact_octree(const VoxelStream& stream) {
  BuildSettings settings;
  settings.tolerance = 0;
  settings.measure.optical_weight.assign(stream.channels.size(), 1.0);
  return std::make_shared<const Octree>(build_octree(stream, settings).first);
}

/// Voxels of the given size with their lower corner at the origin.
inline VoxelStream lattice(const Vec3i& voxels, const Vec3d& voxel_m, std::vector<std::string> channels, Field field) {
  Affine scale;
  scale.setScale(voxel_m);
  return field_stream(Box3i(Vec3i(0), voxels), std::move(channels), std::move(field), scale);
}

struct Layer {
  double tau = 1;
  double albedo = 0;
  PhaseFunction phase;
  double source = 0;  ///< Planck radiance
};

/// The layers of a row of d7.
inline std::vector<Layer> row_layers(const Csv& csv, std::size_t row) {
  const std::vector<double> tau = csv.numbers(row, "tau_list"), w = csv.numbers(row, "w_list"),
                            g = csv.numbers(row, "g_list");
  std::vector<Layer> layers;
  for (std::size_t i = 0; i < tau.size(); ++i) layers.push_back({tau[i], w[i], hg(g[i]), 0});
  return layers;
}

/// One above the other, 1 m each, the first on top; the lowest stands on z = 0. Light of a sun comes down
/// along (sin, 0, -mu0), its irradiance normal to the beam is 1.
struct Stack {
  std::vector<Layer> layers;
  double side_m = 1000;  ///< of the periodic cell, which is one voxel
  double mu0 = 0;        ///< cosine of the sun's zenith angle; 0: no sun
  double sky = 0;

  double top() const { return static_cast<double>(layers.size()); }
};

inline WorldContents stack_contents(const Stack& stack) {
  WorldContents contents;
  contents.bands.emplace_back("grey");
  contents.sky = {stack.sky};
  const auto octree = exact_octree(
      lattice({1, 1, 1}, {stack.side_m, stack.side_m, 1}, {"density"}, [](int, const Vec3i&) { return 1.0f; }));
  for (std::size_t i = 0; i < stack.layers.size(); ++i) {
    const Layer& layer = stack.layers[i];
    Cloud cloud;
    cloud.name = "layer";
    cloud.octree = octree;
    cloud.local_to_world = placement({0, 0, stack.top() - 1 - static_cast<double>(i)}, Vec3d(0), 1);
    cloud.media.push_back({0, {layer.tau}, {layer.albedo}, layer.phase});
    if (layer.source > 0) cloud.source = {layer.source};
    cloud.period_m = {stack.side_m, stack.side_m};
    contents.clouds.push_back(std::move(cloud));
  }
  if (stack.mu0 > 0) contents.sun = Sun{{-std::sqrt((1 - stack.mu0) * (1 + stack.mu0)), 0, stack.mu0}, {1}, 0};
  return contents;
}

/// One layer of 1 m whose Planck radiance is linear in depth, from the middles of `voxels` along z. It is
/// a channel of its own: emission that is added to a medium that does not attenuate.
inline WorldContents linear_source_contents(const Layer& layer, double top, double bottom, int voxels, double side_m) {
  WorldContents contents;
  contents.bands.emplace_back("grey");
  contents.sky = {0};
  Cloud cloud;
  cloud.name = "linear";
  cloud.octree = exact_octree(
      lattice({1, 1, voxels}, {side_m, side_m, 1.0 / voxels}, {"source", "density"}, [=](int channel, const Vec3i& v) {
        return channel == 1 ? 1.0f : static_cast<float>(bottom + (top - bottom) * (v.z + 0.5) / voxels);
      }));
  cloud.media.push_back({0, {0}, {0}, PhaseFunction::isotropic()});
  cloud.media.push_back({1, {layer.tau}, {layer.albedo}, layer.phase});
  cloud.emission = {layer.tau * (1 - layer.albedo)};
  cloud.period_m = {side_m, side_m};
  contents.clouds.push_back(std::move(cloud));
  return contents;
}

/// What fills the cells of a box.
struct Matter {
  double extinction = 0;  ///< 1/m
  double albedo = 0;
};

/// A box of cubic cells with its lower corner at the origin; kinds(cell) chooses one of the matters or, with a
/// negative number, nothing.
inline WorldContents box_contents(const Vec3i& cells, double cell_m, const std::vector<Matter>& matters,
                                  const PhaseFunction& phase, const std::function<int(const Vec3i&)>& kind) {
  WorldContents contents;
  contents.bands.emplace_back("grey");
  contents.sky = {0};
  Cloud cloud;
  cloud.name = "box";
  std::vector<std::string> channels;
  for (std::size_t m = 0; m < matters.size(); ++m) {
    channels.push_back("matter " + std::to_string(m));
    cloud.media.push_back({static_cast<int>(m), {matters[m].extinction}, {matters[m].albedo}, phase});
  }
  cloud.octree = exact_octree(lattice(cells, Vec3d(cell_m), channels,
                                      [&](int channel, const Vec3i& v) { return kind(v) == channel ? 1.0f : 0.0f; }));
  contents.clouds.push_back(std::move(cloud));
  return contents;
}

/// A homogeneous sphere of extinction 1 about the origin, its border cells filled in proportion.
inline WorldContents sphere_contents(double radius, double albedo, const PhaseFunction& phase, int voxels_across) {
  WorldContents contents;
  contents.bands.emplace_back("grey");
  contents.sky = {0};
  Cloud cloud;
  cloud.name = "sphere";
  cloud.octree = exact_octree(sphere_stream(radius, 2 * radius / voxels_across));
  cloud.media.push_back({0, {1}, {albedo}, phase});
  contents.clouds.push_back(std::move(cloud));
  return contents;
}

}  // namespace obscura::test
