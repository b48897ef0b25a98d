// The verdict: right scenes pass, and a mistake in what one method is given is found by the others.
#include "scene/verify/verify.h"

#include <algorithm>
#include <atomic>
#include <catch2/catch.hpp>
#include <cstdio>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "octree/base/error.h"
#include "scene/file/scene_io.h"
#include "scene/session/session.h"

using namespace obscura;

namespace {

/// The referees in the order of their numbers.
constexpr std::size_t kPhoton = 0, kPath = 1;

const VerifyCase& case_of(const std::string& name) {
  const auto found =
      std::find_if(verify_cases().begin(), verify_cases().end(), [&](const VerifyCase& c) { return c.name == name; });
  REQUIRE(found != verify_cases().end());
  return *found;
}

/// A case with less work in it, for tests of every build.
Description small(const std::string& name, int photons = 60000, int samples = 32) {
  return parse_scene(case_of(name).scene, ".",
                     {{"/render/photons", std::to_string(photons)}, {"/render/samples", std::to_string(samples)}},
                     name);
}

/// What somebody may get wrong in a method.
struct Mistake {
  const char* name;
  std::function<void(Description&)> make;
};

void each_medium(Description& scene, const std::function<void(MediumDescription&)>& change) {
  for (CloudDescription& cloud : scene.clouds) {
    for (MediumDescription& medium : cloud.media) change(medium);
  }
}

const std::vector<Mistake>& mistakes() {
  static const std::vector<Mistake> all = {
      {"albedo x 1.02",
       [](Description& scene) {
         each_medium(scene, [](MediumDescription& m) { m.albedo = Spectrum::constant(1.02 * m.albedo.value(1)); });
       }},
      {"g + 0.05",
       [](Description& scene) {
         each_medium(scene, [](MediumDescription& m) {
           m.phase = PhaseFunction::henyey_greenstein(m.phase.mean_cosine() + 0.05);
         });
       }},
      {"scattering reversed",
       [](Description& scene) {
         each_medium(scene,
                     [](MediumDescription& m) { m.phase = PhaseFunction::henyey_greenstein(-m.phase.mean_cosine()); });
       }},
      {"sun reversed",
       [](Description& scene) {
         if (scene.sun) scene.sun->toward = -scene.sun->toward;
       }},
      {"no sun", [](Description& scene) { scene.sun.reset(); }},
      {"no sky", [](Description& scene) { scene.sky.reset(); }},
      {"no emission",
       [](Description& scene) {
         for (CloudDescription& cloud : scene.clouds) cloud.temperature.reset();
       }},
  };
  return all;
}

const Mistake& mistake_of(const std::string& name) {
  const auto found =
      std::find_if(mistakes().begin(), mistakes().end(), [&](const Mistake& m) { return name == m.name; });
  REQUIRE(found != mistakes().end());
  return *found;
}

VerifyMethod find_out(const Description& scene, std::size_t method, const VerifySettings& settings) {
  Session session(scene, scene.time_s);
  return run_method(session, referees(session)[method], settings);
}

/// A case solved by all methods as it is; each mistake then costs one more run of one method.
class Trial {
 public:
  Trial(Description scene, const VerifySettings& settings) : scene_(std::move(scene)), settings_(settings) {
    for (std::size_t method = 0; method < method_words().size(); ++method)
      right_.push_back(find_out(scene_, method, settings_));
  }
  VerifiedScene right() const { return compare_methods(scene_, right_, settings_); }
  VerifiedScene wrong(std::size_t method, const Mistake& mistake) const {
    Description scene = scene_;
    mistake.make(scene);
    std::vector<VerifyMethod> methods = right_;
    methods[method] = find_out(scene, method, settings_);
    return compare_methods(scene_, methods, settings_);
  }
  bool has(std::size_t method) const { return right_[method].refusal.empty(); }

 private:
  Description scene_;
  VerifySettings settings_;
  std::vector<VerifyMethod> right_;
};

std::string text_of(const std::vector<std::string>& sentences) {
  std::string text;
  for (const std::string& sentence : sentences) text += sentence + "\n";
  return text;
}

/// Whether all failures name the method: no comparison of the two others fails.
bool blames(const VerifiedScene& scene, std::size_t method) {
  for (const VerifyRow& row : scene.rows) {
    for (const VerifyPair& pair : row.pairs) {
      if (!pair.agreement.agree && pair.first != method && pair.second != method) return false;
    }
  }
  return true;
}

VerifySettings quick() {
  VerifySettings settings;
  settings.passes = 2;
  settings.scenes = 14;
  return settings;
}

}  // namespace

