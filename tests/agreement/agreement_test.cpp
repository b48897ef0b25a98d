// Photon map, path tracer and discrete ordinates on clouds that no formula knows: pixel by pixel, and in
// means, fluence and flux, within what each says of its own error.
#include <catch2/catch.hpp>
#include <fstream>

#include "scene/file/scene_io.h"
#include "scene/session/session.h"
#include "scene/verify/verify.h"
#include "tests/support/rough_cloud.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/shared_data.h"

using namespace obscura;
using namespace obscura::test;

namespace {

/// All comparisons agree, among all three methods. Fails by name.
void check(const VerifiedScene& scene) {
  INFO(verify_table({scene}));
  for (const VerifyMethod& method : scene.methods) {
    INFO(method.name);
    CHECK(method.refusal.empty());
  }
  for (const std::string& failure : scene.failures()) FAIL_CHECK(failure);
  CHECK(scene.pixels.size() == 3 * scene.bands.size());
  CHECK(scene.rows.size() >= scene.bands.size());
}

/// Where one method takes the scene for another one, the others say so.
void check_told_apart(const Description& right, const Description& wrong, const VerifySettings& settings) {
  constexpr std::size_t kPhoton = 0, kPath = 1;
  for (const std::size_t liar : {kPhoton, kPath}) {
    std::vector<VerifyMethod> methods;
    for (const std::size_t method : {kPhoton, kPath}) {
      Session session(method == liar ? wrong : right, right.time_s);
      methods.push_back(run_method(session, referees(session)[method], settings));
    }
    const VerifiedScene scene = compare_methods(right, std::move(methods), settings);
    INFO(method_words()[liar] << "\n" << verify_table({scene}));
    CHECK(!scene.failures().empty());
  }
}

const char* const kSensor = R"("resolution": [32, 24], "max_oversampling": 16},
    "render": {"photons": 200000, "samples": 128, "octree_tolerance": 0}})";

std::string puffs(double albedo) {
  return R"({"obscura": 1, "bands": [{"name": "grey"}],
    "clouds": [{"puffs": {"sources": [{"position_m": [0, 0, 0], "mass_g": 300, "burn_s": 12}], "wind_m_s": [0.8, 0.1, 0],
                          "turbulence": 0.3, "age_s": 10, "voxel_m": 0.5, "seed": 3},
                "media": [{"density": "density", "extinction": 3, "albedo": )" +
         std::to_string(albedo) + R"(,
                           "phase": {"type": "henyey_greenstein", "g": 0.5}}], "source": 0.8}],
    "environment": {"sky": {"radiance": 0.4}, "sun": {"toward": [0.4, -0.5, 0.7], "irradiance": 2}},
    "sensor": {"position_m": [4, -30, 4], "look_at_m": [4, 0, 2], "fov_deg": 35, )" +
         kSensor;
}

}  // namespace

TEST_CASE("three methods agree on smoke puffs", "[agreement][puffs]") {
  check(verify_scene(parse_scene(puffs(0.8), "."), {.resolution = 0.05}));
}

TEST_CASE("puffs of another albedo are told apart", "[agreement][puffs]") {
  check_told_apart(parse_scene(puffs(0.8), "."), parse_scene(puffs(0.86), "."), {});
}

TEST_CASE("three methods agree on a periodic field of cumulus", "[agreement][rico]") {
  const auto file = shared_file("data/les_rico_jpl/rico32x37x26.txt");
  if (file.empty()) return;
  const std::string scene = R"({"obscura": 1, "bands": [{"name": "grey"}],
    "clouds": [{"grid": {"file": ")" +
                            file.string() + R"("},
                "media": [{"density": "lwc", "extinction": 0.1, "albedo": 0.99, "phase": {"type": "henyey_greenstein", "g": 0.7}}],
                "periodic": ["x", "y"]}],
    "environment": {"sky": {"radiance": 0.1}, "sun": {"zenith_deg": 30, "azimuth_deg": 200, "irradiance": 3}},
    "sensor": {"position_m": [300, -1500, 4000], "look_at_m": [320, 370, 900], "fov_deg": 40, )" +
                            std::string(kSensor);
  // Cells of ordinates are the field's own voxels, of some mean free paths: their error lets 10 % be seen.
  check(verify_scene(parse_scene(scene, "."), {.resolution = 0.2}));
}

TEST_CASE("three methods agree on a rough cloud with voids and a warm box inside", "[agreement][rough]") {
  // The box fills cells of the cloud's lattice: discrete ordinates know surfaces by the faces of their cells.
  const ScratchFolder folder("agreement");
  std::ofstream raw(folder / "rough.f32", std::ios::binary);
  for (int z = 0; z < kRoughSide; ++z) {
    for (int y = 0; y < kRoughSide; ++y) {
      for (int x = 0; x < kRoughSide; ++x) {
        const auto value = static_cast<float>(rough_density({x, y, z}));
        raw.write(reinterpret_cast<const char*>(&value), sizeof value);
      }
    }
  }
  raw.close();
  std::ofstream(folder / "rough.json") << R"({"raw": "rough.f32", "type": "float32", "resolution": [32, 32, 32],
    "order": "x-fastest", "voxel_m": [0.1, 0.1, 0.1], "origin_m": [0, 0, 0], "grid": "density"})";
  const std::string scene = R"({"obscura": 1, "bands": [{"name": "grey"}],
    "clouds": [{"grid": {"file": "rough.json"}, "source": 1.0,
                "media": [{"density": "density", "extinction": 3, "albedo": 0.8, "phase": {"type": "henyey_greenstein", "g": 0.3}}]}],
    "objects": [{"name": "box", "shape": "box", "size_m": [0.8, 0.8, 0.8], "material": "paint", "radiance": 3,
                 "place": {"translate_m": [1.6, 1.2, 1.6]}}],
    "materials": {"paint": {"emissivity": 0.6}},
    "environment": {"sky": {"radiance": 0.5}, "sun": {"toward": [0.3, -0.5, 0.8], "irradiance": 2}},
    "sensor": {"position_m": [1.6, -6, 3], "look_at_m": [1.6, 1.6, 1.5], "fov_deg": 36, )" +
                            std::string(kSensor);
  check(verify_scene(parse_scene(scene, folder.path()), {.resolution = 0.05}));
}
