// How errors fall with what they cost: the slopes of the methods, with standard errors, beside what theory says.
#include <cstdio>
#include <string>

#include "tests/support/convergence.h"

using namespace obscura;
using namespace obscura::test;

namespace {

void print(const std::string& name, const std::string& theory, const std::vector<ErrorAt>& measured) {
  const Slope slope = slope_of(measured);
  std::printf("| %s | %s | %.3f +- %.3f |", name.c_str(), theory.c_str(), slope.value, slope.standard_error);
  for (const ErrorAt& m : measured) std::printf(" %.3g: %.2e", m.setting, m.error);
  std::printf(" |\n");
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char**) {
  const int effort = argc > 1 ? 1 : 8;
  std::printf("| error | theory | slope | measured |\n|---|---|---|---|\n");
  print("path tracer, over flights", "-1/2", path_errors(1, 4 * effort));
  LocalLight middle, face, plain;
  face.shift = plain.shift = 1;
  face.face = plain.face = true;
  plain.edge_correction = false;
  print("photon map: noise over k, one radius", "-1/2", density_noise(middle, 250 * effort));
  print("bias over k / N, inside", "2/3", density_bias(middle, 250 * effort));
  print("bias over k / N, at a face", "2/3", density_bias(face, 250 * effort));
  print("bias over k / N, at a face, uncorrected", "1/3", density_bias(plain, 250 * effort));
  print("total over N, k = 8 N^(4/7)", "-2/7", density_total(middle, 8, 4.0 / 7, 120 * effort));
  print("total over N, k = 64", "0 to -1/2", density_total(middle, 64, 0, 120 * effort));
  print("ordinates in cells, slab", "-2", ordinates_in_cells());
  print("ordinates in N, slab, isotropic", "-2 or faster", ordinates_in_angle(0));
  print("ordinates in N, slab, g = 0.5", "-2 or faster", ordinates_in_angle(0.5));
}
