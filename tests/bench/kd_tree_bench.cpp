// The kd-tree and the density estimate against nanoflann on the same photons: build, the 64 nearest of
// query points that lie like the photons, and the whole estimate. Prints one table of ratios, each from
// medians of runs that alternate.
#include <benchmark/benchmark.h>
#include <fmt/format.h>
#include <oneapi/tbb/global_control.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <memory>
#include <nanoflann.hpp>
#include <vector>

#include "octree/base/random.h"
#include "photon/map/density.h"

namespace {

using namespace obscura;
constexpr int kNearest = 64;

/// Uniform in a cube, or in a hundred Gaussian puffs of sizes over a decade and a half.
std::vector<Photon> make_photons(int count, bool clustered) {
  std::vector<Photon> photons(count);
  for (int i = 0; i < count; ++i) {
    Stream stream(42, i, 1);
    Vec3d p(stream.uniform(), stream.uniform(), stream.uniform());
    if (clustered) {
      const int puff = static_cast<int>(stream.uniform() * 100);
      Stream place(43, puff, 2);
      const Vec3d middle(place.uniform(), place.uniform(), place.uniform());
      const double size = 0.003 * std::pow(30.0, place.uniform());
      const auto normal = [&] {
        return std::sqrt(-2 * std::log(stream.uniform())) * std::cos(2 * kPi * stream.uniform());
      };
      p = middle + size * Vec3d(normal(), normal(), normal());
    }
    photons[i].position = Vec3f(100.0 * p);
    photons[i].direction = encode_direction({1, 0, 0});
    photons[i].power = 1.0f / static_cast<float>(count);
    photons[i].batch = static_cast<std::uint16_t>(i % kBatches);
  }
  return photons;
}

/// nanoflann as its manual has it: an adaptor over the photons, floats, L2_Simple.
struct Adaptor {
  std::vector<Photon> photons;
  std::size_t kdtree_get_point_count() const { return photons.size(); }
  float kdtree_get_pt(std::size_t i, std::size_t axis) const { return photons[i].position[static_cast<int>(axis)]; }
  template <class Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
};
using Flann =
    nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<float, Adaptor>, Adaptor, 3, std::uint32_t>;

struct Case {
  int count;
  bool clustered;
  std::vector<Photon> photons;
  std::vector<Vec3f> queries;  // where photons are, moved by a part of their distance
};

const Case& get_case(int count, bool clustered) {
  static std::vector<std::unique_ptr<Case>> cases;
  for (const auto& c : cases) {
    if (c->count == count && c->clustered == clustered) return *c;
  }
  auto made = std::make_unique<Case>(Case{count, clustered, make_photons(count, clustered), {}});
  for (int i = 0; i < 20000; ++i) {
    Stream stream(7, i, 3);
    const auto pick = static_cast<std::size_t>(stream.uniform() * count);
    const float shift = 0.1f;
    made->queries.push_back(made->photons[pick].position + Vec3f(shift * static_cast<float>(stream.uniform()), 0, 0));
  }
  cases.push_back(std::move(made));
  return *cases.back();
}

double seconds(const auto& f) {
  const auto start = std::chrono::steady_clock::now();
  f();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + values.size() / 2, values.end());
  return values[values.size() / 2];
}

double query_ours(const KdTree& tree, const Case& c) {
  double sum = 0;
  for (const Vec3f& x : c.queries) {
    Nearest nearest(kNearest);
    tree.nearest(x, nearest);
    sum += nearest.distance2(nearest.count() - 1);
  }
  return sum;
}

double query_flann(const Flann& tree, const Case& c) {
  double sum = 0;
  std::uint32_t indices[kNearest];
  float distances[kNearest];
  for (const Vec3f& x : c.queries) {
    const auto found = tree.knnSearch(&x.x, kNearest, indices, distances);
    sum += distances[found - 1];
  }
  return sum;
}

template <class Weight>
double query_estimate(const PhotonMap& map, const Case& c, const Weight& weight) {
  double sum = 0;
  const auto extinction = [](const Vec3d& y) { return std::abs(y.x) < 1e9 ? 1.0 : 0.0; };
  for (const Vec3f& x : c.queries) {
    sum += estimate(map, Vec3d(x), extinction, weight, GatherSettings{}).value;
  }
  return sum;
}

