// Settings of discrete ordinates for layers that repeat.
#pragma once

#include "photon/ordinates.h"

namespace obscura::test {

inline OrdinatesSettings slab_settings(int cells, int order) {
  OrdinatesSettings settings;
  settings.cells = Vec3i(1, 1, cells);
  settings.order = order;
  settings.quadrature = AngularQuadrature::double_gauss;
  return settings;
}

}  // namespace obscura::test
