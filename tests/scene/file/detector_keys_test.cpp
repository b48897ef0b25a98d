// The keys of sensor/detector: each alone changes the picture as it says, and what cannot be is refused.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>

#include "octree/base/error.h"
#include "scene/file/scene_io.h"
#include "scene/run/run.h"
#include "tests/scene/full_scene.h"

using namespace obscura;
using obscura::test::Json;
using obscura::test::SceneFolder;

namespace {

// A uniform sky, but for a hot sphere of a few pixels.
Json scene_with(const Json& detector) {
  Json scene = Json::parse(R"({"obscura": 1, "bands": [{"name": "b", "um": [8, 12]}],
    "environment": {"sky": {"K": 300}}, "sources": [{"position_m": [0, 0, 0], "radius_m": 0.3, "K": 400}],
    "sensor": {"position_m": [0, -10, 0], "look_at_m": [0, 0, 0], "resolution": [48, 40], "max_oversampling": 1},
    "render": {"photons": 0}})");
  scene["sensor"]["detector"] = detector;
  return scene;
}

RunResult run(const Json& detector, const SceneFolder& folder) {
  return run_scene(parse_scene(scene_with(detector).dump(), folder.path()), {});
}

// Of the two ends of the picture, which the sphere does not reach.
double deviation(const Image& image, const std::string& channel) {
  const auto values = image.channel(channel);
  double sum = 0, sum2 = 0, n = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (i % 48 >= 12 && i % 48 < 36) continue;
    const auto value = static_cast<double>(values[i]);
    sum += value;
    sum2 += value * value;
    ++n;
  }
  return std::sqrt(std::max(0.0, sum2 / n - sum / n * sum / n));
}

std::vector<Problem> problems_of(const Json& scene, const std::filesystem::path& folder) {
  try {
    parse_scene(scene.dump(), folder);
    return {};
  } catch (const InputError& error) {
    return error.problems();
  }
}

}  // namespace

TEST_CASE("each key of the detector alone changes the picture as it says", "[scene][detector]") {
  const SceneFolder folder("detector_keys");
  const RunResult clean = run(Json::object(), folder);
  CHECK_FALSE(clean.image.has("b.detector"));
  CHECK(clean.report.detector.empty());
  const auto sharp = clean.image.channel("b.radiance");
  const double sky = static_cast<double>(sharp[0]);
  const std::size_t middle = 20 * 48 + 24;

  for (const Json& blur : {Json{{"psf_sigma_px", 3}}, Json{{"psf_file", "psf.pgm"}}}) {
    INFO(blur.dump());
    const Image image = run(blur, folder).image;
    const auto signal = image.channel("b.detector");
    CHECK(std::equal(sharp.begin(), sharp.end(), image.channel("b.radiance").begin()));
    double before = 0, after = 0;
    for (std::size_t i = 0; i < signal.size(); ++i) {
      before += static_cast<double>(sharp[i]);
      after += static_cast<double>(signal[i]);
    }
    CHECK(after == Approx(before).epsilon(1e-6));
    CHECK(static_cast<double>(signal[0]) == Approx(sky).epsilon(1e-6));
    CHECK(*std::max_element(signal.begin(), signal.end()) <= *std::max_element(sharp.begin(), sharp.end()));
    CHECK_FALSE(std::equal(sharp.begin(), sharp.end(), signal.begin()));
  }

  const double noise = deviation(run({{"nedt_K", 0.5}}, folder).image, "b.detector");
  CHECK(deviation(run({{"nedt_K", 0.5}}, folder).image, "b.detector_temperature") == Approx(0.5).epsilon(0.1));
  CHECK(deviation(run({{"nedt_K", 1}}, folder).image, "b.detector") == Approx(2 * noise).epsilon(1e-5));
  const Band band("b", 8, 12);
  CHECK(deviation(run({{"nedt_K", 0.5}, {"nedt_at_K", 350}}, folder).image, "b.detector") ==
        Approx(noise * band.planck_derivative(350) / band.planck_derivative(300)).epsilon(1e-4));
  CHECK(deviation(run({{"ner", 0.2}}, folder).image, "b.detector") == Approx(0.2).epsilon(0.1));
  const Json longer = {{"ner", 0.2}, {"integration_s", 0.09}, {"reference_integration_s", 0.01}};
  CHECK(deviation(run(longer, folder).image, "b.detector") ==
        Approx(deviation(run({{"ner", 0.2}}, folder).image, "b.detector") / 3).epsilon(1e-4));

  const RunResult dead = run({{"dead_share", 0.1}}, folder);
  CHECK(static_cast<double>(dead.report.detector[0].second.dead) == Approx(192).margin(60));
  const auto holes = dead.image.channel("b.detector");
  CHECK(static_cast<std::uint64_t>(std::count(holes.begin(), holes.end(), 0.0f)) ==
        dead.report.detector[0].second.dead);
  CHECK(run({{"dead_share", 0.1}, {"seed", 1}}, folder).image.channel("b.detector")[7] == holes[7]);  // the render's
  const Image other = run({{"dead_share", 0.1}, {"seed", 2}}, folder).image;
  CHECK_FALSE(std::equal(holes.begin(), holes.end(), other.channel("b.detector").begin()));
  CHECK(deviation(run({{"gain_nonuniformity", 0.02}}, folder).image, "b.detector") == Approx(0.02 * sky).epsilon(0.1));
  CHECK(deviation(run({{"offset_nonuniformity", 0.3}}, folder).image, "b.detector") == Approx(0.3).epsilon(0.1));

  CHECK(static_cast<double>(run({{"gain", 2}}, folder).image.channel("b.detector")[0]) ==
        Approx(2 * sky).epsilon(1e-6));
  CHECK(static_cast<double>(run({{"offset", 3}}, folder).image.channel("b.detector")[0]) ==
        Approx(sky + 3).epsilon(1e-6));

  const RunResult counts = run({{"bits", 8}, {"range", {0, 50}}}, folder);
  CHECK(static_cast<double>(counts.image.channel("b.counts")[0]) == std::round(sky / 50 * 255));
  CHECK(counts.image.channel("b.counts")[middle] == 255);
  CHECK(counts.report.detector[0].second.above_range > 0);
  CHECK(counts.report.detector[0].second.below_range == 0);
  REQUIRE(counts.report.warnings.size() == 1);
  CHECK(counts.report.warnings[0].find("cuts") != std::string::npos);
  CHECK(static_cast<double>(run({{"bits", 10}, {"range", {0, 50}}}, folder).image.channel("b.counts")[0]) ==
        std::round(sky / 50 * 1023));
  CHECK(static_cast<double>(run({{"bits", 8}, {"range", {0, 100}}}, folder).image.channel("b.counts")[0]) ==
        std::round(sky / 100 * 255));
  CHECK(run({{"bits", 8}}, folder).image.channel("b.counts")[0] == 255);  // the range is [0, 1]
}