void print_table() {
  fmt::print("kd-tree against nanoflann {:#x}, medians of interleaved runs; ratio > 1: ours is faster\n",
             NANOFLANN_VERSION);
  fmt::print("{:<12}{:>9}{:>28}{:>12}{:>12}{:>8}\n", "photons", "count", "what", "nanoflann", "ours", "ratio");
  for (const bool clustered : {false, true}) {
    for (const int count : {100000, 1000000}) {
      const Case& c = get_case(count, clustered);
      const Adaptor adaptor{c.photons};
      const int runs = count > 300000 ? 5 : 11;

      // The leaf size that suits nanoflann's queries best here, and the one that suits its build.
      std::size_t leaf = 10;
      double best = 1e9;
      for (const std::size_t size : {8, 10, 16, 24, 32, 50}) {
        const Flann tree(3, adaptor, nanoflann::KDTreeSingleIndexAdaptorParams(size));
        query_flann(tree, c);
        const double t = std::min(seconds([&] { benchmark::DoNotOptimize(query_flann(tree, c)); }),
                                  seconds([&] { benchmark::DoNotOptimize(query_flann(tree, c)); }));
        if (t < best) {
          best = t;
          leaf = size;
        }
      }
      const nanoflann::KDTreeSingleIndexAdaptorParams parameters(leaf);
      const Flann flann(3, adaptor, parameters);
      const PhotonMap map(c.photons);

      std::vector<double> build_flann, build_one, build_all, find_flann, find_ours, whole;
      double check = 0;
      for (int run = 0; run < runs; ++run) {
        build_flann.push_back(seconds([&] { Flann tree(3, adaptor, parameters); }));
        auto photons = c.photons;
        {
          oneapi::tbb::global_control one(oneapi::tbb::global_control::max_allowed_parallelism, 1);
          build_one.push_back(seconds([&] { KdTree tree(std::move(photons)); }));
        }
        photons = c.photons;
        build_all.push_back(seconds([&] { KdTree tree(std::move(photons)); }));
        find_flann.push_back(seconds([&] { check += query_flann(flann, c); }));
        find_ours.push_back(seconds([&] { check -= query_ours(map.tree(), c); }));
        whole.push_back(
            seconds([&] { benchmark::DoNotOptimize(query_estimate(map, c, [](const Vec3d& w) { return 1 + w.x; })); }));
      }
      if (std::abs(check) > 1e-3) fmt::print("the distances differ by {}\n", check);

      const auto row = [&](const std::string& what, double flann_s, double ours_s, const char* unit) {
        fmt::print("{:<12}{:>9}{:>28}{:>9.3g} {:<2}{:>9.3g} {:<2}{:>8.2f}\n", clustered ? "clustered" : "uniform",
                   count, what, flann_s, unit, ours_s, unit, flann_s / ours_s);
      };
      const double n = static_cast<double>(c.queries.size());
      row("build, one thread", 1e3 * median(build_flann), 1e3 * median(build_one), "ms");
      row("build, all threads", 1e3 * median(build_flann), 1e3 * median(build_all), "ms");
      row(fmt::format("64 nearest (leaf {})", leaf), 1e6 * median(find_flann) / n, 1e6 * median(find_ours) / n, "us");
      row("(the whole estimate)", 1e6 * median(find_flann) / n, 1e6 * median(whole) / n, "us");
    }
  }
}

void build(benchmark::State& state) {
  const Case& c = get_case(static_cast<int>(state.range(0)), state.range(1));
  for (auto _ : state) {
    auto photons = c.photons;
    benchmark::DoNotOptimize(KdTree(std::move(photons)));
  }
}

void find(benchmark::State& state) {
  const Case& c = get_case(static_cast<int>(state.range(0)), state.range(1));
  const KdTree tree(c.photons);
  for (auto _ : state) benchmark::DoNotOptimize(query_ours(tree, c));
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(c.queries.size()));
}

void gather(benchmark::State& state) {
  const Case& c = get_case(static_cast<int>(state.range(0)), state.range(1));
  const PhotonMap map(c.photons);
  for (auto _ : state) {
    benchmark::DoNotOptimize(query_estimate(map, c, [](const Vec3d& w) { return 1 + w.x; }));
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(c.queries.size()));
}

BENCHMARK(build)->ArgsProduct({{100000, 1000000}, {0, 1}})->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK(find)->ArgsProduct({{100000, 1000000}, {0, 1}})->Unit(benchmark::kMillisecond);
BENCHMARK(gather)->ArgsProduct({{100000, 1000000}, {0, 1}})->Unit(benchmark::kMillisecond);

}  // namespace

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  print_table();
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