TEST_CASE("every case is a scene that a user can print and read", "[scene][verify]") {
  std::set<std::string> names;
  for (const VerifyCase& c : verify_cases()) {
    INFO(c.name);
    CHECK(names.insert(c.name).second);
    const Description scene = parse_scene(c.scene, ".");
    CHECK(scene.name == c.name);
    CHECK(scene.warnings.empty());
    CHECK(scene.probes.size() == 2);
    CHECK(scene.flux.size() == 1);
    CHECK(c.resolution > 0);
    for (const CloudDescription& cloud : scene.clouds) {
      CHECK(cloud.temperature.has_value() == !scene.sun.has_value());
      for (const MediumDescription& medium : cloud.media) CHECK(medium.albedo.value(10) > 0);
    }
  }
  for (const char* shape : {"sphere", "cube", "slab", "two_layer", "checkerboard", "gaussian", "puffs"}) {
    CHECK(names.count(shape + std::string("_night")) == 1);
    CHECK(names.count(shape + std::string("_day")) == 1);
  }
}

TEST_CASE("each planted mistake is found in each method", "[scene][verify]") {
  // The case that sees it best.
  const std::map<std::string, std::vector<std::string>> where = {
      {"slab_night", {"no emission"}},
      {"slab_day", {"albedo x 1.02", "g + 0.05", "scattering reversed", "sun reversed", "no sun", "no sky"}}};
  for (const auto& [name, list] : where) {
    const Trial trial(small(name), quick());
    INFO(name);
    CHECK(text_of(trial.right().failures()).empty());
    for (const std::string& mistake : list) {
      for (std::size_t method = 0; method < method_words().size(); ++method) {
        if (!trial.has(method)) continue;
        const VerifiedScene verdict = trial.wrong(method, mistake_of(mistake));
        INFO(mistake << " in " << method_words()[method]);
        CHECK_FALSE(verdict.failures().empty());
        CHECK(blames(verdict, method));
      }
    }
  }
}

TEST_CASE("right scenes pass whatever the seed, as the program runs them", "[.verify_full]") {
  for (const VerifyCase& c : verify_cases()) {
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
      VerifySettings settings;
      settings.seed = seed;
      settings.resolution = c.resolution;
      settings.scenes = static_cast<int>(verify_cases().size());
      INFO(c.name << " seed " << seed);
      CHECK(text_of(verify_scene(parse_scene(c.scene, "."), settings).failures()).empty());
    }
  }
}

TEST_CASE("which mistakes each case finds, as the program runs them", "[.verify_full]") {
  std::map<std::string, std::set<std::string>> finders;
  for (const VerifyCase& c : verify_cases()) {
    VerifySettings settings;
    settings.scenes = static_cast<int>(verify_cases().size());
    const Trial trial(parse_scene(c.scene, "."), settings);
    for (const Mistake& mistake : mistakes()) {
      std::string found;
      for (std::size_t method = 0; method < method_words().size(); ++method) {
        if (!trial.has(method)) continue;
        const VerifiedScene verdict = trial.wrong(method, mistake);
        found += "  " + std::string(method_words()[method]) + ": " +
                 (verdict.failures().empty() ? "-" : std::to_string(verdict.failures().size()));
        if (!verdict.failures().empty())
          finders[mistake.name + std::string(" in ") + method_words()[method]].insert(c.name);
      }
      std::printf("%-20s %-20s %s\n", c.name.c_str(), mistake.name, found.c_str());
      std::fflush(stdout);
    }
  }
  for (const Mistake& mistake : mistakes()) {
    for (std::size_t method = 0; method < method_words().size(); ++method) {
      INFO(mistake.name << " in " << method_words()[method]);
      CHECK_FALSE(finders[mistake.name + std::string(" in ") + method_words()[method]].empty());
    }
  }
}

TEST_CASE("a comparison too weak for its resolution fails where one is demanded", "[scene][verify]") {
  VerifySettings settings;
  settings.passes = 1;
  Description scene = small("slab_night", 2000, 16);
  scene.flux.clear();
  scene.sensor.resolution = {12, 12};
  CHECK(verify_scene(scene, settings).failures().empty());
  settings.resolution = 1e-3;
  const std::string failures = text_of(verify_scene(scene, settings).failures());
  CHECK(failures.find("too weak") != std::string::npos);
}

