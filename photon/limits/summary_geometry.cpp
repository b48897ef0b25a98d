#include "photon/limits/summary_geometry.h"

#include <algorithm>
#include <map>

namespace obscura::detail {
namespace {

std::vector<Vec3d> corners_of(const Box3d& box, const Affine& map) {
  std::vector<Vec3d> corners;
  for (int k = 0; k < 8; ++k) {
    corners.push_back(transform_point(
        map, {k & 1 ? box.max.x : box.min.x, k & 2 ? box.max.y : box.min.y, k & 4 ? box.max.z : box.min.z}));
  }
  return corners;
}

Box3d box_of(const Object& object) {
  if (!object.mesh) return {Vec3d(-object.radius), Vec3d(object.radius)};
  Box3d box;
  for (const Vec3d& vertex : object.mesh->vertices) box.extendBy(vertex);
  return box;
}

/// The corners of each cloud's box, each object's, each sphere's, in this order; of a cloud that holds nothing none.
std::vector<std::vector<Vec3d>> boxes_of(const World& world) {
  std::vector<std::vector<Vec3d>> boxes;
  for (int c = 0; c < world.cloud_count(); ++c) boxes.push_back(detail::corners_of(world, c));
  for (const Object& object : world.objects()) boxes.push_back(corners_of(box_of(object), object.local_to_world));
  for (const HotSphere& sphere : world.spheres())
    boxes.push_back(corners_of({sphere.center - Vec3d(sphere.radius), sphere.center + Vec3d(sphere.radius)}, {}));
  return boxes;
}

/// The view's origins and the corners of everything but one object.
std::vector<Vec3d> all_corners(const World& world, const CameraView& view, std::size_t but) {
  std::vector<Vec3d> points = view.origins;
  const std::vector<std::vector<Vec3d>> boxes = boxes_of(world);
  const auto clouds = static_cast<std::size_t>(world.cloud_count());
  for (std::size_t b = 0; b < boxes.size(); ++b) {
    const bool left_out = b >= clouds && b - clouds == but && but < world.objects().size();
    if (!left_out) points.insert(points.end(), boxes[b].begin(), boxes[b].end());
  }
  return points;
}

/// A parallelogram that lets nothing through.
struct Sheet {
  Vec3d corner, side_u, side_v;
};

std::optional<Sheet> sheet_of(const World& world, const Object& object) {
  if (!object.mesh || object.mesh->faces.size() != 2 || object.mesh->vertices.size() != 4) return std::nullopt;
  for (const int slot : object.materials) {
    if (world.materials()[static_cast<std::size_t>(slot)].permeable > 0) return std::nullopt;
  }
  std::array<Vec3d, 4> v;
  for (std::size_t k = 0; k < 4; ++k) v[k] = transform_point(object.local_to_world, object.mesh->vertices[k]);
  const auto& f = object.mesh->faces;
  const bool fan = f[0] == std::array<std::uint32_t, 3>{0, 1, 2} && f[1] == std::array<std::uint32_t, 3>{0, 2, 3};
  if (!fan || (v[0] + v[2] - v[1] - v[3]).length() > 1e-9 * (v[2] - v[0]).length()) return std::nullopt;
  return Sheet{v[0], v[1] - v[0], v[3] - v[0]};
}

/// Each directed edge of each triangle is once there, and once the other way round; and they enclose a volume outward.
bool closed(const Mesh& mesh) {
  constexpr std::size_t kMostFaces = 20000;
  if (mesh.faces.size() < 4 || mesh.faces.size() > kMostFaces) return false;
  const auto key = [](const Vec3d& p) { return std::array<double, 3>{p.x, p.y, p.z}; };
  std::map<std::array<std::array<double, 3>, 2>, int> edges;
  double volume = 0;
  for (const auto& face : mesh.faces) {
    const Vec3d &a = mesh.vertices[face[0]], &b = mesh.vertices[face[1]], &c = mesh.vertices[face[2]];
    volume += (a - mesh.vertices.front()).dot((b - mesh.vertices.front()).cross(c - mesh.vertices.front()));
    ++edges[{key(a), key(b)}];
    ++edges[{key(b), key(c)}];
    ++edges[{key(c), key(a)}];
  }
  for (const auto& [edge, count] : edges) {
    const auto back = edges.find({edge[1], edge[0]});
    if (count != 1 || back == edges.end() || back->second != 1) return false;
  }
  return volume > 0;
}

}  // namespace

std::vector<Vec3d> corners_of(const World& world, int cloud) {
  const Box3d& box = world.frame(cloud).local_bounds;
  if (box.isEmpty()) return {};
  return corners_of(box, world.clouds()[static_cast<std::size_t>(cloud)].local_to_world);
}

bool outside(const CameraView& view, const std::vector<Vec3d>& points) {
  if (points.empty()) return true;
  return std::any_of(view.sides.begin(), view.sides.end(), [&](const ViewSide& side) {
    return std::all_of(points.begin(), points.end(), [&](const Vec3d& p) {
      return (p - side.through).dot(side.inward) < -1e-9 * (p - side.through).length();
    });
  });
}

std::optional<Box3d> box_out_of_view(const World& world, const CameraView& view) {
  if (world.periodic()) return std::nullopt;
  Box3d all;
  for (const std::vector<Vec3d>& corners : boxes_of(world)) {
    if (corners.empty()) continue;
    if (!outside(view, corners)) return std::nullopt;
    for (const Vec3d& corner : corners) all.extendBy(corner);
  }
  return all.isEmpty() ? std::nullopt : std::optional(all);
}

double reach(const World& world, const CameraView& view) {
  if (world.periodic()) return kInfinity;
  Box3d box;
  for (const Vec3d& point : all_corners(world, view, world.objects().size())) box.extendBy(point);
  return box.isEmpty() ? 0.0 : box.size().length();
}

bool sees_disc(const CameraView& view, const Sun& sun) {
  if (!(sun.diameter > 0)) return false;  // rays miss points
  const double sine = std::sin(std::min(0.5 * sun.diameter, 0.5 * kPi)) + 1e-6;
  return std::all_of(view.sides.begin(), view.sides.end(),
                     [&](const ViewSide& side) { return sun.toward.dot(side.inward) >= -sine; });
}

bool shaded(const World& world, const CameraView& view, const Sun& sun) {
  if (world.periodic()) return false;
  for (std::size_t o = 0; o < world.objects().size(); ++o) {
    const std::optional<Sheet> sheet = sheet_of(world, world.objects()[o]);
    if (!sheet) continue;
    const Vec3d across = sheet->side_u.cross(sheet->side_v);
    const Vec3d normal = across.normalized();
    const double cosine = normal.dot(sun.toward);
    // A sheet keeps off no light that comes along it.
    const double widest = std::sin(std::min(0.5 * sun.diameter, 0.5 * kPi));
    if (std::abs(cosine) < 2 * widest + 1e-3) continue;
    const std::vector<Vec3d> points = all_corners(world, view, o);
    const bool all = std::all_of(points.begin(), points.end(), [&](const Vec3d& p) {
      const double t = (sheet->corner - p).dot(normal) / cosine;  // towards the sun
      const double size = sheet->side_u.length() + sheet->side_v.length() + (p - sheet->corner).length();
      if (!(t > 1e-6 * size)) return false;
      // Where the ray towards another place of the disc meets the sheet's plane, at most so far from the foot below.
      const double spread = t * 2 * widest / (std::abs(cosine) * (std::abs(cosine) - widest)) + 1e-6 * size;
      const Vec3d foot = p + t * sun.toward - sheet->corner;
      // The foot in shares of the two sides: 0 to 1 is inside.
      const double u = foot.cross(sheet->side_v).dot(normal) / across.length();
      const double v = sheet->side_u.cross(foot).dot(normal) / across.length();
      const double height_u = across.length() / sheet->side_v.length(),
                   height_v = across.length() / sheet->side_u.length();
      return std::min(u, 1 - u) * height_u > spread && std::min(v, 1 - v) * height_v > spread;
    });
    if (all) return true;
  }
  return false;
}

bool no_dark_backs(const World& world, const CameraView& view) {
  return std::all_of(world.objects().begin(), world.objects().end(), [&](const Object& object) {
    if (object.double_sided) return true;
    for (const int slot : object.materials) {
      if (world.materials()[static_cast<std::size_t>(slot)].permeable > 0) return false;
    }
    if (object.mesh && !closed(*object.mesh)) return false;
    Box3d box;
    for (const Vec3d& corner : corners_of(box_of(object), object.local_to_world)) box.extendBy(corner);
    Box3d origins;
    for (const Vec3d& origin : view.origins) origins.extendBy(origin);
    return !origins.isEmpty() && !box.intersects(origins);
  });
}

}  // namespace obscura::detail
