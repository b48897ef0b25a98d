// A program that uses the installed library: a sphere of smoke, made from arrays, and one ray through it.
#include <cmath>
#include <cstdio>

#include <octree/build/build.h>
#include <octree/source/shapes.h>
#include <photon/trace/light.h>
#include <photon/paths/radiance.h>

int main() {
  using namespace obscura;
  const VoxelStream voxels = sphere_stream(1, 0.05);
  BuildSettings settings;
  settings.measure.optical_weight = {0.5};

  Cloud cloud;
  cloud.octree = std::make_shared<const Octree>(build_octree(voxels, settings).first);
  cloud.media.push_back({0, {0.5}, {0.8}, PhaseFunction::henyey_greenstein(0.7)});
  cloud.temperature.constant_K = 300;
  WorldContents contents;
  contents.bands.emplace_back("lwir", 8, 12);
  contents.clouds.push_back(std::move(cloud));
  const World world(std::move(contents));

  TraceSettings trace;
  trace.photons = 10000;
  const Light light = trace_light(world, trace);
  const Ray ray{{0, -5, 0}, {0, 1, 0}, 0, kInfinity};
  const std::uint64_t history = 0;
  Incoming incoming;
  incoming_radiance({world, 0}, &light.maps[0], {}, {&ray, 1}, {&history, 1}, {&incoming, 1});
  std::printf("transmission %.4f, radiance %.3f W/m2/sr\n", incoming.transmission, incoming.total());
  return std::abs(incoming.transmission - std::exp(-1.0)) < 0.01 && incoming.total() > 0 ? 0 : 1;
}