TEST_CASE("a band may have settings of its own", "[scene][detector]") {
  const SceneFolder folder("detector_bands");
  Json scene = scene_with({{"nedt_K", 0.1}, {"bits", 12}, {"range", {0, 100}}});
  scene["bands"] = Json::parse(R"([{"name": "b", "um": [8, 12]}, {"name": "c", "um": [3, 5]}, {"name": "g"}])");
  scene["environment"]["sky"]["radiance"] = 2;
  scene["sources"] = Json::array();
  const auto grey = problems_of(scene, folder.path());
  REQUIRE(grey.size() == 1);
  CHECK(grey[0].where == "/sensor/detector/nedt_K");
  scene["sensor"]["detector"]["bands"] =
      Json::parse(R"({"c": {"range": [0, 4], "nedt_K": 0.3, "gain": 1.5, "offset": 0.5},
                                                        "g": {"ner": 0.25, "psf_sigma_px": 1}})");
  const Image image = run_scene(parse_scene(scene.dump(), folder.path()), {}).image;
  const double b = Band("b", 8, 12).planck(300), c = Band("c", 3, 5).planck(300);
  CHECK(deviation(image, "b.detector_temperature") == Approx(0.1).epsilon(0.1));
  CHECK(deviation(image, "c.detector_temperature") == Approx(0.3).epsilon(0.1));
  CHECK(deviation(image, "g.detector") == Approx(0.25).epsilon(0.1));
  const auto mean = [&](const std::string& channel) {
    double sum = 0;
    for (const float value : image.channel(channel)) sum += static_cast<double>(value);
    return sum / static_cast<double>(image.pixel_count());
  };
  CHECK(mean("b.counts") == Approx(b / 100 * 4095).epsilon(1e-3));
  CHECK(mean("c.counts") == Approx((1.5 * c + 0.5) / 4 * 4095).epsilon(1e-3));
  CHECK(mean("g.counts") == Approx(2.0 / 100 * 4095).epsilon(1e-2));
  scene["sensor"]["detector"]["bands"]["g"] = {{"nedt_K", 0.1}};
  const auto wrong = problems_of(scene, folder.path());
  REQUIRE(wrong.size() == 1);
  CHECK(wrong[0].where == "/sensor/detector/bands/g/nedt_K");
}

