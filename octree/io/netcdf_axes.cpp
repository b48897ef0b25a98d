// Roles, units and cells of axes.
#include "octree/io/netcdf_axes.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <map>

#include "octree/base/error.h"

namespace obscura::detail {
namespace {

std::string lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

bool one_of(const std::string& text, std::initializer_list<const char*> words) {
  return std::any_of(words.begin(), words.end(), [&](const char* word) { return text == word; });
}

double metres_per(const std::string& where, const FileAxis& axis) {
  const std::string unit = lower(axis.units);
  if (one_of(unit, {"m", "meter", "meters", "metre", "metres"})) return 1;
  if (one_of(unit, {"km", "kilometer", "kilometers", "kilometre", "kilometres"})) return 1000;
  if (one_of(unit, {"cm", "centimeter", "centimeters", "centimetre", "centimetres"})) return 0.01;
  if (one_of(unit, {"mm", "millimeter", "millimeters", "millimetre", "millimetres"})) return 0.001;
  if (unit.empty())
    throw InputError(where, fmt::format("coordinate '{}' has no units", axis.name),
                     "give it the units attribute m or km");
  throw InputError(where, fmt::format("coordinate '{}' is in '{}'", axis.name, axis.units),
                   "axes must be lengths (m or km); project degrees or pressure onto metres first");
}

}  // namespace

AxisRole role_of(const FileAxis& axis) {
  const std::string letter = lower(axis.axis);
  if (letter == "x") return AxisRole::x;
  if (letter == "y") return AxisRole::y;
  if (letter == "z") return AxisRole::z;
  if (letter == "t") return AxisRole::time;
  const std::string standard = lower(axis.standard_name);
  if (one_of(standard, {"projection_x_coordinate", "longitude", "grid_longitude"})) return AxisRole::x;
  if (one_of(standard, {"projection_y_coordinate", "latitude", "grid_latitude"})) return AxisRole::y;
  if (one_of(standard, {"altitude", "height", "height_above_reference_ellipsoid", "depth"})) return AxisRole::z;
  if (standard == "time") return AxisRole::time;
  const std::string unit = lower(axis.units);
  if (unit.find(" since ") != std::string::npos || one_of(unit, {"s", "sec", "seconds", "min", "h", "hours", "days"}))
    return AxisRole::time;
  const std::string name = lower(axis.name);
  if (one_of(name, {"time", "t", "times"})) return AxisRole::time;
  if (one_of(name, {"x", "xc", "xt", "xm", "nx", "west_east", "lon", "longitude", "easting", "ni"})) return AxisRole::x;
  if (one_of(name, {"y", "yc", "yt", "ym", "ny", "south_north", "lat", "latitude", "northing", "nj"}))
    return AxisRole::y;
  if (one_of(name, {"z", "zc", "zt", "zm", "nz", "bottom_top", "lev", "level", "height", "altitude", "alt", "nk"}))
    return AxisRole::z;
  return AxisRole::unknown;
}

LatticeAxis lattice_axis(const std::string& where, const FileAxis& axis) {
  const double metres = [&] {
    if (axis.points.empty())
      throw InputError(where, fmt::format("dimension '{}' has no coordinate variable", axis.name),
                       fmt::format("add a variable '{0}({0})' with the cell centres and units m or km", axis.name));
    return metres_per(where, axis);
  }();
  const int n = static_cast<int>(axis.points.size());
  if (n < 2)
    throw InputError(where,
                     fmt::format("coordinate '{}' has one point, which doesn't say how thick its cell is", axis.name),
                     "give at least two points");

  // Ascending order, whatever the file's.
  const bool down = axis.points.back() < axis.points.front();
  const auto in_file = [&](int i) { return down ? n - 1 - i : i; };
  std::vector<double> points;
  for (int i = 0; i < n; ++i) points.push_back(axis.points[static_cast<std::size_t>(in_file(i))] * metres);
  for (int i = 0; i < n; ++i)
    if (!std::isfinite(points[i]) || (i > 0 && !(points[i] > points[i - 1])))
      throw InputError(where,
                       fmt::format("coordinate '{}' neither ascends nor descends at point {}", axis.name, in_file(i)),
                       "sort it");

  LatticeAxis result;
  const double spacing = (points.back() - points.front()) / (n - 1);
  bool even = true;
  for (int i = 0; i < n; ++i) even = even && std::abs(points[i] - (points[0] + spacing * i)) <= 0.01 * spacing;
  if (even) {
    result.voxel_m = spacing;
    result.origin_m = points[0] - 0.5 * spacing;
    for (int i = 0; i < n; ++i) result.cells.push_back({{in_file(i), 1.0}});
    return result;
  }

  // Cell edges half way between points; the outer ones as far out as the inner ones are in.
  std::vector<double> edges{points[0] - 0.5 * (points[1] - points[0])};
  for (int i = 1; i < n; ++i) edges.push_back(0.5 * (points[i - 1] + points[i]));
  edges.push_back(points[n - 1] + 0.5 * (points[n - 1] - points[n - 2]));
  double thinnest = kInfinity;
  for (int i = 0; i < n; ++i) thinnest = std::min(thinnest, edges[i + 1] - edges[i]);
  const double length = edges.back() - edges.front();
  const double cells = std::ceil(length / thinnest * (1 - 1e-9));
  if (cells > 32.0 * n)
    throw InputError(
        where, fmt::format("coordinate '{}' has cells from {:.3g} m on over {:.3g} m", axis.name, thinnest, length),
        "too uneven for even cells; interpolate it to even spacing first");
  result.voxel_m = length / cells;
  result.origin_m = edges.front();
  int first = 0;
  for (int c = 0; c < static_cast<int>(cells); ++c) {
    const double low = edges.front() + c * result.voxel_m;
    const double high = low + result.voxel_m;
    while (first + 1 < n && edges[first + 1] <= low) ++first;
    std::vector<LatticeAxis::Share> shares;
    double total = 0;
    for (int i = first; i < n && edges[i] < high; ++i) {
      const double overlap = std::min(high, edges[i + 1]) - std::max(low, edges[i]);
      if (overlap <= 1e-9 * result.voxel_m) continue;
      shares.push_back({in_file(i), overlap});
      total += overlap;
    }
    for (auto& share : shares) share.weight /= total;
    result.cells.push_back(std::move(shares));
  }
  return result;
}

}  // namespace obscura::detail
