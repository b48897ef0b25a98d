// The scalar walk against brute force, against exact rational arithmetic, and on every awkward ray.
#include "octree/tree/walk.h"

#include <catch2/catch.hpp>
#include <fstream>
#include <sstream>

#include "octree/build/build.h"
#include "tests/support/places.h"
#include "tests/support/voxel_fields.h"

using namespace obscura;
using namespace obscura::test;

namespace {

Octree lossless(const VoxelStream& stream) {
  BuildSettings settings;
  settings.tolerance = 0;
  return build_octree(stream, settings).first;
}

// Integral of a function of the voxel along a ray: all plane crossings sorted, each piece's voxel found from its
// middle. Shares nothing with the walk.
double brute_force_depth(const Box3i& domain, const Ray& ray, const Field& field, std::span<const double> weights,
                         double* length = nullptr) {
  std::vector<double> times;
  double enter = ray.t_min, leave = ray.t_max;
  for (int axis = 0; axis < 3; ++axis) {
    const double d = ray.direction[axis], o = ray.origin[axis];
    if (d == 0) {
      if (o < domain.min[axis] || o >= domain.max[axis]) enter = kInfinity;
      continue;
    }
    const double a = (domain.min[axis] - o) / d, b = (domain.max[axis] - o) / d;
    enter = std::max(enter, std::min(a, b));
    leave = std::min(leave, std::max(a, b));
    for (int p = domain.min[axis]; p <= domain.max[axis]; ++p) times.push_back((p - o) / d);
  }
  if (length) *length = std::max(0.0, leave - enter);
  if (!(enter < leave)) return 0;
  times.push_back(enter);
  times.push_back(leave);
  std::sort(times.begin(), times.end());
  double depth = 0;
  for (std::size_t i = 0; i + 1 < times.size(); ++i) {
    const double begin = std::max(times[i], enter), end = std::min(times[i + 1], leave);
    if (!(end > begin)) continue;
    const Vec3d middle = ray.at(0.5 * (begin + end));
    Vec3i voxel;
    for (int axis = 0; axis < 3; ++axis) {
      // A parallel ray belongs to the voxel above; a nearly parallel one in a face to the side it goes to.
      double p = middle[axis];
      if (ray.direction[axis] < 0 && p == std::floor(p)) p -= 0.5;
      voxel[axis] = std::clamp(static_cast<int>(std::floor(p)), domain.min[axis], domain.max[axis] - 1);
    }
    for (std::size_t c = 0; c < weights.size(); ++c) {
      depth += weights[c] * static_cast<double>(field(static_cast<int>(c), voxel)) * (end - begin);
    }
  }
  return depth;
}

std::vector<std::vector<double>> read_csv(const std::string& name) {
  std::ifstream file(test::shared_path("reference/" + name));
  std::vector<std::vector<double>> rows;
  std::string line;
  while (std::getline(file, line)) {
    if (line.empty() || line[0] == '#' || std::isalpha(static_cast<unsigned char>(line[0]))) continue;
    std::istringstream cells(line);
    std::vector<double> row;
    for (std::string cell; std::getline(cells, cell, ',');) row.push_back(std::stod(cell));
    rows.push_back(row);
  }
  return rows;
}

}  // namespace

TEST_CASE("the walk tiles the ray without gaps or overlaps", "[octree][walk]") {
  const Box3i domain(Vec3i(-13, -70, 5), Vec3i(61, 20, 76));
  const Field field = patchwork(1);
  const Octree tree = lossless(field_stream(domain, {"density"}, field));
  const int stop_level = GENERATE(0, 1, 2, 3, 4, 5);
  std::uint64_t segments_seen = 0;
  for (std::uint64_t i = 0; i < 30000; ++i) {
    const Ray ray = awkward_ray(domain, 2, i);
    double length = 0;
    const double none = 0;
    brute_force_depth(domain, ray, field, {&none, 0}, &length);
    Walk segments(tree, ray, stop_level);
    double last = -1, sum = 0;
    bool first = true, ok = true;
    Cell last_cell;
    while (segments.next()) {
      ++segments_seen;
      ok = ok && segments.end() > segments.begin() && (first || segments.begin() == last);
      const Cell cell = segments.cell();
      ok = ok && cell.level >= stop_level && tree.cell_at(cell.corner, cell.level).corner == cell.corner;
      ok = ok && (first || !(cell.corner == last_cell.corner && cell.level == last_cell.level));
      // The middle of the segment is in its cell, but for rounding of the point.
      const Vec3d middle = ray.at(0.5 * (segments.begin() + segments.end()));
      for (int axis = 0; axis < 3; ++axis) {
        ok = ok && middle[axis] > cell.corner[axis] - 1e-9 &&
             middle[axis] < cell.corner[axis] + (1 << cell.level) + 1e-9;
      }
      const Bounds bounds = tree.bounds(0, cell);
      ok = ok && segments.value(0) == bounds.mean && (!segments.empty() || bounds.max == 0);
      sum += segments.end() - segments.begin();
      last = segments.end();
      last_cell = cell;
      first = false;
    }
    ok = ok && std::abs(sum - length) <= 1e-12 * (ray.origin.length() + length) / ray.direction.length();
    if (!ok) {
      INFO("ray " << i << " from " << ray.origin << " along " << ray.direction << ", stop level " << stop_level);
      REQUIRE(ok);
    }
  }
  CHECK(segments_seen > 30000u * 3);
}

