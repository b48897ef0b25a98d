// The tree against brute force, and its bits against the order and the threads it was built with.
#include "photon/map/kd_tree.h"

#include <oneapi/tbb/global_control.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstring>
#include <set>
#include <vector>

#include "octree/base/random.h"

using namespace obscura;

namespace {

enum class Cloud { uniform, clustered, lattice, sheet, one_place };

std::vector<Photon> make_photons(int count, Cloud cloud, std::uint64_t seed) {
  std::vector<Photon> photons(count);
  for (int i = 0; i < count; ++i) {
    Stream stream(seed, i, 1);
    const auto u = [&] { return static_cast<float>(stream.uniform()); };
    Vec3f p(u(), u(), u());
    if (cloud == Cloud::clustered) p = Vec3f(p.x * p.x * p.x, p.y * p.y * p.y * p.y, p.z * p.z * p.z);
    if (cloud == Cloud::lattice) {
      p = Vec3f(std::floor(p.x * 5), std::floor(p.y * 5), std::floor(p.z * 5));
    }
    if (cloud == Cloud::sheet) p.z = 0.25f;
    if (cloud == Cloud::one_place) p = Vec3f(0.5f, -0.25f, 3.0f);
    photons[i].position = p;
    photons[i].power = static_cast<float>(i);
    photons[i].batch = static_cast<std::uint16_t>(i % kBatches);
  }
  return photons;
}

using Found = std::vector<std::pair<float, std::uint32_t>>;

Found brute_force(std::span<const Photon> photons, const Vec3f& x, int k) {
  Found all;
  for (std::uint32_t i = 0; i < photons.size(); ++i) {
    const Vec3f d = photons[i].position - x;
    all.push_back({(d.x * d.x + d.y * d.y) + d.z * d.z, i});
  }
  std::sort(all.begin(), all.end());
  all.resize(std::min<std::size_t>(all.size(), k));
  return all;
}

Found search(const KdTree& tree, const Vec3f& x, int k) {
  Nearest nearest(k);
  tree.nearest(x, nearest);
  Found found;
  for (int i = 0; i < nearest.count(); ++i) found.push_back({nearest.distance2(i), nearest.index(i)});
  // The farthest comes last.
  if (!found.empty()) CHECK(found.back() == *std::max_element(found.begin(), found.end()));
  std::sort(found.begin(), found.end());
  return found;
}

bool same_bits(std::span<const Photon> a, std::span<const Photon> b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size_bytes()) == 0;
}

}  // namespace

TEST_CASE("the tree finds what brute force finds, ties by the lower index", "[photon][kd_tree]") {
  const auto cloud = GENERATE(Cloud::uniform, Cloud::clustered, Cloud::lattice, Cloud::sheet, Cloud::one_place);
  const int count = GENERATE(1, 2, 15, 16, 17, 33, 100, 1000, 4099);
  const auto photons = make_photons(count, cloud, 7);
  const KdTree tree(photons);
  for (int query = 0; query < 40; ++query) {
    Stream stream(11, query, 2);
    Vec3f x(static_cast<float>(1.5 * stream.uniform() - 0.25), static_cast<float>(stream.uniform()),
            static_cast<float>(2 * stream.uniform() - 0.5));
    if (query % 4 == 0) x = photons[query * 7919 % count].position;
    if (query == 1) x = Vec3f(1e4f, -3e5f, 2.0f);
    for (const int k : {1, 2, 8, 64, 500, 5000}) {
      const int most = std::min(k, Nearest::kMax);
      REQUIRE(search(tree, x, k) == brute_force(tree.photons(), x, most));
    }
  }
}

TEST_CASE("the tree holds the photons it was given", "[photon][kd_tree]") {
  const auto photons = make_photons(3001, Cloud::clustered, 3);
  const KdTree tree(photons);
  std::multiset<float> given, held;
  for (const Photon& photon : photons) given.insert(photon.power + photon.position.x);
  for (const Photon& photon : tree.photons()) held.insert(photon.power + photon.position.x);
  CHECK(given == held);
  CHECK(tree.bytes() < 25 * photons.size());
}

TEST_CASE("an empty tree finds nothing", "[photon][kd_tree]") {
  const KdTree made(std::vector<Photon>{});
  const KdTree none;
  for (const KdTree* tree : {&made, &none}) {
    Nearest nearest(64);
    tree->nearest(Vec3f(1, 2, 3), nearest);
    CHECK(nearest.count() == 0);
    CHECK(tree->photons().empty());
  }
}

TEST_CASE("the tree has the same bits for any threads and any order of its photons", "[photon][kd_tree]") {
  const auto cloud = GENERATE(Cloud::uniform, Cloud::lattice, Cloud::one_place);
  auto photons = make_photons(50000, cloud, 5);
  const KdTree reference(photons);
  for (const int threads : {1, 2, 7}) {
    oneapi::tbb::global_control limit(oneapi::tbb::global_control::max_allowed_parallelism, threads);
    CHECK(same_bits(KdTree(photons).photons(), reference.photons()));
  }
  std::reverse(photons.begin(), photons.end());
  CHECK(same_bits(KdTree(photons).photons(), reference.photons()));
  std::rotate(photons.begin(), photons.begin() + 12345, photons.end());
  CHECK(same_bits(KdTree(photons).photons(), reference.photons()));
}

TEST_CASE("a search can go on in other photons and can be limited", "[photon][kd_tree]") {
  const auto photons = make_photons(2000, Cloud::uniform, 9);
  const KdTree tree(photons);
  const Vec3f x(0.9f, 0.5f, 0.5f), shift(1, 0, 0);

  std::vector<Photon> both(tree.photons().begin(), tree.photons().end());
  for (const Photon& photon : tree.photons()) {
    both.push_back(photon);
    both.back().position -= Vec3f(0) - shift;
  }
  Nearest nearest(200);
  tree.nearest(x, nearest);
  tree.nearest(x - shift, nearest, 2000);
  const Found expected = brute_force(both, x, 200);
  Found found;
  for (int i = 0; i < nearest.count(); ++i) found.push_back({nearest.distance2(i), nearest.index(i)});
  std::sort(found.begin(), found.end());
  REQUIRE(found.size() == expected.size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    CHECK(found[i].first == Approx(expected[i].first).epsilon(1e-4));
  }
  CHECK(std::any_of(found.begin(), found.end(), [](const auto& f) { return f.second >= 2000; }));

  // Photons at the limit itself are out.
  const Found all = brute_force(tree.photons(), x, 100);
  Nearest limited(500, all[60].first);
  tree.nearest(x, limited);
  CHECK(limited.count() == 60);
}
