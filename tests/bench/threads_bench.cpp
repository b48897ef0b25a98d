// What a second thread is worth: tracing and rendering with one thread and with all, in turn, as a ratio;
// and by Amdahl's law the share of the work that is serial.
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <vector>

#include "scene/file/scene_io.h"
#include "scene/session/session.h"
#include "tests/support/places.h"

using namespace obscura;

namespace {

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

struct Times {
  double world, photons, image;
  double whole() const { return world + photons + image; }
};

Times run(const Description& scene, int threads) {
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads));
  Times times;
  auto start = std::chrono::steady_clock::now();
  Session session(scene, 0);
  times.world = seconds_since(start);
  start = std::chrono::steady_clock::now();
  session.estimator(session.plan().method, scene.render.seed);
  times.photons = seconds_since(start);
  start = std::chrono::steady_clock::now();
  session.render();
  times.image = seconds_since(start);
  return times;
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

}  // namespace

int main() {
  const int threads = tbb::this_task_arena::max_concurrency();
  Description scene = read_scene(test::source_file("scene/examples/smoke_at_night.json"));
  scene.sensor.resolution = {320, 140};
  std::vector<Times> one, all;
  for (int i = 0; i < 5; ++i) {
    one.push_back(run(scene, 1));
    all.push_back(run(scene, threads));
  }
  std::printf("%-8s %12s %12s %12s %16s\n", "stage", "1 thread s", "all s", "efficiency", "serial fraction");
  const auto row = [&](const char* name, auto&& value) {
    std::vector<double> a, b, ratios;
    for (std::size_t i = 0; i < one.size(); ++i) {
      a.push_back(value(one[i]));
      b.push_back(value(all[i]));
      ratios.push_back(a.back() / b.back());
    }
    const double speedup = median(ratios);
    const double serial = threads > 1 ? (threads / speedup - 1) / (threads - 1) : 0;
    std::printf("%-8s %12.2f %12.2f %11.0f%% %16.3f\n", name, median(a), median(b), 100 * speedup / threads, serial);
  };
  row("world", [](const Times& t) { return t.world; });
  row("photons", [](const Times& t) { return t.photons; });
  row("image", [](const Times& t) { return t.image; });
  row("whole", [](const Times& t) { return t.whole(); });
}
