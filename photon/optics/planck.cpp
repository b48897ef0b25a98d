#include "photon/optics/planck.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "octree/base/math.h"
#include "photon/optics/quadrature.h"

namespace obscura {
namespace {

using Piece = WeightedPlanck::Piece;

// x = kC2 / (um K); band radiance = kBandScale K^4 * integral of x^3 / (e^x - 1) dx.
constexpr double kC2 = kPlanckConstant * kSpeedOfLight / kBoltzmannConstant * 1e6;  // um K
constexpr double kC1 = 2 * kPlanckConstant * kSpeedOfLight * kSpeedOfLight * 1e24;  // W um^4 /m2 /sr
constexpr double kBandScale = 2 * kBoltzmannConstant * (kBoltzmannConstant / kPlanckConstant) *
                              (kBoltzmannConstant / kPlanckConstant) * (kBoltzmannConstant / kPlanckConstant) /
                              (kSpeedOfLight * kSpeedOfLight);
constexpr double kSmallest = 1e-300;
// Where x is larger than this all over a band, its radiance is below the smallest number that counts.
constexpr double kDark = 1000;

// The integrand falls as e^-x: what lies this far beyond a piece's lower end is below rounding.
constexpr double kReach = 60;
// The nearest poles are at 2 pi i: on panels this wide, the points below reach rounding
// (photon/METHODS.md, "Planck").
constexpr double kPanel = 4;
constexpr double kShortPanel = 0.5;

struct Sums {
  double value = 0;   // integral of R x^3 / (e^x - 1) times e^(reference)
  double first = 0;   // the same, of the integrand times q = d ln B / d ln K
  double second = 0;  // the same, times K^2 B'' / B
};

// Adds one linear piece of the response at temperature K, scaled with e^(reference).
void add_piece(const Piece& piece, double K, double reference, Sums& sums) noexcept {
  static const GaussLegendre fine(12);
  static const GaussLegendre coarse(6);

  // The piece in x: its width comes from the difference of wavelengths, so that a narrow band keeps
  // its digits.
  const double low = kC2 / (piece.um_max * K);
  const double band_um = piece.um_max - piece.um_min;
  const double width = kC2 / K * band_um / (piece.um_max * piece.um_min);
  if (low - reference > 745) return;
  const double reach = std::min(width, kReach);
  const int panels = std::max(1, static_cast<int>(std::ceil(reach / kPanel)));
  const double step = reach / panels;
  const GaussLegendre& rule = step <= kShortPanel ? coarse : fine;

  for (int panel = 0; panel < panels; ++panel) {
    for (std::size_t i = 0; i < rule.node.size(); ++i) {
      const double above = (panel + rule.node[i]) * step;  // x - low
      const double x = low + above;
      const double decay = std::exp(reference - x);
      const double denominator = x < 0.5 ? -std::expm1(-x) : 1 - std::exp(-x);  // 1 - e^-x
      const double share = (width - above) * piece.um_min / (x * band_um);      // (um - um_min) / band
      const double response = piece.response_min + share * (piece.response_max - piece.response_min);
      const double q = x / denominator;
      const double term = rule.weight[i] * step * response * x * x * q * decay;
      sums.value += term;
      sums.first += term * q;
      sums.second += term * (q * q * (2 - denominator) - 2 * q);
    }
  }
}

double reference_of(std::span<const Piece> pieces, double K) noexcept { return kC2 / (pieces.front().um_max * K); }

Sums integrate(std::span<const Piece> pieces, double K, double reference) noexcept {
  Sums sums;
  for (const Piece& piece : pieces) add_piece(piece, K, reference, sums);
  return sums;
}

LogPlanck log_radiance(std::span<const Piece> pieces, double K) noexcept {
  if (pieces.empty()) return {-kInfinity, 0, 0};
  const double reference = reference_of(pieces, K);
  const Sums sums = integrate(pieces, K, reference);
  if (!(sums.value > 0)) return {-kInfinity, 0, 0};
  return {std::log(kBandScale) + 4 * std::log(K) + std::log(sums.value) - reference, sums.first / sums.value,
          sums.second / sums.value};
}

// kBandScale K^4 sum e^-reference in an order that neither under- nor overflows before the result.
double unscale(double sum, double K, double reference) noexcept {
  const double half = std::exp(-0.5 * reference);
  return kBandScale * (K * K) * (K * K) * sum * half * half;
}

double radiance(std::span<const Piece> pieces, double K) noexcept {
  if (!(K > 0) || pieces.empty()) return K != K ? K : 0.0;
  const double reference = reference_of(pieces, K);
  if (!(reference < kDark)) return 0;
  const double value = unscale(integrate(pieces, K, reference).value, K, reference);
  return value >= kSmallest ? value : 0.0;
}

double derivative(std::span<const Piece> pieces, double K) noexcept {
  if (!(K > 0) || pieces.empty()) return K != K ? K : 0.0;
  const double reference = reference_of(pieces, K);
  if (!(reference < kDark)) return 0;
  const double value = unscale(integrate(pieces, K, reference).first, K, reference) / K;
  return value >= kSmallest ? value : 0.0;
}

// ln(1 + e^a): proportional to 1 / K for a monochromatic radiance e^-a.
double log1p_exp(double a) noexcept { return a > 40 ? a : std::log1p(std::exp(a)); }

// Newton for ln L as a function of K^-p, with p from the second derivative: ln L is straight over
// 1/K (p = 1) in Wien's law and over ln K (p = 0) in a power law. Kept inside a bracket.
double invert(std::span<const Piece> pieces, double target) noexcept {
  if (!(target > 0) || pieces.empty()) return target != target ? target : 0.0;
  if (target == kInfinity) return kInfinity;

  // Start from the mean wavelength alone.
  double weight = 0, moment = 0;
  for (const Piece& p : pieces) {
    const double w = 0.5 * (p.um_max - p.um_min) * (p.response_min + p.response_max);
    weight += w;
    moment += w * 0.5 * (p.um_min + p.um_max);
  }
  const double um = moment / weight;
  const double log_target = std::log(target);
  double K = kC2 / (um * log1p_exp(std::log(kC1 * weight) - 5 * std::log(um) - log_target));

  double low = 0, high = kInfinity;
  for (int step = 0; step < 200; ++step) {
    const LogPlanck planck = log_radiance(pieces, K);
    const double gap = log_target - planck.log;
    if (gap > 0) {
      low = K;
    } else {
      high = K;
    }
    const double p = planck.slope - 1 - planck.second / planck.slope;  // -d ln(slope) / d ln K
    const double rise = gap / planck.slope;
    const double log_step = std::abs(p) < 1e-8 ? rise : -std::log1p(-p * rise) / p;
    double next = K * std::exp(log_step);
    if (std::abs(next - K) <= 1e-13 * K) return next;
    if (!(next > low && next < high)) {  // also where the step is not a number
      next = high == kInfinity ? 4 * K : low == 0 ? 0.25 * K : std::sqrt(low * high);
    }
    K = next;
  }
  return K;
}

}  // namespace

double planck_spectral(double um, double K) noexcept {
  if (!(K > 0)) return K != K ? K : 0.0;
  const double x = kC2 / (um * K);
  const double scale = kC1 / (um * um * um * um * um);
  const double half = std::exp(-0.5 * x);
  const double value = x > 1 ? scale * half / (1 - std::exp(-x)) * half : scale / std::expm1(x);
  return value >= kSmallest ? value : 0.0;
}

double brightness_temperature(double um, double spectral_radiance) noexcept {
  if (!(spectral_radiance > 0)) return spectral_radiance != spectral_radiance ? spectral_radiance : 0.0;
  const double a = std::log(kC1) - 5 * std::log(um) - std::log(spectral_radiance);
  const double ratio = kC1 / (um * um * um * um * um) / spectral_radiance;
  return kC2 / um / (ratio < 1e300 ? std::log1p(ratio) : log1p_exp(a));
}

WeightedPlanck::WeightedPlanck(double um_min, double um_max, const Spectrum& response) {
  const std::vector<double> cuts = linear_pieces(response, Spectrum(1), um_min, um_max);
  for (std::size_t i = cuts.size(); i-- > 1;) {
    const Piece piece{cuts[i - 1], cuts[i], response.value(cuts[i - 1]), response.value(cuts[i])};
    if (piece.response_min > 0 || piece.response_max > 0) pieces_.push_back(piece);
  }
}

double WeightedPlanck::radiance(double K) const noexcept { return obscura::radiance(pieces_, K); }

double WeightedPlanck::derivative(double K) const noexcept { return obscura::derivative(pieces_, K); }

double WeightedPlanck::brightness_temperature(double radiance) const noexcept { return invert(pieces_, radiance); }

LogPlanck WeightedPlanck::log_radiance(double K) const noexcept { return obscura::log_radiance(pieces_, K); }

}  // namespace obscura
