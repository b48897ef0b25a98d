// The axes of a NetCDF variable as a lattice of even cells, by the CF conventions (1.10, sections
// 4 and 5). Internal to the NetCDF reader; opens no file.
#pragma once

#include <string>
#include <vector>

#include "octree/base/math.h"

namespace obscura::detail {

/// What the file says about one dimension of a variable.
struct FileAxis {
  std::string name;  ///< of the dimension
  std::size_t length = 0;
  std::vector<double> points;              ///< of its coordinate variable; empty without one
  std::string units, axis, standard_name;  ///< attributes of the coordinate variable
};

enum class AxisRole { x, y, z, time, unknown };

/// By the axis attribute, the standard name, the units of time, or the name itself.
AxisRole role_of(const FileAxis& axis);

/// Even cells over the file's points, which are centres of cells. A point's cell ends half way to the
/// next point. Points that are even to 1 % are the cells themselves; otherwise even cells as thin as
/// the thinnest are laid over them, each the mean of what it covers: nothing is lost or made up.
struct LatticeAxis {
  double origin_m = 0;  ///< lower end of the first cell
  double voxel_m = 0;
  struct Share {
    int point;  ///< in the file's order
    double weight;
  };
  std::vector<std::vector<Share>> cells;
};

/// @param where for messages.
/// @throws InputError for axes without coordinates, in units other than lengths, or that don't ascend or descend.
LatticeAxis lattice_axis(const std::string& where, const FileAxis& axis);

}  // namespace obscura::detail
