// What the tests of spheres and of boxes of the reference tables share: names of methods, and averages in other units.
#pragma once

#include "octree/base/statistics.h"

namespace obscura::test {

inline constexpr const char* kPhotons = "photon tracing";
inline constexpr const char* kPaths = "path tracer";

inline BatchMean scaled(const BatchMean& mean, double factor) {
  return {mean.mean * factor, mean.standard_error * factor};
}

}  // namespace obscura::test