TEST_CASE("a walk with stops tiles the ray, and takes whole cells that it is allowed", "[octree][walk]") {
  const Box3i domain(Vec3i(-13, -70, 5), Vec3i(61, 20, 76));
  const Octree tree = lossless(field_stream(domain, {"density"}, patchwork(1)));
  struct Stops {
    const Octree& tree;
    int coarsest;
    double share;  // of the cells that are taken
    std::uint64_t asked = 0;
    double taken_begin = 0, taken_end = -1;
    float taken_mean = 0;
    bool ok = true;

    int level(double) const noexcept { return coarsest; }
    bool take(const CellBounds& bounds, double begin, double end) noexcept {
      const Bounds b = bounds(0);
      ok = ok && b.min <= b.mean && b.mean <= b.max && b.max > 0;
      if (!(Stream(5, asked++, 0).uniform() < share)) return false;
      taken_begin = begin;
      taken_end = end;
      taken_mean = b.mean;
      return true;
    }
  };
  const int coarsest = GENERATE(0, 2, 3, 4, 6, 30);
  const double share = GENERATE(0.0, 0.3, 1.0);
  std::uint64_t coarse = 0;
  for (std::uint64_t i = 0; i < 10000; ++i) {
    const Ray ray = awkward_ray(domain, 3, i);
    Walk exact(tree, ray), segments(tree, ray);
    Stops stops{tree, coarsest, share};
    double last = 0, sum = 0, length = 0;
    bool first = true, ok = true;
    while (segments.next(stops)) {
      ok = ok && segments.end() > segments.begin() && (first || segments.begin() == last);
      last = segments.end();
      sum += segments.end() - segments.begin();
      first = false;
      if (segments.coarse()) {
        ++coarse;
        const Cell cell = segments.cell();
        ok = ok && cell.level >= 3 && cell.level <= std::min(coarsest, tree.top_level()) &&
             tree.cell_at(cell.corner, cell.level).corner == cell.corner;
        ok = ok && stops.taken_begin == segments.begin() && stops.taken_end == segments.end() &&
             segments.value(0) == stops.taken_mean;
        ok = ok && segments.value(0) == tree.bounds(0, cell).mean;
        // The ray was not in it before.
        const Vec3d before = ray.at(segments.begin() - 1e-7);
        bool inside = segments.begin() > ray.t_min + 1e-6;
        for (int axis = 0; axis < 3; ++axis) {
          inside = inside && before[axis] > cell.corner[axis] + 1e-9 &&
                   before[axis] < cell.corner[axis] + (1 << cell.level) - 1e-9 &&
                   before[axis] > domain.min[axis] + 1e-9 && before[axis] < domain.max[axis] - 1e-9;
        }
        ok = ok && !inside;
      } else if (share == 0) {
        ok = ok && exact.next() && exact.begin() == segments.begin() && exact.end() == segments.end() &&
             exact.value(0) == segments.value(0);
      }
    }
    const double none = 0;
    brute_force_depth(domain, ray, patchwork(1), {&none, 0}, &length);
    ok = ok && stops.ok && std::abs(sum - length) <= 1e-12 * (ray.origin.length() + length) / ray.direction.length();
    if (!ok) {
      INFO("ray " << i << " from " << ray.origin << " along " << ray.direction << ", coarsest " << coarsest
                  << ", share " << share);
      REQUIRE(ok);
    }
  }
  CHECK((coarse > 5000) == (coarsest >= 3 && share > 0));
}