TEST_CASE("what a detector cannot be is refused with its place", "[scene][detector][reader]") {
  const SceneFolder folder("detector_refused");
  folder.write("even.pgm", "P2 2 1 255 1 1\n");
  folder.write("text.png", "this is a letter");
  struct Wrong {
    Json detector;
    std::string where, says;
  };
  const std::vector<Wrong> list = {{{{"psf_sigma_px", -1}}, "psf_sigma_px", "out of range"},
                                   {{{"psf_sigma_px", 1}, {"psf_file", "psf.pgm"}}, "psf_file", "both given"},
                                   {{{"psf_file", "absent.png"}}, "psf_file", "no such file"},
                                   {{{"psf_file", "even.pgm"}}, "psf_file", "odd sides"},
                                   {{{"psf_file", "text.png"}}, "psf_file", "cannot be read as a point spread"},
                                   {{{"nedt_K", -0.1}}, "nedt_K", "out of range"},
                                   {{{"nedt_at_K", 0}}, "nedt_at_K", "above 0"},
                                   {{{"nedt_K", 0.1}, {"ner", 1}}, "ner", "both given"},
                                   {{{"ner", 1}, {"integration_s", 1}}, "reference_integration_s", "is missing"},
                                   {{{"ner", 1}, {"reference_integration_s", 1}}, "integration_s", "is missing"},
                                   {{{"integration_s", 0}, {"reference_integration_s", 1}}, "integration_s", "above 0"},
                                   {{{"dead_share", 1.1}}, "dead_share", "from 0 to 1"},
                                   {{{"gain_nonuniformity", 2}}, "gain_nonuniformity", "from 0 to 1"},
                                   {{{"offset_nonuniformity", -1}}, "offset_nonuniformity", "out of range"},
                                   {{{"gain", 0}}, "gain", "above 0"},
                                   {{{"offset", "much"}}, "offset", "expected a number"},
                                   {{{"bits", 17}}, "bits", "from 0 to 16"},
                                   {{{"bits", 2.5}}, "bits", "whole number"},
                                   {{{"range", {1, 0}}}, "range/1", "increase"},
                                   {{{"range", {1, 1}}}, "range/1", "increase"},
                                   {{{"bands", {{"c", {{"gain", 2}}}}}}, "bands/c", "there is no band \"c\""},
                                   {{{"bands", {{"b", {{"bits", 2}}}}}}, "bands/b/bits", "unknown key"},
                                   {{{"bands", {{"b", {{"range", {2, 1}}}}}}}, "bands/b/range/1", "increase"},
                                   {{{"bands", {{"b", {{"nedt_K", 1}, {"ner", 1}}}}}}, "bands/b/ner", "both given"},
                                   {{{"seed", -1}}, "seed", "out of range"}};
  for (const Wrong& wrong : list) {
    const auto problems = problems_of(scene_with(wrong.detector), folder.path());
    INFO(wrong.detector.dump());
    REQUIRE(problems.size() == 1);
    INFO(problems[0].text());
    CHECK(problems[0].where == "/sensor/detector/" + wrong.where);
    CHECK(problems[0].text().find(wrong.says) != std::string::npos);
    CHECK_FALSE(problems[0].hint.empty());
  }
}

TEST_CASE("a grey band has noise by radiance, not by kelvin", "[scene][detector][grey]") {
  const SceneFolder folder("detector_grey");
  Json scene = Json::parse(R"({"obscura": 1, "bands": [{"name": "g"}], "environment": {"sky": {"radiance": 2}},
    "sensor": {"position_m": [0, -10, 0], "look_at_m": [0, 0, 0], "resolution": [40, 40], "detector": {"nedt_K": 0.1}}})");
  const auto problems = problems_of(scene, folder.path());
  REQUIRE(problems.size() == 1);
  CHECK(problems[0].where == "/sensor/detector/nedt_K");
  CHECK(problems[0].text().find("grey band \"g\"") != std::string::npos);
  scene["sensor"]["detector"] = {{"ner", 0.1}};
  const RunResult result = run_scene(parse_scene(scene.dump(), folder.path()), {});
  CHECK(deviation(result.image, "g.detector") == Approx(0.1).epsilon(0.1));
  CHECK_FALSE(result.image.has("g.detector_temperature"));
}

TEST_CASE("settings of a detector that change nothing are warned of", "[scene][detector]") {
  const SceneFolder folder("detector_warnings");
  CHECK(parse_scene(scene_with({{"integration_s", 1}, {"reference_integration_s", 1}}).dump(), folder.path())
            .warnings.size() == 1);
  CHECK(parse_scene(scene_with({{"range", {0, 5}}}).dump(), folder.path()).warnings.size() == 1);
  CHECK(parse_scene(scene_with({{"range", {0, 5}}, {"bits", 8}}).dump(), folder.path()).warnings.empty());
}
