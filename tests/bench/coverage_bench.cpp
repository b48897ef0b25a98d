// Whether error bars keep their promise: each scene is rendered with many seeds in several ways, and its pixels are
// held against a reference of many paths. Prints the table of sensor/MEASURED.md, "Coverage".
//
//   coverage_bench [--seeds 200] [--scene TEXT] [--way TEXT] [--references FOLDER]
//
// Those scenes and ways are run whose names hold the text. References are kept in the folder from run to run.
#include <fmt/format.h>

#include <chrono>
#include <cstdio>
#include <string>

#include "scene/goal/accuracy.h"
#include "tests/support/coverage.h"

using namespace obscura;
using namespace obscura::test::coverage;

namespace {

struct Options {
  int seeds = 200;
  std::string scene, way, references;
};

double seconds() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

void run(const Case& c, const Way& way, const Truth& truth, int seeds) {
  Coverage coverage(truth);
  const int images = std::max(2, seeds / way.dear);
  const Description scene = parse_scene(c.scene, ".", way.edits);
  Session session(scene, 0);
  for (int seed = 1; seed <= images; ++seed) {
    if (scene.render.target_error) {
      Description again = scene;
      again.render.seed = static_cast<std::uint64_t>(seed);
      Session own(std::move(again), 0);
      const AccuracyGoal goal{scene.render.target_error, std::nullopt, own.plan().budget.dropped};
      coverage.add(render_to_goal(own, goal, seconds).rendered.film);
    } else {
      coverage.add(session
                       .render(session.plan().camera, session.plan().sampling, session.plan().method,
                               static_cast<std::uint64_t>(seed))
                       .film);
    }
  }
  fmt::print("| {} | {} | {} |\n", c.name, way.name, coverage.row());
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  for (int i = 1; i + 1 < argc; i += 2) {
    const std::string key = argv[i], value = argv[i + 1];
    if (key == "--seeds") options.seeds = std::stoi(value);
    if (key == "--scene") options.scene = value;
    if (key == "--way") options.way = value;
    if (key == "--references") options.references = value;
  }
  fmt::print(
      "| scene | way | images | pixels inside 95 % | pixels covered below 80 % | claimed over true | image mean, z: "
      "mean, deviation |\n|---|---|---|---|---|---|---|\n");
  for (const Case& c : cases()) {
    if (c.name.find(options.scene) == std::string::npos) continue;
    const Truth truth = reference_of(c, options.references);
    for (const Way& way : c.ways) {
      if (way.name.find(options.way) != std::string::npos) run(c, way, truth, options.seeds);
    }
  }
}
