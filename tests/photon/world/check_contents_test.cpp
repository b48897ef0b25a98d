// A World refuses what kernels could not work with: by place, number and remedy, all problems at once.
#include "photon/world/check_contents.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <limits>

#include "octree/base/error.h"
#include "photon/paths/radiance.h"
#include "tests/support/shapes_of_surfaces.h"
#include "tests/support/worlds.h"

using namespace obscura;

namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// One of everything.
WorldContents valid() {
  WorldContents contents = test::grey_contents(test::CloudWish(), 0.5);
  contents.clouds[0].name = "smoke";
  contents.sun = Sun{{0, 0, 1}, {5}, 0.01};
  contents.moon = Sun{{0, 1, 0}, {1}, 0.01};
  contents.atmosphere = Atmosphere{{1e-4}, {0.2}};
  contents.materials = {test::grey_material(0.5)};
  contents.objects.push_back(test::grey_object(test::parallelogram({0, 0, -1}, {1, 0, 0}, {0, 1, 0}), 0, 2.0));
  contents.objects[0].name = "truck";
  contents.sources.push_back({{0, 0, 9}, 0.1, {3}});
  contents.particles.push_back({{0, 0, 8}, 0.1, {3}});
  contents.beams.push_back({{0, 0, 5}, {0, 0, -1}, 0.1, {1}});
  return contents;
}

std::shared_ptr<Mesh> copy_of(const WorldContents& contents) {
  return std::make_shared<Mesh>(*contents.objects[0].mesh);
}

struct Misuse {
  const char* name;
  std::function<void(WorldContents&)> spoil;
  std::vector<const char*> words;  // of the error
};

std::vector<Misuse> misuses() {
  const auto mesh = [](const std::function<void(Mesh&)>& spoil) {
    return [spoil](WorldContents& w) {
      const auto changed = copy_of(w);
      spoil(*changed);
      w.objects[0].mesh = changed;
    };
  };
  return {
      {"no octree", [](auto& w) { w.clouds[0].octree = nullptr; }, {"smoke", "no octree"}},
      {"channel 7 of 1", [](auto& w) { w.clouds[0].media[0].channel = 7; }, {"smoke", "medium 0", "channel 7 of 1"}},
      {"channel -1", [](auto& w) { w.clouds[0].media[0].channel = -1; }, {"channel -1"}},
      {"no extinction", [](auto& w) { w.clouds[0].media[0].extinction = {}; }, {"0 values of extinction for 1"}},
      {"extinction NaN", [](auto& w) { w.clouds[0].media[0].extinction = {kNaN}; }, {"medium 0", "extinction nan"}},
      {"extinction -1", [](auto& w) { w.clouds[0].media[0].extinction = {-1}; }, {"extinction -1"}},
      {"albedo 2", [](auto& w) { w.clouds[0].media[0].albedo = {2}; }, {"albedo 2", "from 0 to 1"}},
      {"albedo NaN", [](auto& w) { w.clouds[0].media[0].albedo = {kNaN}; }, {"albedo nan"}},
      {"no albedo", [](auto& w) { w.clouds[0].media[0].albedo = {}; }, {"0 values of albedo"}},
      {"temperature channel 3", [](auto& w) { w.clouds[0].temperature.channel = 3; }, {"temperature channel 3 of 1"}},
      {"temperature scale NaN", [](auto& w) { w.clouds[0].temperature.scale = kNaN; }, {"temperature nan"}},
      {"-5 K", [](auto& w) { w.clouds[0].temperature.constant_K = -5; }, {"constant_K -5"}},
      {"two sources",
       [](auto& w) {
         w.clouds[0].source = {1, 2};
       },
       {"2 values of source"}},
      {"source -1", [](auto& w) { w.clouds[0].source = {-1}; }, {"source -1"}},
      {"two emissions",
       [](auto& w) {
         w.clouds[0].emission = {1, 2};
       },
       {"2 values of emission"}},
      {"no volume", [](auto& w) { w.clouds[0].local_to_world = Affine(0.0); }, {"smoke", "no volume"}},
      {"period NaN",
       [](auto& w) {
         w.clouds[0].period_m = {kNaN, 0};
       },
       {"period_m nan"}},
      {"no bands", [](auto& w) { w.bands.clear(); }, {"bands", "there are none"}},
      {"sun without irradiance", [](auto& w) { w.sun->irradiance = {}; }, {"sun", "0 values of irradiance"}},
      {"sun not of unit length",
       [](auto& w) {
         w.sun->toward = {0, 0, 3};
       },
       {"sun", "length 3", "unit vector"}},
      {"sun of no direction",
       [](auto& w) {
         w.sun->toward = {kNaN, 0, 0};
       },
       {"sun", "length nan"}},
      {"sun as wide as the sky", [](auto& w) { w.sun->diameter = 4; }, {"sun", "diameter 4"}},
      {"moon -1", [](auto& w) { w.moon->irradiance = {-1}; }, {"moon", "irradiance -1"}},
      {"sky of wrong length",
       [](auto& w) {
         w.sky = {1, 2, 3};
       },
       {"sky", "3 values of radiance for 1"}},
      {"sky infinite", [](auto& w) { w.sky = {kInfinity}; }, {"sky", "radiance inf"}},
      {"air without radiance", [](auto& w) { w.atmosphere->radiance = {}; }, {"atmosphere", "0 values of radiance"}},
      {"emissivity 3", [](auto& w) { w.materials[0].emissivity = {3}; }, {"material 0", "emissivity 3"}},
      {"specular 2", [](auto& w) { w.materials[0].specular = 2; }, {"material 0", "specular 2"}},
      {"roughness -1", [](auto& w) { w.materials[0].roughness = -1; }, {"roughness -1"}},
      {"permeable NaN", [](auto& w) { w.materials[0].permeable = kNaN; }, {"permeable nan"}},
      {"angles without factors",
       [](auto& w) {
         w.materials[0].angle_deg = {0, 90};
       },
       {"2 angles and 0 factors"}},
      {"angles backwards",
       [](auto& w) {
         w.materials[0].angle_deg = {90, 0};
         w.materials[0].angle_factor = {1, 1};
       },
       {"do not increase"}},
      {"vertex 9 of 4", mesh([](Mesh& m) { m.faces[0][1] = 9; }), {"truck", "vertex 9 of 4"}},
      {"vertex NaN", mesh([](Mesh& m) { m.vertices[2].y = kNaN; }), {"truck", "vertex 2 is not finite"}},
      {"one slot for two faces", mesh([](Mesh& m) { m.slots = {0}; }), {"1 slots for 2 faces"}},
      {"slot 5",
       mesh([](Mesh& m) {
         m.slots = {0, 5};
       }),
       {"slot 5 of 1"}},
      {"one face temperature", mesh([](Mesh& m) { m.face_K = {300}; }), {"1 face temperatures for 2"}},
      {"vertex of -3 K",
       mesh([](Mesh& m) {
         m.vertex_K = {1, 2, -3, 4};
       }),
       {"-3 K"}},
      {"material 4 of 1", [](auto& w) { w.objects[0].materials = {4}; }, {"truck", "material 4 of 1"}},
      {"no material", [](auto& w) { w.objects[0].materials = {}; }, {"truck", "no material"}},
      {"no temperatures", [](auto& w) { w.objects[0].K = {}; }, {"0 temperatures for 1"}},
      {"object of -1 K", [](auto& w) { w.objects[0].K = {-1}; }, {"temperature -1"}},
      {"neither mesh nor radius", [](auto& w) { w.objects[0].mesh = nullptr; }, {"truck", "no mesh", "radius 0"}},
      {"two radiances of an object",
       [](auto& w) {
         w.objects[0].radiance = {1, 2};
       },
       {"2 values of radiance"}},
      {"source without radiance", [](auto& w) { w.sources[0].radiance = {}; }, {"source 0", "0 values of radiance"}},
      {"source nowhere", [](auto& w) { w.sources[0].center.x = kNaN; }, {"source 0", "center"}},
      {"particle of radius -1", [](auto& w) { w.particles[0].radius = -1; }, {"particle 0", "radius -1"}},
      {"beam not of unit length",
       [](auto& w) {
         w.beams[0].direction = {0, 0, -2};
       },
       {"beam 0", "length 2"}},
      {"beam without power", [](auto& w) { w.beams[0].power = {}; }, {"beam 0", "0 values of power"}},
  };
}

}  // namespace

