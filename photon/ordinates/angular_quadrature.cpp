#include "photon/ordinates/angular_quadrature.h"

#include <algorithm>

#include "octree/base/error.h"
#include "photon/optics/quadrature.h"

namespace obscura {
namespace {

/// The first level of LQn and the weights of its classes of points, summing to 1 over an octant. They solve
/// the moments of all symmetric polynomials of degree N - 2 and that of z^N (Newton's method in double).
struct LevelSymmetric {
  int order;
  double first_level;
  std::vector<double> weights;  // classes by their sorted levels (i, j, k), in lexicographic order
};

const std::vector<LevelSymmetric>& level_symmetric_tables() {
  static const std::vector<LevelSymmetric> tables{
      {2, 0.5773502691896258, {1.0}},
      {4, 0.3500211745815405, {0.3333333333333333}},
      {6, 0.2666354015167045, {0.1761261308633833, 0.15720720246995}},
      {8, 0.21821789023599106, {0.1209876543209865, 0.0907407407407411, 0.0925925925925935}},
      {10, 0.18932132647803104, {0.0893031479843731, 0.0725291517123509, 0.0450437674364324, 0.0539281144878262}},
      {12,
       0.16721265282272985,
       {0.0707625899701005, 0.0558811015648858, 0.037337673758834, 0.0502819010600321, 0.025851291655761}},
      {14,
       0.1519858614606598,
       {0.0579970408967504, 0.0489007976370723, 0.0227935342406351, 0.0394132005955454, 0.0380990861441239,
        0.0258394076420986, 0.0082695799719053}},
      {16,
       0.13895687506790827,
       {0.0489872391581139, 0.041329597869767, 0.0203032007394514, 0.0265500757813369, 0.0379074407957155,
        0.0135295047784926, 0.0326369372027988, 0.0103769578386092}},
      {18,
       0.1293445045444208,
       {0.0422646448834642, 0.0376127473840386, 0.0122691351592904, 0.0324188352636263, 0.0066443861363606,
        0.0312093838452434, 0.0160127252688755, 0.0200484595317339, 0.0001114093995495, 0.0163797038535862}}};
  return tables;
}

void add_level_symmetric(const LevelSymmetric& table, std::vector<Vec3d>& directions, std::vector<double>& weights) {
  const int levels = table.order / 2;
  std::vector<double> cosine{table.first_level};
  const double first = table.first_level * table.first_level;
  const double step = table.order > 2 ? 2 * (1 - 3 * first) / (table.order - 2) : 0.0;
  for (int i = 1; i < levels; ++i) cosine.push_back(std::sqrt(first + i * step));
  // Classes in the order of the table.
  std::vector<std::array<int, 3>> classes;
  for (int i = 0; i < levels; ++i) {
    for (int j = i; j < levels; ++j) {
      const int k = levels - 1 - i - j;
      if (k >= j) classes.push_back({i, j, k});
    }
  }
  for (int k = 0; k < levels; ++k) {
    for (int j = 0; j + k < levels; ++j) {
      std::array<int, 3> sorted{levels - 1 - j - k, j, k};
      directions.emplace_back(cosine[static_cast<std::size_t>(sorted[0])], cosine[static_cast<std::size_t>(j)],
                              cosine[static_cast<std::size_t>(k)]);
      std::sort(sorted.begin(), sorted.end());
      const auto place = std::find(classes.begin(), classes.end(), sorted) - classes.begin();
      weights.push_back(table.weights[static_cast<std::size_t>(place)]);
    }
  }
}

/// A level at the cosine to z, with equally spaced azimuths in the quadrant.
void add_level(double cosine, double weight, int azimuths, std::vector<Vec3d>& directions,
               std::vector<double>& weights) {
  const double sine = std::sqrt((1 - cosine) * (1 + cosine));
  for (int j = 0; j < azimuths; ++j) {
    const double phi = 0.5 * kPi * (j + 0.5) / azimuths;
    directions.emplace_back(sine * std::cos(phi), sine * std::sin(phi), cosine);
    weights.push_back(weight / azimuths);
  }
}

}  // namespace

OrdinateSet::OrdinateSet(AngularQuadrature kind, int order) : order_(order) {
  if (order < 2 || order > 32 || order % 2 != 0) {
    throw InputError("ordinates",
                     "order " + std::to_string(order) + " of the angular quadrature is not even or not in 2 .. 32",
                     "choose 8 or 16");
  }
  const int levels = order / 2;
  moment_order_ = order - 1;
  if (kind == AngularQuadrature::level_symmetric && order <= level_symmetric_tables().back().order) {
    for (const LevelSymmetric& table : level_symmetric_tables()) {
      if (table.order == order) add_level_symmetric(table, magnitude_, weight_);
    }
    moment_order_ = std::max(1, order / 2);
  } else {
    const GaussLegendre gauss(kind == AngularQuadrature::double_gauss ? levels : order);
    for (int i = 0; i < levels; ++i) {
      const bool half = kind == AngularQuadrature::double_gauss;
      const auto n = static_cast<std::size_t>(half ? i : levels + i);
      const double cosine = half ? gauss.node[n] : 2 * gauss.node[n] - 1;
      // Two more than a triangle has: near the pole few azimuths do, but not one.
      const int azimuths = kind == AngularQuadrature::level_symmetric ? levels - i + 2 : levels;
      add_level(cosine, (half ? 1.0 : 2.0) * gauss.weight[n], azimuths, magnitude_, weight_);
    }
    if (kind == AngularQuadrature::double_gauss) moment_order_ = std::max(1, order - 2);
  }
  double sum = 0;
  for (const double weight : weight_) sum += weight;
  for (double& weight : weight_) weight *= 0.5 * kPi / sum;
  for (int axis = 0; axis < 3; ++axis) {
    for (std::size_t i = 0; i < weight_.size(); ++i)
      half_flux_[static_cast<std::size_t>(axis)] += 4 * weight_[i] * magnitude_[i][axis];
  }
}

Vec3d OrdinateSet::direction(int octant, int i) const noexcept {
  Vec3d result = magnitude(i);
  for (int axis = 0; axis < 3; ++axis) {
    if (octant >> axis & 1) result[axis] = -result[axis];
  }
  return result;
}

void spherical_harmonics(const Vec3d& direction, int order, double* values) noexcept {
  const double z = direction.z;
  // (x + i y)^m carries sin^m of the polar angle, so that nothing divides by it (Sloan, JCGT 2(2), 2013).
  double real = 1, imaginary = 0;
  double sectoral = std::sqrt(1 / (4 * kPi));
  for (int m = 0; m <= order; ++m) {
    double before = 0, now = sectoral;
    for (int l = m; l <= order; ++l) {
      const double scale = m == 0 ? 1.0 : std::numbers::sqrt2;
      values[l * (l + 1) + m] = scale * now * real;
      if (m > 0) values[l * (l + 1) - m] = scale * now * imaginary;
      const double next_l = l + 1;
      const double a = std::sqrt((4 * next_l * next_l - 1) / (next_l * next_l - m * m));
      const double b = std::sqrt(((next_l - 1) * (next_l - 1) - m * m) / (4 * (next_l - 1) * (next_l - 1) - 1));
      const double next = a * (z * now - (l > m ? b * before : 0.0));
      before = now;
      now = next;
    }
    const double turned = real * direction.x - imaginary * direction.y;
    imaginary = real * direction.y + imaginary * direction.x;
    real = turned;
    sectoral *= std::sqrt((2.0 * m + 3) / (2.0 * m + 2));
  }
}

}  // namespace obscura
