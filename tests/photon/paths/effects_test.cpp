// An effect that a scene does not call for does nothing: its counters stay at exactly 0, and only its own.
#include <catch2/catch.hpp>
#include <set>

#include "photon/optics/work.h"
#include "photon/paths/path_tracer.h"
#include "tests/support/shapes_of_surfaces.h"
#include "tests/support/worlds.h"

using namespace obscura;
using namespace obscura::test;

namespace {

/// What a scene holds; by default everything.
struct Wish {
  bool attenuates = true, emits = true, glows = true, scatters = true;
  bool objects = true, mirrors = true, reflects = true, warm = true;
  bool sun = true, moon = true, sky = true, spheres = true, particles = true, beams = true, air = true;
  int intervals = 2;
};

World world_of(const Wish& wish) {
  const std::vector<double> none(static_cast<std::size_t>(wish.intervals), 0.0);
  const auto everywhere = [&](double value) { return std::vector<double>(none.size(), value); };
  WorldContents contents;
  contents.bands.emplace_back("mid", 3.0, 5.0, wish.intervals);

  CloudWish shape;
  shape.voxels = Vec3i(8);
  shape.density = [](const Vec3i& v) { return 0.5 + voxel_noise(3, v); };
  Cloud cloud = make_cloud(shape);
  cloud.media[0].extinction = everywhere(wish.attenuates ? 0.2 : 0.0);
  cloud.media[0].albedo = everywhere(wish.scatters ? 0.6 : 0.0);
  if (wish.emits) cloud.temperature.constant_K = 350;
  if (wish.glows) cloud.emission = everywhere(0.01);
  contents.clouds.push_back(cloud);

  if (wish.sky) contents.sky = everywhere(1);
  if (wish.sun) contents.sun = Sun{Vec3d(0.3, 0.1, 1).normalized(), everywhere(3), 0.01};
  if (wish.moon) contents.moon = Sun{Vec3d(-0.5, 0.1, 1).normalized(), everywhere(1), 0.01};
  if (wish.air) contents.atmosphere = Atmosphere{everywhere(0.01), everywhere(0.5)};

  Material material = grey_material(0, wish.mirrors ? 0.5 : 0.0);
  material.emissivity = everywhere(wish.reflects ? 0.5 : 1.0);
  contents.materials = {material};
  if (wish.objects) {
    Object floor;
    floor.mesh = parallelogram({-8, -8, -1}, {24, 0, 0}, {0, 24, 0});
    floor.K = {wish.warm ? 300.0 : 0.0};
    contents.objects = {floor};
  }
  if (wish.spheres) contents.sources.push_back({{4, 4, 11}, 0.5, everywhere(20)});
  if (wish.particles) contents.particles.push_back({{4, -3, 4}, 0.5, everywhere(20)});
  if (wish.beams) contents.beams.push_back({{0, 4, 9}, Vec3d(0.3, 0, -1).normalized(), 2, everywhere(500)});
  return World(std::move(contents));
}

enum Way { by_map = 1, by_gather = 2, by_path = 4, every_way = 7 };

/// Everything that tracing and rendering do, at every interval.
WorkCounts work_of(const Wish& wish, int ways = every_way, const RadianceSettings& wanted = {}) {
  const World world = world_of(wish);
  TraceSettings trace;
  trace.photons = 2000;
  trace.scattering_depth = wanted.scattering_depth;
  const Light light = trace_light(world, trace);
  WorkCounts work;
  if (ways & (by_map | by_gather)) work += light.work;
  CHECK(light.anomalies == 0);

  std::vector<Ray> rays;
  std::vector<std::uint64_t> histories;
  for (std::uint64_t i = 0; i < 256; ++i) {
    Stream random(4, i, 1);
    const Vec3d origin(4 + 14 * (random.uniform() - 0.5), -12, 6 * random.uniform());
    rays.push_back(
        {origin, (Vec3d(4 + 8 * random.uniform(), 4, 12 * random.uniform() - 3) - origin).normalized(), 0, kInfinity});
    histories.push_back(i);
  }
  std::vector<Incoming> incoming(rays.size());
  for (int i = 0; i < world.interval_count(); ++i) {
    for (const int bounces : {0, 1, kAllBounces}) {
      if (!(ways & (bounces == 0 ? by_map : bounces == 1 ? by_gather : by_path))) continue;
      RadianceSettings settings = wanted;
      settings.gather_bounces = bounces;
      settings.gather.nearest = 16;
      const PhotonMaps* maps = bounces == kAllBounces ? nullptr : &light.maps[static_cast<std::size_t>(i)];
      const RadianceCounts counts = incoming_radiance({world, i}, maps, settings, rays, histories, incoming);
      CHECK(counts.rays == rays.size());
      CHECK(counts.anomalies == 0);
      work += counts.work;
    }
  }
  return work;
}

std::set<std::string> idle(const WorkCounts& work) {
  std::set<std::string> names;
  for (std::size_t w = 0; w < kWorkNames.size(); ++w) {
    if (work[static_cast<Work>(w)] == 0) names.emplace(kWorkNames[w]);
  }
  return names;
}

using Names = std::set<std::string>;

}  // namespace

