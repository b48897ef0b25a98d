// The real bench on small scenes: what it measures is held against theory and brute force.
#include "scene/study/study_bench.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "octree/base/power_law.h"
#include "octree/base/statistics.h"
#include "scene/file/scene_io.h"

using namespace obscura;

namespace {

/// A grey cloud in sunlight.
const char* const kSunlit = R"({"obscura": 1, "bands": [{"name": "grey"}],
  "clouds": [{"grid": {"shape": "sphere", "radius_m": 1, "voxel_m": 0.25},
              "media": [{"extinction": 3, "albedo": 0.9, "phase": {"type": "henyey_greenstein", "g": 0.3}}]}],
  "environment": {"sky": {"radiance": 0.1}, "sun": {"toward": [1, -1, 1], "irradiance": 3}},
  "sensor": {"position_m": [0, -10, 0], "look_at_m": [0, 0, 0], "fov_deg": 13, "resolution": [48, 48], "max_oversampling": 4},
  "render": {"photons": 20000, "nearest": 32, "samples": 16}})";

SessionBench bench_of(const std::string& scene, int pixels = 12) {
  return SessionBench(parse_scene(scene, "."), pixels, StudyClock::system(), {});
}

ReferencePicture reference_of(SessionBench& bench, int passes, int samples) {
  StudySetting s = first_rung(bench.traits(), &kPathTracer);
  s.method.samples = samples;
  s.rays = 16;
  ReferencePicture reference;
  for (int p = 0; p < passes; ++p) reference.add(bench.measure(s, 5000 + static_cast<std::uint64_t>(p), {}).picture);
  return reference;
}

PictureError error_of(SessionBench& bench, const StudySetting& s, const ReferencePicture& reference, int count = 2) {
  std::vector<Picture> pictures;
  for (int p = 0; p < count; ++p) pictures.push_back(bench.measure(s, 10 + static_cast<std::uint64_t>(p), {}).picture);
  return picture_error(pictures, reference);
}

}  // namespace

TEST_CASE("the corrected error of paths falls with their number's root", "[study][bench]") {
  SessionBench bench = bench_of(kSunlit);
  CHECK(bench.describe().resolution == std::array<int, 2>{12, 12});
  CHECK(bench.describe().full_resolution == std::array<int, 2>{48, 48});
  // No better than the best of what is held against it.
  const ReferencePicture reference = reference_of(bench, 8, 64);
  std::vector<double> samples, errors, bars;
  for (const int n : {4, 16, 64, 256}) {
    StudySetting s = first_rung(bench.traits(), &kPathTracer);
    s.method.samples = n;
    s.rays = std::max(4, n / 4);
    const PictureError found = error_of(bench, s, reference);
    samples.push_back(n);
    errors.push_back(found.error.value());
    bars.push_back(found.error.error());
    CHECK(found.bias.square < 4 * found.bias.square_error);
  }
  const auto law = fit_power_law(samples, errors, bars);
  REQUIRE(law);
  CHECK(law->exponent_error < 0.1);
  CHECK(std::abs(law->exponent + 0.5) < 3 * law->exponent_error + 0.03);
}

TEST_CASE("bias and noise of few photons and a large k are those of many repetitions", "[study][bench]") {
  SessionBench bench = bench_of(kSunlit, 8);
  const ReferencePicture reference = reference_of(bench, 8, 128);
  StudySetting s = first_rung(bench.traits(), &kPhotonMap);
  s.method.photons = 10000;
  s.method.nearest = 3000;
  s.rays = 4;
  std::vector<Picture> pictures;
  for (std::uint64_t p = 0; p < 24; ++p) pictures.push_back(bench.measure(s, 10 + p, {}).picture);

  // Directly: the mean of all pictures less the reference, and their scatter about it.
  const std::vector<float>& truth = reference.values().bands[0];
  float largest = 0;
  for (const float v : truth) largest = std::max(largest, v);
  double bias2 = 0, noise2 = 0;
  for (std::size_t p = 0; p < truth.size(); ++p) {
    Moments pixel;
    for (const Picture& picture : pictures) pixel.add(picture.bands[0][p]);
    const double scale = std::max(truth[p], 0.05f * largest), off = pixel.mean() - truth[p];
    bias2 += (off * off - pixel.variance() / 24 - reference.variance(0, p)) / (scale * scale) /
             static_cast<double>(truth.size());
    noise2 += pixel.variance() / (scale * scale) / static_cast<double>(truth.size());
  }
  CHECK(bias2 > 0.03 * 0.03);

  Moments bias2_of_two, noise2_of_two;
  for (std::size_t pair = 0; pair < 12; ++pair) {
    const PictureError two = picture_error(std::span(pictures).subspan(2 * pair, 2), reference);
    bias2_of_two.add(two.bias.square);
    noise2_of_two.add(two.noise.square);
  }
  CHECK(std::abs(noise2_of_two.mean() - noise2) < 4 * noise2_of_two.standard_error());
  CHECK(std::abs(bias2_of_two.mean() - bias2) < 4 * bias2_of_two.standard_error());
  CHECK(bias2_of_two.standard_error() < 0.3 * bias2);
  CHECK(noise2_of_two.standard_error() < 0.4 * noise2);
}