TEST_CASE("where nothing could be judged verify says how many samples would do", "[scene][verify]") {
  VerifySettings settings;
  settings.passes = 1;
  Description scene = small("slab_day", 100000, 1);
  scene.flux.clear();
  scene.probes.clear();
  scene.sensor.resolution = {2, 2};
  scene.sensor.max_oversampling = 1;
  // Without the ordinates, which know.
  Session session(scene, 0, {}, 0);
  std::vector<VerifyMethod> found;
  for (const Method& method : referees(session)) {
    if (!method.type->cells) found.push_back(run_method(session, method, settings));
  }
  const VerifiedScene weak = compare_methods(scene, std::move(found), settings);
  CHECK(weak.comparisons() > 0);
  const std::string failures = text_of(weak.failures());
  CAPTURE(failures, verify_table({weak}));
  CHECK(failures.find("nothing could be judged") != std::string::npos);
  CHECK(failures.find("times as many samples") != std::string::npos);
  CHECK(verify_table({weak}).find("not judged: ") != std::string::npos);
  // With enough of them it judges.
  Description more = small("slab_day", 20000, 64);
  more.flux.clear();
  more.sensor.resolution = {12, 12};
  const VerifiedScene strong = verify_scene(more, settings);
  CHECK(strong.failures().empty());
  CHECK(strong.judged() > 0);
}

TEST_CASE("edges of a box before a sky by default settings are within the errors", "[scene][verify]") {
  const std::string box = R"({"obscura": 1, "bands": [{"name": "b"}], "objects": [{"shape": "box", "size_m": [1, 1, 1],
    "radiance": 1.0, "place": {"rotate_deg": [0, 20, 30]}}], "environment": {"sky": {"radiance": 0.3}},
    "sensor": {"position_m": [0, -10, 0], "look_at_m": [0, 0, 0], "fov_deg": 12, "resolution": [48, 48]}})";
  const VerifiedScene verdict = verify_scene(parse_scene(box, "."), {});
  CHECK(verdict.failures().empty());
  CHECK(verdict.judged() > 3);
  // The disc of a sun in view has edges too, and pixels beside it do not.
  const std::string sun = R"({"obscura": 1, "bands": [{"name": "b"}], "clouds": [{"grid": {"shape": "box",
    "size_m": [100, 100, 10], "voxel_m": 5}, "media": [{"extinction": 0.01, "albedo": 1.0}]}],
    "environment": {"sky": {"radiance": 0.02}, "sun": {"toward": [0, 0, 1], "irradiance": 1}},
    "sensor": {"position_m": [0, 0, -20], "look_at_m": [0, 0, 0], "up": [0, 1, 0], "fov_deg": 1.5, "resolution": [48, 48]}})";
  const VerifiedScene in_view = verify_scene(parse_scene(sun, "."), {});
  CHECK(in_view.failures().empty());
  for (const VerifyRow& row : in_view.rows) {
    if (row.quantity != "x 0-15 y 0-15") continue;
    for (const auto& measured : row.measured) {
      REQUIRE(measured);
      CHECK(measured->value == Approx(0.0284).epsilon(0.03));
      CHECK(measured->error < 0.01 * measured->value);
    }
  }
}

TEST_CASE("the same seed gives the same numbers, another seed others", "[scene][verify]") {
  Description scene = small("cube_day", 3000, 16);
  scene.sensor.resolution = {12, 12};
  VerifySettings settings;
  settings.passes = 2;
  const auto numbers = [&](std::uint64_t seed) {
    settings.seed = seed;
    std::vector<double> all;
    for (const std::size_t method : {kPhoton, kPath}) {
      for (const auto& measured : find_out(scene, method, settings).values) all.push_back(measured->value);
    }
    return all;
  };
  const auto first = numbers(1);
  CHECK(first == numbers(1));
  CHECK(first != numbers(2));
}

TEST_CASE("a method that cannot serve a scene is left out and says why", "[scene][verify]") {
  VerifySettings settings;
  settings.passes = 1;
  Description scene = small("slab_day", 2000, 16);
  scene.probes.clear();
  scene.flux.clear();
  scene.hot_spheres.push_back({"lamp", Vec3d(0, 0, 2), 0.1, std::nullopt, Spectrum::constant(1)});
  const VerifiedScene verdict = verify_scene(scene, settings);
  CHECK_FALSE(verdict.method("photon").refusal.empty());
  CHECK(verdict.method("ordinates").refusal.find("hot spheres") != std::string::npos);
  CHECK(verdict.method("path").refusal.empty());
  CHECK(text_of(verdict.failures()).find("nothing could be compared") != std::string::npos);
  CHECK(verify_table({verdict}).find("without photon: ") != std::string::npos);
}

