#include "scene/world/build_world.h"

#include <algorithm>
#include <mutex>
#include <set>

#include "octree/base/error.h"
#include "octree/io/import.h"
#include "octree/source/puffs.h"
#include "octree/source/resample.h"
#include "octree/source/shapes.h"
#include "photon/limits/build_measure.h"
#include "scene/world/build_surfaces.h"
#include "scene/world/per_interval.h"

namespace obscura {

using namespace detail;

namespace {

/// The cloud's voxels, grids of one lattice together; the temperature is on every density's lattice.
std::vector<VoxelStream> open_cloud(const CloudDescription& cloud) {
  if (cloud.puffs) return {puffs_stream(*cloud.puffs)};
  const GridDescription& grid = *cloud.grid;
  switch (grid.kind) {
    case GridKind::sphere:
      return {sphere_stream(grid.radius_m, grid.voxel_m)};
    case GridKind::box:
      return {box_stream(grid.size_m, grid.voxel_m)};
    case GridKind::gaussian:
      return {gaussian_stream(grid.sigma_m, grid.size_m, grid.voxel_m)};
    case GridKind::file:
      break;
  }
  std::vector<GridRequest> requests;
  std::set<std::string> densities;
  for (const MediumDescription& medium : cloud.media) {
    if (densities.insert(medium.density).second) requests.push_back({medium.density, true, false});
  }
  const std::string temperature = cloud.temperature ? cloud.temperature->grid : std::string();
  if (!temperature.empty() && !densities.count(temperature)) {
    const bool absolute = cloud.temperature->offset_K == 0;
    requests.push_back({temperature, absolute, true});
  }
  std::vector<VoxelStream> streams = open_volume(grid.file, requests);

  // A temperature that lies on a lattice of its own is sampled where the densities are.
  const auto has = [](const VoxelStream& stream, const std::string& name) {
    return std::find(stream.channels.begin(), stream.channels.end(), name) != stream.channels.end();
  };
  if (temperature.empty()) return streams;
  const auto lone = std::find_if(streams.begin(), streams.end(), [&](const VoxelStream& stream) {
    return has(stream, temperature) && std::none_of(stream.channels.begin(), stream.channels.end(),
                                                    [&](const std::string& name) { return densities.count(name) > 0; });
  });
  const auto source =
      std::find_if(streams.begin(), streams.end(), [&](const VoxelStream& stream) { return has(stream, temperature); });
  std::vector<VoxelStream> joined;
  for (auto stream = streams.begin(); stream != streams.end(); ++stream) {
    if (stream == lone) continue;
    joined.push_back(has(*stream, temperature) ? *stream : resample(*stream, *source));
  }
  return joined;
}

int channel_of(const VoxelStream& stream, const std::string& name) {
  const auto found = std::find(stream.channels.begin(), stream.channels.end(), name);
  return found == stream.channels.end() ? -1 : static_cast<int>(found - stream.channels.begin());
}

/// The clouds of one description: one for each lattice, with an octree still to be built.
Cloud make_cloud(const Description& scene, const CloudDescription& description, const std::vector<Band>& bands,
                 const VoxelStream& stream) {
  Cloud cloud;
  cloud.name = description.name;
  for (const MediumDescription& medium : description.media) {
    // Shapes and puffs know one density.
    const int channel = channel_of(stream, medium.density);
    if (channel < 0) continue;
    cloud.media.push_back({channel, optical(bands, medium.extinction), optical(bands, medium.albedo), medium.phase});
  }
  if (description.temperature) {
    cloud.temperature.scale = description.temperature->scale;
    cloud.temperature.offset_K = description.temperature->offset_K;
    cloud.temperature.constant_K = description.temperature->K;
    if (!description.temperature->grid.empty())
      cloud.temperature.channel = channel_of(stream, description.temperature->grid);
  }
  cloud.source = per_interval(bands, [&](std::size_t b, int j) -> std::optional<double> {
    switch (
        emitter(scene, scene.bands[b], description.temperature.has_value(), description.given_radiance.has_value())) {
      case Emitter::planck:
        return std::nullopt;
      case Emitter::radiance:
        return bands[b].integrate(j, *description.given_radiance);
      case Emitter::none:
        break;
    }
    return 0.0;
  });
  if (description.emission != Spectrum::constant(0)) cloud.emission = integrated(bands, description.emission);
  cloud.local_to_world =
      placement(description.place.translate_m, kDegree * description.place.rotate_deg, description.place.scale);

  const Vec3d size(stream.bounds.max - stream.bounds.min);
  for (std::size_t axis = 0; axis < 2; ++axis) {
    if (!description.periodic[axis]) continue;
    const int a = static_cast<int>(axis);
    Vec3d side(0);
    side[a] = size[a];
    cloud.period_m[axis] = description.period_m[axis] > 0 ? description.period_m[axis]
                                                          : transform_direction(stream.index_to_local, side).length();
  }
  return cloud;
}

std::map<std::string, std::string> units_of(const VoxelStream& stream) {
  std::map<std::string, std::string> units;
  for (std::size_t c = 0; c < stream.units.size(); ++c) {
    if (!stream.units[c].empty()) units[stream.channels[c]] = stream.units[c];
  }
  return units;
}

void require_channels(const CloudDescription& description, const std::vector<VoxelStream>& streams) {
  std::string names;
  std::set<std::string> known;
  for (const VoxelStream& stream : streams) known.insert(stream.channels.begin(), stream.channels.end());
  for (const std::string& name : known) names += (names.empty() ? "" : ", ") + name;
  const auto require = [&](const std::string& grid) {
    if (!grid.empty() && !known.count(grid)) {
      throw InputError("cloud \"" + description.name + "\"", "it has no grid \"" + grid + "\"", "its grids: " + names);
    }
  };
  for (const MediumDescription& medium : description.media) require(medium.density);
  if (description.temperature) require(description.temperature->grid);
}

Sun make_sun(const std::vector<Band>& bands, const SunDescription& sun) {
  return {sun.toward.normalized(), integrated(bands, sun.irradiance), sun.diameter_deg * kDegree};
}

/// Nothing where the air is perfectly clear.
std::optional<Atmosphere> make_atmosphere(const Description& scene, const std::vector<Band>& bands) {
  if (!scene.atmosphere) return std::nullopt;
  const AtmosphereDescription& air = *scene.atmosphere;
  Atmosphere atmosphere{optical(bands, air.extinction_per_m), {}};
  const bool clear =
      std::all_of(atmosphere.extinction.begin(), atmosphere.extinction.end(), [](double k) { return k <= 0; });
  if (clear) return std::nullopt;
  const std::optional<double> K = air.K || air.radiance ? air.K : 288;
  atmosphere.radiance = emitted(scene, bands, K, air.radiance);
  return atmosphere;
}

std::vector<HotSphere> particles_at(const Description& scene, const std::vector<Band>& bands, double time_s) {
  // The rows of the latest time that has come.
  double latest = -kInfinity;
  for (const ParticleDescription& particle : scene.particles) {
    if (particle.s <= time_s) latest = std::max(latest, particle.s);
  }
  std::vector<HotSphere> spheres;
  for (const ParticleDescription& particle : scene.particles) {
    if (particle.s != latest) continue;
    spheres.push_back({particle.position_m, particle.radius_m, emitted(scene, bands, particle.K, std::nullopt)});
  }
  return spheres;
}

}  // namespace

Band make_band(const BandDescription& band) {
  if (band.grey()) return Band(band.name);
  return Band(band.name, (*band.um)[0], (*band.um)[1], band.samples, band.response);
}

BuiltWorld build_world(const Description& scene, double time_s, const Progress& progress) {
  WorldContents contents;
  for (const BandDescription& band : scene.bands) contents.bands.push_back(make_band(band));
  const std::vector<Band>& bands = contents.bands;

  std::vector<OctreeRecord> records;
  for (const CloudDescription& description : scene.clouds) {
    const std::vector<VoxelStream> streams = open_cloud(description);
    require_channels(description, streams);
    for (const VoxelStream& stream : streams) {
      Cloud cloud = make_cloud(scene, description, bands, stream);
      if (cloud.media.empty()) continue;
      BuildSettings settings;
      settings.tolerance = scene.render.octree_tolerance;
      settings.seed = scene.render.seed;
      settings.measure = build_measure(cloud, bands, stream);
      auto [octree, report] = build_octree(stream, settings, progress);
      cloud.octree = std::make_shared<const Octree>(std::move(octree));
      records.push_back({description.name, settings.tolerance, cloud.octree->statistics(), report, units_of(stream)});
      contents.clouds.push_back(std::move(cloud));
    }
  }
  for (const HotSphereDescription& sphere : scene.hot_spheres) {
    contents.sources.push_back({sphere.position_m, sphere.radius_m, emitted(scene, bands, sphere.K, sphere.radiance)});
  }
  contents.particles = particles_at(scene, bands, time_s);
  if (scene.sky) contents.sky = emitted(scene, bands, scene.sky->K, scene.sky->radiance);
  if (scene.sun) contents.sun = make_sun(bands, *scene.sun);
  if (scene.moon) contents.moon = make_sun(bands, *scene.moon);
  contents.atmosphere = make_atmosphere(scene, bands);
  build_surfaces(scene, contents);
  for (const BeamDescription& beam : scene.beams) {
    contents.beams.push_back({beam.position_m, beam.toward.normalized(), beam.radius_m, integrated(bands, beam.power)});
  }
  return {World(std::move(contents)), std::move(records)};
}

}  // namespace obscura