TEST_CASE("optical depth equals brute force on every awkward ray", "[octree][walk]") {
  const Box3i domain(Vec3i(-13, -30, 5), Vec3i(27, 12, 43));
  const Field field = patchwork(3);
  const Octree tree = lossless(field_stream(domain, {"soot", "water"}, field));
  const double weights[] = {0.7, 0.02};
  double worst = 0, sum = 0;
  for (std::uint64_t i = 0; i < 120000; ++i) {
    const Ray ray = awkward_ray(domain, 4, i);
    const double expected = brute_force_depth(domain, ray, field, weights);
    const double depth = optical_depth(tree, ray, weights);
    // Rounding of a far origin moves every crossing alike.
    const double scale = expected + 1e-3 * ray.origin.length() / ray.direction.length() * 0.7;
    const double error = std::abs(depth - expected) / scale;
    if (!(error < 1e-10)) {
      INFO("ray " << i << " from " << ray.origin << " along " << ray.direction << ": " << depth << " instead of "
                  << expected);
      CHECK(error < 1e-10);
    }
    worst = std::max(worst, error);
    sum += expected;
  }
  CHECK(sum > 0);
  CHECK(worst < 1e-10);
}

TEST_CASE("the walk reproduces the exact voxel step field a9", "[octree][walk][reference]") {
  const auto rows = read_csv("a9_voxel_step_field.csv");
  if (rows.empty()) {
    WARN("SKIPPED: ../shared/reference/a9_voxel_step_field.csv is absent");
    return;
  }
  const Octree tree = lossless(field_stream(Box3i(Vec3i(0), Vec3i(8)), {"k"}, [](int, const Vec3i& v) {
    return static_cast<float>((7 * v.x + 13 * v.y + 29 * v.z) % 11);  // whole numbers are exact in float
  }));
  const double weight[] = {0.1};
  for (const auto& row : rows) {
    INFO("ray " << row[0]);
    Ray ray{{row[1], row[2], row[3]}, {row[4], row[5], row[6]}};
    ray.direction.normalize();
    const double depth = optical_depth(tree, ray, weight);
    CHECK(depth == Approx(row[9]).epsilon(1e-11).margin(0));
    // Emission front to back, 1 + (i + 2j + 3k) mod 5 in each voxel, before a background of 1.25.
    double radiance = 0, transmission = 1;
    walk(tree, ray, [&](double begin, double end, const Walk& at) {
      const Vec3i v = at.cell().corner;
      const double tau = 0.1 * static_cast<double>(at.value(0)) * (end - begin);
      radiance += transmission * (1 + (v.x + 2 * v.y + 3 * v.z) % 5) * -std::expm1(-tau);
      transmission *= std::exp(-tau);
      return true;
    });
    CHECK(radiance == Approx(row[13]).epsilon(1e-11));
    CHECK(radiance + 1.25 * transmission == Approx(row[14]).epsilon(1e-11));
  }
}

TEST_CASE("the walk reproduces the box rays a2", "[octree][walk][reference]") {
  const auto rows = read_csv("a2_box_rays.csv");
  if (rows.empty()) {
    WARN("SKIPPED: ../shared/reference/a2_box_rays.csv is absent");
    return;
  }
  // 0.25 m voxels: the box is 8 x 4 x 2 of them.
  Affine to_metres;
  to_metres.setScale(Vec3d(0.25));
  const Octree tree = lossless(field_stream(
      Box3i(Vec3i(0), Vec3i(8, 4, 2)), {"k"}, [](int, const Vec3i&) { return 1.0f; }, to_metres));
  const double weight[] = {1.3};
  for (const auto& row : rows) {
    Ray ray{{row[0], row[1], row[2]}, {row[3], row[4], row[5]}};
    ray.direction.normalize();
    INFO("from " << ray.origin << " along " << ray.direction);
    const double depth = optical_depth(tree, transform_ray(tree.local_to_index(), ray), weight);
    // A ray in a face or edge of the box belongs to the voxel above it: on the upper faces that is outside.
    bool in_upper_face = false;
    const Vec3d size(2, 1, 0.5);
    for (int axis = 0; axis < 3; ++axis) {
      in_upper_face = in_upper_face || (ray.direction[axis] == 0 && ray.origin[axis] == size[axis]);
    }
    if (in_upper_face) {
      CHECK(depth == 0);
    } else {
      CHECK(depth == Approx(row[10]).epsilon(1e-12).margin(1e-14));
    }
  }
}

