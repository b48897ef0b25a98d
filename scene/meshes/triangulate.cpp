// Polygons into triangles.
#include "scene/meshes/mesh_formats.h"

namespace obscura::detail {
namespace {

struct Point {
  double x, y;
};

// Twice the area of a triangle, above 0 where it is counter-clockwise.
double area2(const Point& a, const Point& b, const Point& c) noexcept {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

bool inside(const Point& p, const Point& a, const Point& b, const Point& c) noexcept {
  return area2(a, b, p) >= 0 && area2(b, c, p) >= 0 && area2(c, a, p) >= 0;
}

// The polygon seen along the axis on which it is largest, counter-clockwise.
std::vector<Point> flattened(std::span<const Vec3d> vertices, std::span<const std::uint32_t> corners) {
  Vec3d normal(0);
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vec3d a = vertices[corners[i]] - vertices[corners[0]];
    const Vec3d b = vertices[corners[(i + 1) % corners.size()]] - vertices[corners[0]];
    normal += a.cross(b);
  }
  int axis = 0;
  for (int k = 1; k < 3; ++k) {
    if (std::abs(normal[k]) > std::abs(normal[axis])) axis = k;
  }
  const int u = (axis + 1) % 3, v = (axis + 2) % 3;
  std::vector<Point> points;
  for (const std::uint32_t corner : corners) {
    const Vec3d p = vertices[corner] - vertices[corners[0]];
    points.push_back(normal[axis] >= 0 ? Point{p[u], p[v]} : Point{p[v], p[u]});
  }
  return points;
}

}  // namespace

void triangulate(std::span<const Vec3d> vertices, std::span<const std::uint32_t> corners,
                 std::vector<std::array<std::uint32_t, 3>>& triangles) {
  const std::vector<Point> points = flattened(vertices, corners);
  std::vector<std::size_t> left(corners.size());
  for (std::size_t i = 0; i < left.size(); ++i) left[i] = i;

  const auto is_ear = [&](std::size_t i) {
    const std::size_t n = left.size();
    const Point &a = points[left[(i + n - 1) % n]], &b = points[left[i]], &c = points[left[(i + 1) % n]];
    if (!(area2(a, b, c) > 0)) return false;
    for (std::size_t k = 0; k < n; ++k) {
      if (k == i || k == (i + 1) % n || k == (i + n - 1) % n) continue;
      const Point& p = points[left[k]];
      // Only a corner that bends inward can reach into the ear.
      if (area2(points[left[(k + n - 1) % n]], p, points[left[(k + 1) % n]]) < 0 && inside(p, a, b, c)) return false;
    }
    return true;
  };
  std::size_t next = 1;
  while (left.size() > 3) {
    const std::size_t n = left.size();
    std::size_t ear = next % n;
    std::size_t tried = 0;
    while (tried < n && !is_ear(ear)) {
      ear = (ear + 1) % n;
      ++tried;
    }
    if (tried == n) ear = next % n;  // degenerate or crossing itself: any cut will do
    triangles.push_back({corners[left[(ear + n - 1) % n]], corners[left[ear]], corners[left[(ear + 1) % n]]});
    left.erase(left.begin() + static_cast<std::ptrdiff_t>(ear));
    next = ear % left.size();
  }
  triangles.push_back({corners[left[0]], corners[left[1]], corners[left[2]]});
}

}  // namespace obscura::detail
