// Methods as values: what each answers, when it refuses, and what two of them share.
#include "photon/methods/method.h"

#include <catch2/catch.hpp>
#include <set>

#include "tests/support/agree.h"
#include "tests/support/worlds.h"

using namespace obscura;
using namespace obscura::test;

namespace {

constexpr double kBrightness = 2;

/// A cube of optical depth 4 that scatters half, as bright as its sky: everything is, in every direction.
WorldContents furnace() {
  CloudWish wish;
  wish.voxels = Vec3i(8);
  wish.extinction = 0.5;
  wish.albedo = 0.5;
  wish.source = kBrightness;
  return grey_contents(wish, kBrightness);
}

Method small(const MethodType& type) {
  Method method;
  method.type = &type;
  method.photons = 200000;
  method.cells = 8;
  return method;
}

/// Within its own error and bias, which are small enough to say something.
void check(const std::string& what, const Measured& measured, double expected, double resolution) {
  INFO(what << ": " << measured.value << " +- " << measured.error << ", bias " << measured.bias);
  CHECK(std::abs(measured.value - expected) < 4.5 * measured.error + 2 * measured.bias + 1e-5 * expected);
  CHECK(measured.error + measured.bias < resolution * expected);
}

bool refuses(const World& world, const MethodType& type) { return unfit(world, small(type)).has_value(); }

}  // namespace

TEST_CASE("every method finds radiance, fluence and power of a furnace", "[photon][methods]") {
  const World world(furnace());
  EstimatorSettings settings;
  settings.rectangles.push_back({{4, 4, 12}, {6, 0, 0}, {0, 6, 0}});
  for (const MethodType* type : methods()) {
    INFO(type->name);
    const Estimator estimator = make_estimator(world, small(*type), settings);
    std::vector<Ray> rays(400, Ray{{-3, 4.2, 3.7}, Vec3d(1, 0.05, 0.02).normalized(), 0, kInfinity});
    std::vector<std::uint64_t> histories;
    for (std::size_t r = 0; r < rays.size(); ++r) histories.push_back(r);
    std::vector<Incoming> incoming(rays.size());
    CHECK(estimator.radiance(0, {}, rays, histories, incoming).rays == rays.size());
    Moments total;
    std::array<double, kBatches> batches{};
    double bias = 0;
    for (const Incoming& in : incoming) {
      total.add(in.total());
      bias += in.bias / static_cast<double>(rays.size());
      for (std::size_t b = 0; b < batches.size(); ++b) batches[b] += in.map[b] / static_cast<double>(rays.size());
    }
    const double error = std::hypot(total.standard_error(), batch_mean(batches).standard_error);
    check("radiance", {total.mean(), error, 1e9, std::abs(bias)}, kBrightness, 0.08);

    check("fluence", estimator.fluence(0, {4.1, 3.9, 4.2}, 2000, 1), 4 * kPi * kBrightness, 0.05);

    const auto power = estimator.crossing(0, 0, 10000);
    CHECK(power.has_value() == !type->cells);
    if (power) {
      check("forward", power->forward, kPi * kBrightness * 36, 0.05);
      check("backward", power->backward, kPi * kBrightness * 36, 0.05);
      CHECK(std::abs(power->forward.value - power->backward.value) < 4.5 * power->net_error);
    }
  }
}

TEST_CASE("a darker sky is seen by every method", "[photon][methods]") {
  // The twin of the furnace: the same comparisons, that have to fail.
  WorldContents dark = furnace();
  dark.sky = {0.5 * kBrightness};
  const World world(std::move(dark));
  for (const MethodType* type : methods()) {
    INFO(type->name);
    const Measured here = make_estimator(world, small(*type), {}).fluence(0, {4.1, 3.9, 4.2}, 2000, 1);
    CHECK(here.value + 4.5 * here.error + 2 * here.bias < 4 * kPi * kBrightness);
  }
}

TEST_CASE("methods say what they cannot find, and are asked before they work", "[photon][methods]") {
  const auto refusing = [](WorldContents contents) {
    const World world(std::move(contents));
    std::set<std::string> names;
    for (const MethodType* type : methods()) {
      if (refuses(world, *type)) names.insert(type->name);
      if (refuses(world, *type)) CHECK_THROWS_AS(make_estimator(world, small(*type), {}), NumericalError);
    }
    return names;
  };
  using Names = std::set<std::string>;
  CHECK(refusing(furnace()).empty());
  WorldContents line = furnace();
  line.beams.push_back({{4, 4, 20}, {0, 0, -1}, 0, {1}});
  CHECK(refusing(std::move(line)) == Names{"final gather", "path tracer"});
  WorldContents flare = furnace();
  flare.sources.push_back({{4, 4, 12}, 0.5, {9}});
  CHECK(refusing(std::move(flare)) == Names{"ordinates"});
  CloudWish wish;
  wish.albedo = 0.5;
  wish.period_m = {16, 16};
  WorldContents endless = grey_contents(wish, 1);
  endless.sources.push_back({{4, 4, 30}, 0.5, {9}});
  CHECK(refusing(std::move(endless)) == Names{"photon map", "final gather", "ordinates"});
  // Nothing that goes on is asked of what would not end.
  CloudWish thick;
  thick.extinction = 1e5;
  thick.albedo = 1;
  const World world(grey_contents(thick, 1));
  EstimatorSettings once;
  once.again = false;
  CHECK(unfit(world, small(kPathTracer)).has_value());
  CHECK_FALSE(unfit(world, small(kPathTracer), once).has_value());
}

TEST_CASE("photon map and final gather share their photons, and nothing else is shared", "[photon][methods]") {
  const EstimatorSettings settings;
  const auto basis = [&settings](Method method) { return method.type->basis(method, settings); };
  Method map = small(kPhotonMap), gather = small(kFinalGather);
  CHECK(basis(map) == basis(gather));
  gather.samples = 7;
  gather.nearest = 9;
  CHECK(basis(map) == basis(gather));
  gather.photons = 9;
  CHECK_FALSE(basis(map) == basis(gather));
  Method limited = map;
  limited.scattering_depth = 2;
  CHECK_FALSE(basis(map) == basis(limited));
  EstimatorSettings other = settings;
  other.seed = 2;
  CHECK_FALSE(basis(map) == kPhotonMap.basis(map, other));
  CHECK_FALSE(basis(map) == basis(small(kOrdinates)));
  CHECK(kOrdinates.basis(small(kOrdinates), other) == basis(small(kOrdinates)));
}

TEST_CASE("words and names tell methods apart", "[photon][methods]") {
  CHECK(method_words() == std::vector<std::string>{"photon", "path", "ordinates"});
  std::set<std::string> names;
  for (std::size_t i = 0; i < methods().size(); ++i) {
    CHECK(index_of(*methods()[i]) == i);
    names.insert(methods()[i]->name);
  }
  CHECK(names.size() == methods().size());
  Method gather = small(kFinalGather);
  gather.samples = 16;
  CHECK(text(gather) == "final gather, 200000 photons, 16 samples");
  CHECK(text(small(kPathTracer)) == "path tracer, 64 samples");
}