TEST_CASE("the walk reproduces the stacked layers a6", "[octree][walk][reference]") {
  std::ifstream file(test::shared_path("reference/a6_layers.csv"));
  if (!file) {
    WARN("SKIPPED: ../shared/reference/a6_layers.csv is absent");
    return;
  }
  std::string line;
  int cases = 0;
  while (std::getline(file, line)) {
    if (line.empty() || !std::isdigit(static_cast<unsigned char>(line[0]))) continue;
    std::istringstream cells(line);
    std::vector<std::string> row;
    for (std::string cell; std::getline(cells, cell, ',');) row.push_back(cell);
    std::vector<float> tau;
    std::istringstream taus(row[2]);
    for (float t; taus >> t;) tau.push_back(t);
    const int layers = static_cast<int>(tau.size());
    // Each layer is 1 m thick and three voxels wide and deep, seen from z = 0.
    const Octree tree = lossless(field_stream(Box3i(Vec3i(-1, -1, 0), Vec3i(2, 2, layers)), {"k"},
                                              [&](int, const Vec3i& v) { return tau[static_cast<std::size_t>(v.z)]; }));
    const double weight[] = {1.0};
    const double depth = optical_depth(tree, Ray{{0.5, 0.5, -3}, {0, 0, 1}}, weight);
    CHECK(std::exp(-depth) == Approx(std::stod(row[4])).epsilon(1e-5));  // 0.1 and 1e-6 are rounded to float
    double exact = 0;
    for (const float t : tau) exact += static_cast<double>(t);
    CHECK(depth == Approx(exact).epsilon(1e-14));
    ++cases;
  }
  CHECK(cases >= 5);
}

TEST_CASE("a free path ends where its optical depth is reached", "[octree][walk]") {
  const Box3i domain(Vec3i(-13, -30, 5), Vec3i(47, 42, 53));
  const Field field = patchwork(5);
  const Octree tree = lossless(field_stream(domain, {"soot", "water"}, field));
  const double weights[] = {0.3, 0.1};
  int collided = 0;
  for (std::uint64_t i = 0; i < 20000; ++i) {
    Ray ray = awkward_ray(domain, 6, i);
    Stream random(8, i, 0);
    const double target = -std::log(random.uniform());
    const double whole = optical_depth(tree, ray, weights);
    const FreePath path = free_path(tree, ray, weights, target);
    REQUIRE(path.collided == (whole >= target));
    ray.t_max = path.t;
    if (path.collided) {
      ++collided;
      CHECK(path.depth == target);
      CHECK(optical_depth(tree, ray, weights) == Approx(target).epsilon(1e-9).margin(1e-12));
    } else {
      CHECK(path.depth == Approx(whole).epsilon(1e-12).margin(1e-15));
    }
  }
  CHECK(collided > 5000);
  CHECK(free_path(tree, Ray{{0, 0, -5}, {0, 0, -1}}, weights, 1).collided == false);
}

TEST_CASE("a walk that stops at a coarser level keeps the optical depth on average", "[octree][walk]") {
  // Parallel rays through every voxel column see all the mass, at any level.
  const Box3i domain(Vec3i(0), Vec3i(40, 40, 40));
  const Octree tree = lossless(field_stream(domain, {"density"}, patchwork(9)));
  double fine = 0;
  for (const int level : {0, 1, 2, 3, 4, 6}) {
    double sum = 0;
    for (int y = 0; y < 40; ++y) {
      for (int x = 0; x < 40; ++x) {
        walk(
            tree, Ray{{x + 0.5, y + 0.5, -1}, {0, 0, 1}},
            [&](double begin, double end, const Walk& at) {
              sum += static_cast<double>(at.value(0)) * (end - begin);
              return true;
            },
            level);
      }
    }
    if (level == 0) fine = sum;
    CHECK(sum == Approx(fine).epsilon(1e-6));
  }
}

TEST_CASE("a walk may be told to stop and rays that miss have no segment", "[octree][walk]") {
  const Octree tree = lossless(field_stream(Box3i(Vec3i(0), Vec3i(16)), {"density"}, patchwork(11)));
  int visits = 0;
  walk(tree, Ray{{-1, 4.5, 4.5}, {1, 0, 0}}, [&](double, double, const Walk&) { return ++visits < 3; });
  CHECK(visits <= 3);
  for (const Ray& ray : {Ray{{-1, 20, 4}, {1, 0, 0}}, Ray{{-1, 4, 4}, {-1, 0, 0}}, Ray{{-1, 4, 4}, {1, 0, 0}, 30, 40},
                         Ray{{-1, 16, 4}, {1, 0, 0}}, Ray{{1e9, 1e9, 1e9}, {1, 1, 1}}}) {
    CHECK_FALSE(Walk(tree, ray).next());
  }
  const Octree nothing = lossless(field_stream(Box3i(Vec3i(0), Vec3i(0)), {"density"}, patchwork(11)));
  CHECK_FALSE(Walk(nothing, Ray{{-1, 0, 0}, {1, 0, 0}}).next());
  CHECK(nothing.block_count() == 0);
}
