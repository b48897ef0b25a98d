// A band whose response is 1, as the tables of Planck's law have it.
#pragma once

#include "photon/optics/planck.h"

namespace obscura::test {

inline WeightedPlanck band(double um_min, double um_max) { return {um_min, um_max, Spectrum::constant(1)}; }

/// W/m2/sr
inline double planck_band(double um_min, double um_max, double K) { return band(um_min, um_max).radiance(K); }

}  // namespace obscura::test