TEST_CASE("where a scene calls for everything, the code of every effect runs", "[photon][effects]") {
  CHECK(idle(work_of({})) == Names{});
}

TEST_CASE("an effect that a scene does not hold does nothing, and the others do as before", "[photon][effects]") {
  struct Case {
    const char* name;
    Names off;
    std::function<void(Wish&)> without;
  };
  const Case cases[] = {
      {"clouds that only glow", {"extinction", "scattering", "collisions"}, [](Wish& w) { w.attenuates = false; }},
      {"cold clouds", {"emission", "photons_emission"}, [](Wish& w) { w.emits = w.glows = false; }},
      {"black clouds", {"scattering"}, [](Wish& w) { w.scatters = false; }},
      {"nothing scatters or reflects",
       {"scattering", "map", "gather", "specular", "sun", "sky", "faces", "spheres", "beams"},
       [](Wish& w) { w.scatters = w.reflects = false; }},
      {"no objects", {"specular", "faces", "photons_faces"}, [](Wish& w) { w.objects = false; }},
      {"nothing opaque",
       {"masking", "surfaces", "specular", "faces", "spheres", "photons_faces", "photons_spheres"},
       [](Wish& w) { w.objects = w.spheres = w.particles = false; }},
      {"no mirror", {"specular"}, [](Wish& w) { w.mirrors = false; }},
      {"cold objects", {"faces", "photons_faces"}, [](Wish& w) { w.warm = false; }},
      {"no sun and no moon", {"sun", "photons_sun"}, [](Wish& w) { w.sun = w.moon = false; }},
      {"a dark sky", {"sky", "photons_sky"}, [](Wish& w) { w.sky = false; }},
      {"no hot spheres", {"spheres", "photons_spheres"}, [](Wish& w) { w.spheres = w.particles = false; }},
      {"no beams", {"beams", "photons_beams"}, [](Wish& w) { w.beams = false; }},
      {"no air", {"atmosphere"}, [](Wish& w) { w.air = false; }},
      {"one interval a band", {"spectral"}, [](Wish& w) { w.intervals = 1; }},
  };
  for (const Case& c : cases) {
    INFO(c.name);
    Wish wish;
    c.without(wish);
    CHECK(idle(work_of(wish)) == c.off);
  }
}

TEST_CASE("what the settings leave out does nothing either", "[photon][effects]") {
  const auto idle_by = [](int ways, auto&& change) {
    RadianceSettings settings;
    change(settings);
    return idle(work_of({}, ways, settings));
  };
  // The map is asked for the light of beams and particles, and follows nothing itself.
  CHECK(idle_by(by_map, [](RadianceSettings&) {}) == Names{"gather", "beams"});
  CHECK(idle_by(by_gather, [](RadianceSettings&) {}) == Names{});
  CHECK(idle_by(by_path, [](RadianceSettings&) {}) == Names{"map", "photons_emission", "photons_sun", "photons_sky",
                                                            "photons_faces", "photons_spheres", "photons_beams",
                                                            "collisions"});
  CHECK(idle_by(every_way, [](RadianceSettings& s) { s.specular_depth = 0; }) == Names{});
  CHECK(idle_by(every_way, [](RadianceSettings& s) { s.scattering_depth = 0; }) == Names{"scattering"});
  CHECK(idle_by(by_map, [](RadianceSettings& s) { s.parts.map = false; }) == Names{"map", "gather", "beams"});
  CHECK(idle_by(by_path, [](RadianceSettings& s) { s.parts.emission = false; }).count("emission") == 1);
  CHECK(idle_by(by_path, [](RadianceSettings& s) { s.parts.sun = false; }).count("sun") == 1);
  CHECK(idle_by(by_path, [](RadianceSettings& s) { s.parts.sky = false; }).count("sky") == 1);
  CHECK(idle_by(by_path, [](RadianceSettings& s) { s.parts.surfaces = false; }).count("faces") == 1);
  CHECK(idle_by(by_path, [](RadianceSettings& s) { s.parts.spheres = false; }).count("spheres") == 1);
}

TEST_CASE("photons are counted by what sent them, trial runs included", "[photon][effects]") {
  const World world = world_of({});
  TraceSettings settings;
  settings.photons = 2000;
  const Light light = trace_light(world, settings);
  std::uint64_t emitted = 0;
  for (const Work kind : {Work::photons_emission, Work::photons_sun, Work::photons_sky, Work::photons_faces,
                          Work::photons_spheres, Work::photons_beams}) {
    emitted += light.work[kind];
  }
  CHECK(emitted == light.emitted);
  CHECK(light.work[Work::collisions] + light.work[Work::surfaces] >= light.stored);
  settings.photons = 50000;
  const Light tried = trace_light(world, settings);
  emitted = 0;
  for (std::size_t w = static_cast<std::size_t>(Work::photons_emission);
       w <= static_cast<std::size_t>(Work::photons_beams); ++w) {
    emitted += tried.work[static_cast<Work>(w)];
  }
  CHECK(emitted > tried.emitted);

  // Passes add up.
  Light sum;
  for (int pass = 0; pass < 2; ++pass) sum.add_tallies(light);
  CHECK(sum.work[Work::collisions] == 2 * light.work[Work::collisions]);
}
