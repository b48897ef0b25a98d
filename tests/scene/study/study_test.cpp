// A study by a bench that only pretends to compute, whose errors and times are known, with a clock of its own.
#include "scene/study/study.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <regex>
#include <set>
#include <sstream>

#include "octree/base/error.h"
#include "octree/base/random.h"
#include "scene/study/study_bench.h"
#include "tests/support/scratch_folder.h"

using namespace obscura;

namespace {

using Json = nlohmann::json;

/// Errors: path noise 0.4 / sqrt(samples); photon map bias 20 / photons^(2/3) x nearest^(2/3) and noise 0.5 /
/// sqrt(nearest); final gather both, smaller. Times are proportional to the work. Every pixel has the same error.
class PretendedBench final : public StudyBench {
 public:
  explicit PretendedBench(const MethodType* given = &kFinalGather) {
    traits_.given.method.type = given;
    traits_.given.method.photons = 1000000;
    traits_.given.method.nearest = 64;
    traits_.given.method.samples = 64;
    traits_.given.rays = 8;
  }

  Study describe() const override {
    Study study;
    study.scene = "pretended <scene>";
    study.resolution = {16, 12};
    study.full_resolution = {160, 120};
    study.bands = {"lwir"};
    study.grey = {false};
    return study;
  }
  const StudyTraits& traits() const override { return traits_; }

  StudyPicture measure(const StudySetting& s, std::uint64_t seed, const Progress& progress) override {
    if (refused.contains(s.method.type)) throw NumericalError("pretended", refused.at(s.method.type));
    const auto [bias, noise] = errors(s);
    StudyPicture result;
    result.seconds.world.wall = result.seconds.world.cpu = 1;
    // The path tracer's reference is no other seed's.
    Stream random(seed, index_of(*s.method.type), 0);
    result.picture = {16, 12, {{}}};
    for (int p = 0; p < 16 * 12; ++p) {
      double normal = -6;
      for (int k = 0; k < 12; ++k) normal += random.uniform();
      result.picture.bands[0].push_back(static_cast<float>((2 + std::sin(0.2 * p)) * (1 + bias + noise * normal)));
    }
    if (s.method.photons > 0)
      result.seconds.map = {1e-6 * static_cast<double>(s.method.photons),
                            0.5e-6 * static_cast<double>(s.method.photons)};
    const double image =
        s.method.type->cells ? 1e-6 * std::pow(s.method.cells, 3) : 1e-3 * std::max(s.method.samples, s.method.nearest);
    result.seconds.image = {2 * image, image};
    pass(result.seconds.map.wall + image, progress);
    result.bytes = {1e6, 24.0 * static_cast<double>(s.method.photons), 1000};
    asked.push_back(s);
    if (s.method.type->cells) {
      result.errors = result.picture;
      for (float& e : result.errors->bands[0]) e = 0.01f;
    }
    return result;
  }
  static std::pair<double, double> errors(const StudySetting& s) {
    const double k = s.method.nearest, photons = static_cast<double>(s.method.photons);
    if (s.method.type == &kPhotonMap) return {std::pow(k / photons, 2.0 / 3) * 20, 0.5 / std::sqrt(k)};
    if (s.method.type == &kFinalGather) return {std::pow(k / photons, 2.0 / 3), 0.2 / std::sqrt(s.method.samples)};
    if (s.method.type == &kPathTracer) return {0, 0.4 / std::sqrt(s.method.samples)};
    return {1.0 / (s.method.cells * s.method.cells), 1e-4};
  }

  StudyClock clock() {
    return {[this] { return now_s; }, [this] { return 2 * now_s; }};
  }

  double now_s = 100;
  std::map<const MethodType*, std::string> refused;
  std::vector<StudySetting> asked;
  double interrupt_s = 1e9;  ///< when the user presses Ctrl-C
  std::atomic<bool> interrupted{false};

