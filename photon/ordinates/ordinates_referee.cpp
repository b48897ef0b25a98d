#include "photon/ordinates/ordinates_referee.h"

#include <algorithm>
#include <cmath>

#include "octree/base/error_scale.h"

namespace obscura {
namespace {

/// Of the error that order N is never trusted below: this over N^2.
constexpr double kLeastOfOrder = 0.02;
/// Most cells along an axis where none are asked for.
constexpr int kMostCells = 32;

/// Whether all cells of a grid are the same along an axis.
bool same_along(const OrdinatesGrid& grid, int axis) {
  for (std::size_t i = 0; i < grid.size(); ++i) {
    Vec3i first = grid.cell_at(i);
    first[axis] = 0;
    const std::size_t j = grid.index(first);
    const auto same = [&](const std::vector<double>& values) {
      return std::abs(values[i] - values[j]) <= 1e-9 * std::abs(values[j]);
    };
    if (!same(grid.extinction) || !same(grid.scattering) || !same(grid.emission)) return false;
  }
  return true;
}

}  // namespace

Vec3i ordinates_cells(const World& world, int longest) {
  // A prime number of cells tells whether anything varies.
  Vec3i asked(0);
  if (world.periodic()) {
    const OrdinatesGrid trial({world, 0}, Vec3i(13, 13, 0), std::nullopt, 2);
    for (int axis = 0; axis < 2; ++axis) asked[axis] = trial.periodic(axis) && same_along(trial, axis) ? 1 : 0;
  }
  Vec3i cells = OrdinatesGrid({world, 0}, asked, std::nullopt, 1).cells();
  const int most = std::max({cells.x, cells.y, cells.z});
  if (longest == 0 && 2 * most > kMostCells) return cells;
  const double factor = longest == 0 ? 2 : static_cast<double>(longest) / most;
  for (int axis = 0; axis < 3; ++axis) {
    if (asked[axis] != 1 && cells[axis] > 1)
      cells[axis] = std::max(1, static_cast<int>(std::lround(cells[axis] * factor)));
  }
  return cells;
}

OrdinatesReferee::OrdinatesReferee(SpectralWorld world, const OrdinatesSettings& settings, const Progress& progress)
    : tolerance_(settings.tolerance) {
  solutions_.push_back(solve_ordinates(world, settings, progress));
  OrdinatesSettings coarse = settings;
  for (int axis = 0; axis < 3; ++axis) coarse.cells[axis] = std::max(1, (finest().grid().cells()[axis] + 1) / 2);
  coarse.gather = std::max(1, settings.gather / 2);
  solutions_.push_back(solve_ordinates(world, coarse, progress));
  coarse.order = std::max(2, settings.order / 4 * 2);
  solutions_.push_back(solve_ordinates(world, coarse, progress));
}

OrdinatesEstimate OrdinatesReferee::combine(double fine, double coarse, double low, double share) const noexcept {
  // Second order in the cells: a third of the difference is left, and taken off. Orders converge faster than
  // that where light is smooth and slower where it is not: their difference is only counted.
  const double space = (fine - coarse) / 3, angle = (coarse - low) * 2 / 3;
  // Where two orders happen to agree, what is typical of smooth light remains.
  const double order = finest().ordinates().order();
  const double least = tolerance_ + kLeastOfOrder * share / (order * order);
  return {fine + space, std::hypot(space, angle, least * fine)};
}

OrdinatesEstimate OrdinatesReferee::fluence_at(const Vec3d& point) const {
  const OrdinatesEstimate fine = solutions_[0].fluence_at(point), coarse = solutions_[1].fluence_at(point),
                          low = solutions_[2].fluence_at(point);
  OrdinatesEstimate result = combine(fine.value, coarse.value, low.value);
  result.error = std::hypot(result.error, fine.error);
  return result;
}

OrdinatesEstimate OrdinatesReferee::left(int axis, int side) const noexcept {
  const auto of = [&](std::size_t n) {
    return solutions_[n].powers().left[static_cast<std::size_t>(axis)][static_cast<std::size_t>(side)];
  };
  return combine(of(0), of(1), of(2));
}

OrdinatesEstimate OrdinatesReferee::absorbed() const noexcept {
  const auto of = [&](std::size_t n) {
    return solutions_[n].powers().absorbed + solutions_[n].powers().first_absorbed;
  };
  return combine(of(0), of(1), of(2));
}

void OrdinatesReferee::radiance(std::span<const Ray> rays, std::span<OrdinatesEstimate> estimates,
                                std::span<Incoming> incoming) const {
  std::vector<Incoming> in[3];
  for (std::size_t n = 0; n < 3; ++n) {
    in[n].resize(rays.size());
    solutions_[n].radiance(rays, in[n]);
  }
  double brightest = 0;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    estimates[i] = combine(in[0][i].direct, in[1][i].direct, in[2][i].direct, 1 - in[0][i].transmission);
    estimates[i].value = std::max(estimates[i].value, 0.0);
    brightest = std::max(brightest, std::abs(estimates[i].value));
    if (i < incoming.size()) incoming[i] = in[0][i];
  }
  double squares = 0;
  std::size_t counted = 0;
  const auto scale = [&](const OrdinatesEstimate& e) { return error_scale(e.value, brightest); };
  for (std::size_t i = 0; i < rays.size(); ++i) {
    // Rays that meet nothing are exact and typical of nothing.
    if (!(estimates[i].error > tolerance_ * scale(estimates[i]))) continue;
    squares += estimates[i].error * estimates[i].error / (scale(estimates[i]) * scale(estimates[i]));
    ++counted;
  }
  const double typical = counted > 0 ? std::sqrt(squares / static_cast<double>(counted)) : 0.0;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const double share = 1 - in[0][i].transmission;
    estimates[i].error = std::hypot(estimates[i].error, typical * share * scale(estimates[i]), in[0][i].bias);
  }
}

}  // namespace obscura
