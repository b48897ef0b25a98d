// Materials of surfaces by Kirchhoff's law: what is not emitted is reflected, in part like a mirror, in
// part like chalk. Formulas: photon/METHODS.md.
#pragma once

#include <algorithm>
#include <vector>

#include "octree/base/math.h"

namespace obscura {

/// What a surface is made of.
struct Material {
  std::vector<double> emissivity;  ///< one value per interval of the World, [0, 1]
  double specular = 0;             ///< share of the reflectance that is mirror-like, [0, 1]
  /// Standard deviation of a mirror's direction cosines, per axis; 0: a perfect mirror.
  double roughness = 0;
  /// Share of the light that passes straight through (a net); the rest meets the surface. [0, 1]
  double permeable = 0;
  /// The emissivity's factor at angles from the normal, linear in between, 0 .. 90 degrees, increasing.
  /// Empty: the same at all angles. The product is cut at 1.
  std::vector<double> angle_deg, angle_factor;
};
}  // namespace obscura