TEST_CASE("cancelled it compares nothing and says so", "[scene][verify]") {
  std::atomic<bool> stop{true};
  const VerifiedScene verdict = verify_scene(small("cube_day"), {}, Progress(nullptr, &stop));
  CHECK(verdict.partial);
  CHECK(verdict.comparisons() == 0);
  CHECK(verify_table({verdict}).find("stopped") != std::string::npos);
}

TEST_CASE("a large picture is made smaller, not another view", "[scene][verify]") {
  Description scene = small("cube_day");
  scene.sensor.resolution = {640, 280};
  shrink_picture(scene, 48);
  CHECK(scene.sensor.resolution == std::array<int, 2>{48, 21});
  shrink_picture(scene, 48);
  CHECK(scene.sensor.resolution == std::array<int, 2>{48, 21});
  scene.sensor.resolution = {1, 1000};
  shrink_picture(scene, 10);
  CHECK(scene.sensor.resolution == std::array<int, 2>{1, 10});
}

TEST_CASE("table, JSON and page tell the same verdict", "[scene][verify]") {
  VerifySettings settings;
  settings.passes = 1;
  Description scene = small("slab_night", 2000, 16);
  scene.sensor.resolution = {20, 20};
  scene.name = "a <cube> & more";
  Description dark = scene;
  dark.sky.reset();
  std::vector<VerifyMethod> methods;
  for (std::size_t method = 0; method < method_words().size(); ++method)
    methods.push_back(find_out(method == kPath ? dark : scene, method, settings));
  const VerifiedScene good = verify_scene(scene, settings), bad = compare_methods(scene, methods, settings);
  REQUIRE(good.failures().empty());
  REQUIRE_FALSE(bad.failures().empty());

  const std::string table = verify_table({good, bad});
  CHECK(table.find("DIFFER a <cube> & more: mean: photon and path differ by") != std::string::npos);
  for (const char* word :
       {"case", "photon-path z", "photon bias", "fluence middle", "flux below forward", "x 16-19 y 0-15", "seconds"}) {
    CHECK(table.find(word) != std::string::npos);
  }

  const auto json = nlohmann::json::parse(verify_json({good, bad}));
  CHECK(json["agree"] == false);
  CHECK(json["scenes"][0]["agree"] == true);
  CHECK(json["scenes"][1]["agree"] == false);
  CHECK(json["scenes"][0]["quantities"].size() == good.rows.size());
  CHECK(json["scenes"][0]["quantities"][0]["path"]["value"].get<double>() == good.rows[0].measured[1]->value);

  const auto file = std::filesystem::temp_directory_path() / "obscura_verify_test.html";
  write_verify_html(file, {good, bad});
  const std::string page = [&] {
    std::string text;
    std::FILE* stream = std::fopen(file.c_str(), "rb");
    REQUIRE(stream);
    char buffer[4096];
    for (std::size_t n; (n = std::fread(buffer, 1, sizeof buffer, stream)) > 0;) text.append(buffer, n);
    std::fclose(stream);
    return text;
  }();
  std::filesystem::remove(file);
  CHECK(page.find("a &lt;cube&gt; &amp; more") != std::string::npos);
  CHECK(page.find("<cube>") == std::string::npos);
  CHECK(page.find("data:image/png;base64,iVBORw0KGgo") != std::string::npos);
  for (const char* outside : {"http://", "https://", "<script", "<link", "url("})
    CHECK(page.find(outside) == std::string::npos);
  const auto count = [&](const std::string& part) {
    std::size_t n = 0;
    for (std::size_t at = page.find(part); at != std::string::npos; at = page.find(part, at + 1)) ++n;
    return n;
  };
  for (const char* tag : {"html", "head", "body", "style", "div", "table", "tr", "td", "ul", "li", "p", "h2"}) {
    INFO(tag);
    CHECK(count("<" + std::string(tag) + ">") + count("<" + std::string(tag) + " ") ==
          count("</" + std::string(tag) + ">"));
  }
  CHECK_THROWS_AS(write_verify_html("/absent/folder/a.html", {good}), ResourceError);
}