 private:
  void pass(double seconds, const Progress& progress) {
    for (int step = 0; step < 10; ++step) {
      now_s += seconds / 10;
      if (now_s >= interrupt_s) interrupted = true;
      progress.report("pretended", static_cast<std::uint64_t>(step), 10);
      if (progress.cancelled()) return;
    }
  }
  StudyTraits traits_;
};

Study study_of(PretendedBench& bench, double budget_s, double interrupt_s = 1e9) {
  StudySettings settings;
  settings.budget_s = budget_s;
  settings.clock = bench.clock();
  bench.interrupt_s = bench.now_s + interrupt_s;
  return run_study(bench, settings, Progress(nullptr, &bench.interrupted));
}

int reached(const Study& study) {
  return static_cast<int>(
      std::count_if(study.targets.begin(), study.targets.end(), [](const StudyTarget& t) { return t.run >= 0; }));
}

bool has(const Study& study, const MethodType* method) {
  return std::any_of(study.runs.begin(), study.runs.end(),
                     [&](const StudyRun& r) { return r.setting.method.type == method; });
}

std::string page_of(const Study& study) {
  const test::ScratchFolder folder("study");
  const auto file = folder / "study.html";
  write_study_html(file, study);
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

}  // namespace

TEST_CASE("a study keeps its budget and spends it", "[study]") {
  for (const double budget : {5.0, 20.0, 80.0}) {
    PretendedBench bench;
    const double begin = bench.now_s;
    const Study study = study_of(bench, budget);
    CAPTURE(budget, study.runs.size());
    CHECK(bench.now_s - begin <= 1.03 * budget + 1.1);
    CHECK(study.spent_s > 0.5 * budget);
    CHECK_FALSE(study.partial);
    CHECK(study.reference.picture.known());
    // About a third for the reference.
    CHECK(study.reference.seconds.wall > 0.15 * budget);
    CHECK(study.reference.seconds.wall < 0.6 * budget);
    for (const MethodType* method : methods()) CHECK(has(study, method));
  }
}

TEST_CASE("cheap runs of all methods come first", "[study]") {
  PretendedBench bench;
  const Study study = study_of(bench, 60);
  // The first run of the last method comes before a hundredth of the time has gone into any single run.
  double largest = 0;
  std::set<const MethodType*> seen;
  for (const StudyRun& run : study.runs) {
    seen.insert(run.setting.method.type);
    largest = std::max(largest, run.seconds.map.wall + run.seconds.image.wall);
    if (seen.size() == methods().size()) break;
  }
  CHECK(seen.size() == methods().size());
  CHECK(largest < 0.01 * 60);
  // Rungs of each ladder in order of their cost.
  for (const MethodType* method : methods()) {
    double last = 0;
    for (const StudyRun& run : study.runs) {
      if (run.setting.method.type != method || run.purpose != "ladder") continue;
      CHECK(run.seconds.cpu() > last);
      last = run.seconds.cpu();
    }
  }
}

TEST_CASE("whenever it is stopped, a study leaves what it has, and more with more time", "[study]") {
  int before = 0;
  for (const double stop : {0.005, 1.0, 3.0, 10.0, 30.0, 60.0}) {
    PretendedBench bench;
    const double begin = bench.now_s;
    const Study study = study_of(bench, 80, stop);
    CAPTURE(stop);
    CHECK(study.partial == (study.spent_s >= stop));
    CHECK(bench.now_s - begin <= stop + 3);
    CHECK_NOTHROW(Json::parse(study_json(study)));
    CHECK_FALSE(page_of(study).empty());
    if (stop < 3) continue;
    CHECK(study.reference.picture.known());
    for (const MethodType* method : methods()) CHECK(has(study, method));
    CHECK(reached(study) >= before);
    before = reached(study);
  }
  CHECK(before >= 3);
}

TEST_CASE("errors, bias and noise are those that the methods have", "[study]") {
  PretendedBench bench;
  const Study study = study_of(bench, 80);
  int biased = 0;
  for (const StudyRun& run : study.runs) {
    const auto [bias, noise] = PretendedBench::errors(run.setting);
    CAPTURE(study_label(run.setting), bias, noise);
    CHECK(std::abs(run.error.error.square - bias * bias - noise * noise) < 5 * run.error.error.square_error);
    CHECK(std::abs(run.error.noise.square - noise * noise) < 5 * run.error.noise.square_error);
    CHECK(std::abs(run.error.bias.square - bias * bias) < 5 * run.error.bias.square_error + 0.01 * bias * bias);
    if (run.error.bias.square > 5 * run.error.bias.square_error) ++biased;
  }
  CHECK(biased >= 2);
  for (const StudySlope& slope : study.slopes) {
    if (slope.method == &kPathTracer && slope.what == "error")
      CHECK(std::abs(slope.law.exponent + 0.5) < 4 * slope.law.exponent_error);
  }
}

TEST_CASE("the settings to use are the cheapest that reach the error", "[study]") {
  PretendedBench bench;
  const Study study = study_of(bench, 80);
  REQUIRE(reached(study) >= 4);
  for (const StudyTarget& target : study.targets) {
    for (const StudyRun& run : study.runs) {
      if (!renders(run.setting.method.type) || run.error.error.value() + run.error.error.error() > target.error)
        continue;
      REQUIRE(target.run >= 0);
      CHECK(study.runs[static_cast<std::size_t>(target.run)].full.cpu() <= run.full.cpu());
    }
    if (target.run >= 0) CHECK(renders(study.runs[static_cast<std::size_t>(target.run)].setting.method.type));
  }
  // The image alone grows with the pixels.
  const StudyRun& run = study.runs.back();
  CHECK(run.full.cpu() == Approx(run.seconds.world.cpu + run.seconds.map.cpu + 100 * run.seconds.image.cpu));
  // Nothing on the front is both dearer and worse than another.
  for (const int a : study.front) {
    for (const int b : study.front) {
      const StudyRun &x = study.runs[static_cast<std::size_t>(a)], &y = study.runs[static_cast<std::size_t>(b)];
      if (x.full.cpu() < y.full.cpu()) CHECK(x.error.error.value() > y.error.error.value());
    }
  }
}

TEST_CASE("the scene's own setting is a rung, whoever asks for it first", "[study]") {
  PretendedBench bench(&kPathTracer);
  const Study study = study_of(bench, 40);
  REQUIRE(study.as_given >= 0);
  CHECK(study.runs[static_cast<std::size_t>(study.as_given)].purpose == "ladder");
  CHECK(study.runs[static_cast<std::size_t>(study.as_given)].setting.method.samples == 64);
  CHECK(std::any_of(study.runs.begin(), study.runs.end(),
                    [](const StudyRun& r) { return r.purpose == "ladder" && r.setting.method.samples == 256; }));
}

TEST_CASE("every knob is varied alone", "[study]") {
  PretendedBench bench;
  const Study study = study_of(bench, 200);
  std::map<const MethodType*, std::set<std::string>> knobs;
  for (const StudyRun& run : study.runs) {
    if (run.base < 0) continue;
    knobs[run.setting.method.type].insert(run.purpose);
    const StudySetting& base = study.runs[static_cast<std::size_t>(run.base)].setting;
    CHECK(with_knob(base, run.purpose, base, run.setting) == run.setting);
  }
  CHECK(knobs[&kPhotonMap] == std::set<std::string>{"nearest", "kernel", "rays", "octree_tolerance"});
  CHECK(knobs[&kFinalGather] == std::set<std::string>{"nearest", "kernel", "rays", "photons", "octree_tolerance"});
  CHECK(knobs[&kPathTracer] == std::set<std::string>{"rays", "octree_tolerance"});
  CHECK(knobs[&kOrdinates] == std::set<std::string>{"order", "rays", "octree_tolerance"});
  CHECK(study.as_given >= 0);
}

TEST_CASE("a method that refuses is named with its reason, and ordinates stand in for paths", "[study]") {
  PretendedBench bench;
  bench.refused = {{&kPathTracer, "beams without width"}};
  const Study study = study_of(bench, 20);
  REQUIRE(study.refusals.size() == 1);
  CHECK(study.refusals[0].first == &kPathTracer);
  CHECK(study.refusals[0].second.find("beams without width") != std::string::npos);
  CHECK(study.reference.method == "ordinates");
  CHECK(study_table(study).find("without path tracer: pretended: beams without width") != std::string::npos);
  CHECK(has(study, &kPhotonMap));

  PretendedBench none;
  none.refused = {{&kPathTracer, "no paths"}, {&kOrdinates, "no ordinates"}};
  CHECK_THROWS_AS(study_of(none, 20), NumericalError);
}

TEST_CASE("JSON and CSV tell the same, and settings are those of a scene file", "[study]") {
  PretendedBench bench;
  const Study study = study_of(bench, 40);
  const Json json = Json::parse(study_json(study));
  REQUIRE(json["runs"].size() == study.runs.size());
  std::istringstream csv(study_csv(study));
  std::string line;
  std::getline(csv, line);
  std::vector<std::string> names;
  const auto cells = [](const std::string& text) {
    std::vector<std::string> result(1);
    bool quoted = false;
    for (const char c : text) {
      if (c == '"')
        quoted = !quoted;
      else if (c == ',' && !quoted)
        result.emplace_back();
      else
        result.back() += c;
    }
    return result;
  };
  names = cells(line);
  for (const Json& run : json["runs"]) {
    REQUIRE(std::getline(csv, line));
    const std::vector<std::string> values = cells(line);
    REQUIRE(values.size() == names.size());
    const auto value = [&](const char* name) {
      return values[static_cast<std::size_t>(std::find(names.begin(), names.end(), name) - names.begin())];
    };
    CHECK(value("method") == run["method"]);
    CHECK(value("label") == run["label"]);
    for (const char* name : {"error", "error_bar", "bias", "bias_bar", "noise", "noise_bar"})
      CHECK(std::stod(value(name)) == Approx(run[name].get<double>()));
    CHECK(std::stod(value("cpu_s")) == Approx(run["seconds"]["cpu"].get<double>()));
    CHECK(std::stod(value("full_cpu_s")) == Approx(run["seconds_full"]["cpu"].get<double>()));
    CHECK(std::stod(value("memory_bytes")) == Approx(run["memory_bytes"]["total"].get<double>()));
    if (run["method"] == "path tracer") CHECK(run["settings"]["/render/samples"] == std::stoi(value("samples")));
    if (run["method"] == "photon map") CHECK(run["settings"]["/render/final_gather"] == 0);
    if (run["method"] == "ordinates") CHECK(run["settings"].empty());
  }
  CHECK_FALSE(std::getline(csv, line));
  REQUIRE(json["best"].size() == kStudyTargets.size());
  for (const Json& best : json["best"]) {
    if (!best["reached"]) continue;
    const Json& run = json["runs"][best["run"].get<std::size_t>()];
    CHECK(best["settings"] == run["settings"]);
    CHECK(best["error"].get<double>() + best["error_bar"].get<double>() <= best["target"].get<double>());
  }
}

TEST_CASE("the page needs nothing from outside and runs nothing", "[study]") {
  PretendedBench bench;
  const std::string page = page_of(study_of(bench, 40));
  CHECK(page.find("http") == std::string::npos);
  CHECK(page.find("<script") == std::string::npos);
  CHECK(page.find("url(") == std::string::npos);
  CHECK(page.find("<scene>") == std::string::npos);
  CHECK(page.find("nan") == std::string::npos);
  const std::regex source("src=\"([^\"]{0,22})");
  int pictures = 0;
  for (std::sregex_iterator it(page.begin(), page.end(), source), end; it != end; ++it, ++pictures) {
    CHECK((*it)[1].str() == "data:image/png;base64,");
  }
  CHECK(pictures >= 4);
  for (const char* part :
       {"Settings to use", "Error against time", "Error against memory", "Bias and noise apart", "Other knobs"}) {
    CHECK(page.find(part) != std::string::npos);
  }
}

TEST_CASE("ladders go through the scene's own setting in factors of four", "[study]") {
  StudyTraits traits;
  traits.given.method.photons = 2000000;
  traits.given.method.nearest = 64;
  traits.given.method.samples = 64;
  traits.given.rays = 8;
  const auto rung = [&](const MethodType* method, int number) {
    StudySetting s = first_rung(traits, method);
    for (int k = 0; k < number; ++k) s = scaled(traits, s, kRung);
    return s;
  };
  CHECK(rung(&kPathTracer, 0).method.samples == 1);
  CHECK(rung(&kPathTracer, 0).rays == 1);
  CHECK(rung(&kPathTracer, 1).rays == 4);
  CHECK(rung(&kPathTracer, 3).method.samples == 64);
  CHECK(rung(&kPathTracer, 3).rays == 8);
  CHECK(rung(&kPathTracer, 4).rays == 32);
  CHECK(rung(&kPhotonMap, 0).method.photons == 7813);
  CHECK(rung(&kPhotonMap, 0).method.nearest == 8);
  CHECK(rung(&kPhotonMap, 4).method.photons == 2000000);
  CHECK(rung(&kPhotonMap, 4).method.nearest == 64);
  CHECK(rung(&kPhotonMap, 5).method.nearest == 141);
  CHECK(rung(&kPhotonMap, 5).rays == 18);
  CHECK(rung(&kFinalGather, 3).method.photons == 2000000);
  CHECK(rung(&kFinalGather, 3).method.samples == 64);
  CHECK(rung(&kFinalGather, 3).method.nearest == 64);
  CHECK(rung(&kOrdinates, 3).method.cells == 33);
  // Down again.
  CHECK(scaled(traits, rung(&kPathTracer, 4), 0.25) == rung(&kPathTracer, 3));
  CHECK(scaled(traits, rung(&kFinalGather, 4), 0.25) == rung(&kFinalGather, 3));

  traits.scatters = false;
  CHECK(rung(&kPathTracer, 0).rays == 1);
  CHECK(rung(&kPathTracer, 3).rays == 64);
  CHECK(rung(&kPathTracer, 3).method.samples == 64);
  CHECK(rung(&kPhotonMap, 3).method.photons == 1000);
}