TEST_CASE("a World refuses each misuse by place, number and remedy", "[photon][world][contents]") {
  REQUIRE_NOTHROW(World(valid()));
  REQUIRE_NOTHROW(World(WorldContents()));
  for (const Misuse& misuse : misuses()) {
    INFO(misuse.name);
    WorldContents contents = valid();
    misuse.spoil(contents);
    std::string said;
    try {
      World world(std::move(contents));
    } catch (const InputError& error) {
      said = error.what();
      for (const Problem& problem : error.problems()) {
        CHECK_FALSE(problem.where.empty());
        CHECK_FALSE(problem.hint.empty());
      }
    }
    INFO(said);
    for (const char* word : misuse.words) CHECK(said.find(word) != std::string::npos);
  }
}

TEST_CASE("a World tells all that is wrong at once", "[photon][world][contents]") {
  WorldContents contents = valid();
  contents.sky = {1, 2};
  contents.clouds[0].media[0].albedo = {7};
  contents.beams[0].power = {};
  try {
    World world(std::move(contents));
    FAIL("it was taken");
  } catch (const InputError& error) {
    CHECK(error.problems().size() == 3);
  }
}

TEST_CASE("a negative voxel is refused by the octree or the World", "[photon][world][contents]") {
  const auto with = [](double value) {
    test::CloudWish wish;
    wish.voxels = Vec3i(4);
    wish.density = [value](const Vec3i& v) { return v == Vec3i(1, 2, 3) ? value : 1.0; };
    return World(test::grey_contents(wish, 0.5));
  };
  CHECK_NOTHROW(with(0));
  CHECK_THROWS_AS(with(-1), InputError);
}

TEST_CASE("rays are looked at once a call", "[photon][world][contents]") {
  const World world(valid());
  std::vector<Ray> rays(3, Ray{{0, 0, 5}, {0, 0, -1}, 0, kInfinity});
  std::vector<std::uint64_t> histories{0, 1, 2};
  std::vector<Incoming> incoming(3);
  const auto ask = [&](int interval) {
    return incoming_radiance({world, interval}, nullptr, RadianceSettings(), rays, histories, incoming);
  };
  REQUIRE_NOTHROW(ask(0));
  CHECK_THROWS_WITH(ask(1), Catch::Contains("interval 1 of 1"));
  CHECK_THROWS_WITH(ask(-1), Catch::Contains("interval -1"));
  rays[1].direction = {0, 0, -2};
  CHECK_THROWS_WITH(ask(0), Catch::Contains("ray 1") && Catch::Contains("length 2"));
  rays[1].direction = {0, kNaN, -1};
  CHECK_THROWS_AS(ask(0), InputError);
  rays[1].direction = {0, 0, -1};
  histories.pop_back();
  CHECK_THROWS_WITH(ask(0), Catch::Contains("3 rays, 2 histories"));
  histories.push_back(2);
  incoming.pop_back();
  CHECK_THROWS_WITH(ask(0), Catch::Contains("2 results"));
}