TEST_CASE("times and memory are those of World, map and picture", "[study][bench]") {
  SessionBench bench = bench_of(kSunlit);
  StudySetting s = first_rung(bench.traits(), &kFinalGather);
  s.method.photons = 20000;
  const StudyPicture first = bench.measure(s, 1, {});
  CHECK(first.seconds.world.cpu > 0);
  CHECK(first.seconds.map.cpu > 0);
  CHECK(first.seconds.image.cpu > 0);
  CHECK(first.bytes.octree > 0);
  CHECK(first.bytes.map > 1000);
  // The same map serves another gathering, at the same price.
  s.method.nearest = 16;
  const StudyPicture second = bench.measure(s, 1, {});
  CHECK(second.seconds.map.cpu == first.seconds.map.cpu);
  CHECK(second.picture.bands[0] != first.picture.bands[0]);
  // Another seed's map is made and timed anew.
  CHECK(bench.measure(s, 2, {}).seconds.map.cpu != first.seconds.map.cpu);
  s.method.type = &kPathTracer;
  s.method.photons = 0;
  CHECK(bench.measure(s, 1, {}).bytes.map == 0);
}

TEST_CASE("settings as scene edits repeat the run", "[study][bench]") {
  const Description scene = parse_scene(kSunlit, ".", {{"/sensor/resolution", "[12, 12]"}});
  SessionBench bench(scene, 12, StudyClock::system(), {});
  for (const MethodType* method : {&kPhotonMap, &kFinalGather, &kPathTracer}) {
    StudySetting s = first_rung(bench.traits(), method);
    s.rays = 3;
    s.octree_tolerance = 0.01;
    std::vector<SceneEdit> edits = {{"/sensor/resolution", "[12, 12]"}, {"/render/seed", "5"}};
    for (const auto& [pointer, value] : scene_edits(s, {true})) edits.push_back({pointer, value});
    const Description edited = parse_scene(kSunlit, ".", edits);
    Session session(edited, 0);
    CHECK(bench.measure(s, 5, {}).picture.bands == picture_of(session.render().film).bands);
  }
}

TEST_CASE("a scene where nothing scatters has rays for a ladder, and nothing to gather", "[study][bench]") {
  const Description scene = parse_scene(R"({"obscura": 1, "bands": [{"name": "lwir", "um": [8, 12]}],
    "clouds": [{"grid": {"shape": "sphere", "radius_m": 1, "voxel_m": 0.25}, "media": [{"extinction": 1}], "temperature": {"K": 320}}],
    "environment": {"sky": {"K": 280}},
    "sensor": {"position_m": [0, -10, 0], "look_at_m": [0, 0, 0], "fov_deg": 13, "resolution": [12, 12]}, "render": {"photons": 2000}})",
                                        ".");
  StudySettings settings;
  settings.budget_s = 2.5;
  const Study study = run_study(scene, settings);
  CHECK(study.reference.picture.known());
  REQUIRE_FALSE(study.refusals.empty());
  CHECK(study.refusals[0].first == &kFinalGather);
  bool rays = false;
  for (const StudyRun& run : study.runs)
    rays = rays || (run.setting.method.type == &kPathTracer && run.setting.rays >= 16);
  CHECK(rays);
  CHECK(study.targets.front().run >= 0);
}

TEST_CASE("spectral intervals are a knob where optics vary within a band", "[study][bench]") {
  const char* const text = R"({"obscura": 1, "bands": [{"name": "lwir", "um": [8, 12]}],
    "clouds": [{"grid": {"shape": "box", "size_m": [8, 1, 8], "voxel_m": 0.5}, "media": [{"extinction": %s}], "temperature": {"K": 320}}],
    "sensor": {"position_m": [0, -10, 0], "look_at_m": [0, 0, 0], "projection": "orthographic", "width_m": 2, "resolution": [6, 6], "max_oversampling": 1}})";
  const auto knobs = [&](const std::string& extinction) {
    std::string scene = text;
    scene.replace(scene.find("%s"), 2, extinction);
    SessionBench bench = bench_of(scene);
    int count = 0;
    for (const StudyVariation& v : variations(bench.traits(), first_rung(bench.traits(), &kPathTracer)))
      count += v.knob == "intervals";
    return count;
  };
  CHECK(knobs("1") == 0);
  CHECK(knobs(R"({"um": [8, 12], "value": [0.1, 3]})") == 2);

  // One interval of so steep an extinction is wrong, and the study sees it as bias.
  std::string scene = text;
  scene.replace(scene.find("%s"), 2, R"({"um": [8, 12], "value": [0.1, 3]})");
  SessionBench bench = bench_of(scene);
  StudySetting s = first_rung(bench.traits(), &kPathTracer);
  s.intervals = 16;
  ReferencePicture reference;
  for (std::uint64_t p = 0; p < 4; ++p) reference.add(bench.measure(s, p, {}).picture);
  s.intervals = 1;
  const PictureError one = error_of(bench, s, reference);
  s.intervals = 4;
  const PictureError four = error_of(bench, s, reference);
  CHECK(one.bias.value() > 0.02);
  CHECK(four.bias.value() < 0.25 * one.bias.value());
}
