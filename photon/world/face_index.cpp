#include "photon/world/face_index.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <bit>
#include <map>

#include "photon/world/surfaces.h"

namespace obscura {
namespace {

/// For each vertex the first one at the same position.
std::vector<std::uint32_t> weld(const std::vector<Vec3d>& vertices) {
  constexpr std::uint32_t kFree = ~std::uint32_t{0};
  const std::size_t mask = std::bit_ceil(2 * vertices.size() + 1) - 1;
  std::vector<std::uint32_t> table(mask + 1, kFree), first(vertices.size());
  for (std::uint32_t i = 0; i < vertices.size(); ++i) {
    std::uint64_t key = 0;
    for (int axis = 0; axis < 3; ++axis) {
      key = (key ^ std::bit_cast<std::uint64_t>(vertices[i][axis] + 0.0)) * 0x9e3779b97f4a7c15u;  // -0 is 0
      key ^= key >> 29;
    }
    std::size_t place = key & mask;
    while (table[place] != kFree && vertices[table[place]] != vertices[i]) place = (place + 1) & mask;
    if (table[place] == kFree) table[place] = i;
    first[i] = table[place];
  }
  return first;
}

/// The rings of sides between the same two places.
std::vector<std::uint32_t> join_sides(const Mesh& mesh) {
  const std::vector<std::uint32_t> place = weld(mesh.vertices);
  const auto ends = [&](std::uint32_t side) {
    const std::array<std::uint32_t, 3>& f = mesh.faces[side / 3];
    const std::uint32_t a = place[f[side % 3]], b = place[f[(side + 1) % 3]];
    return std::pair(std::min(a, b), std::max(a, b));
  };
  // Sides by their lower end (a counting sort), then the few of each by the other.
  const auto sides = static_cast<std::uint32_t>(3 * mesh.faces.size());
  std::vector<std::uint32_t> begin(mesh.vertices.size() + 1, 0), sorted(sides);
  for (std::uint32_t s = 0; s < sides; ++s) ++begin[ends(s).first + 1];
  for (std::size_t v = 1; v < begin.size(); ++v) begin[v] += begin[v - 1];
  std::vector<std::uint32_t> fill(begin.begin(), begin.end() - 1);
  for (std::uint32_t s = 0; s < sides; ++s) sorted[fill[ends(s).first]++] = s;
  std::vector<std::uint32_t> next(sides);
  tbb::parallel_for(std::size_t{0}, mesh.vertices.size(), [&](std::size_t v) {
    const auto low = sorted.begin() + begin[v], high = sorted.begin() + begin[v + 1];
    std::sort(low, high, [&](std::uint32_t a, std::uint32_t b) {
      return std::pair(ends(a).second, a) < std::pair(ends(b).second, b);
    });
    for (auto i = low; i != high;) {
      auto j = i;
      for (; j != high && ends(*j).second == ends(*i).second; ++j) next[*j] = j + 1 != high ? *(j + 1) : 0;
      next[*(j - 1)] = *i;
      i = j;
    }
  });
  return next;
}

}  // namespace

MeshIndex::MeshIndex(const Mesh& mesh) {
  std::vector<Box3d> boxes(mesh.faces.size());
  Box3d all;
  for (std::size_t f = 0; f < boxes.size(); ++f) {
    for (const std::uint32_t vertex : mesh.faces[f]) boxes[f].extendBy(mesh.vertices[vertex]);
    all.extendBy(boxes[f]);
  }
  if (!all.isEmpty()) middle = all.center();
  for (Box3d& box : boxes) {
    box.min -= middle;
    box.max -= middle;
  }
  tree = BoxTree(boxes);
  next_side = join_sides(mesh);
}

FaceIndex::FaceIndex(std::span<const Object> objects, std::span<const Affine> to_scene, std::span<const Ball> balls,
                     const Vec3d& origin)
    : objects_(objects), to_scene_(to_scene), balls_(balls), origin_(origin), of_object_(objects.size(), nullptr) {
  std::vector<Box3d> boxes;
  const auto add = [&](const Entry& entry, const Box3d& box) {
    entries_.push_back(entry);
    boxes.push_back(box);
    for (int axis = 0; axis < 3; ++axis) reach_ = std::max({reach_, std::abs(box.min[axis]), std::abs(box.max[axis])});
  };
  std::map<const Mesh*, const MeshIndex*> made;
  for (std::uint32_t i = 0; i < objects.size(); ++i) {
    const Mesh* mesh = objects[i].mesh.get();
    if (!mesh || mesh->faces.empty()) continue;
    const MeshIndex*& index = made[mesh];
    if (!index) index = meshes_.emplace_back(std::make_unique<MeshIndex>(*mesh)).get();
    of_object_[i] = index;
    Box3d box = bounds_of(objects[i]);
    // What rounding may have taken away.
    const double pad = 4 * std::numeric_limits<double>::epsilon() * (box.min.length() + box.max.length());
    add({i, nullptr}, {box.min - origin - Vec3d(pad), box.max - origin + Vec3d(pad)});
  }
  for (const Ball& ball : balls)
    add({ball.surface, &ball}, {ball.center - Vec3d(ball.radius), ball.center + Vec3d(ball.radius)});
  tree_ = BoxTree(boxes);
}

const Ball& FaceIndex::ball(std::uint32_t surface) const noexcept {
  return *std::lower_bound(balls_.begin(), balls_.end(), surface,
                           [](const Ball& ball, std::uint32_t s) { return ball.surface < s; });
}

std::size_t FaceIndex::bytes() const noexcept {
  std::size_t sum = tree_.bytes() + entries_.size() * sizeof(Entry);
  for (const auto& mesh : meshes_) sum += mesh->tree.bytes() + mesh->next_side.size() * sizeof(std::uint32_t);
  return sum;
}

}  // namespace obscura
