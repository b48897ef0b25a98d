// The World on a uniform grid of cells, as discrete ordinates need it: coefficients averaged over each cell
// by the world walk, phase functions by their moments.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "photon/world/spectral_world.h"
#include "photon/world/world_walk.h"

namespace obscura {

/// Cells run x fastest. The grid has a frame of its own: metres from its lower corner, axes along those of
/// the cloud where there is one, of the World's periodic cell, else of the World.
class OrdinatesGrid {
 public:
  /// @param cells 0 along an axis: chosen, at most 32 on the longest side
  /// @param box   in world metres, for Worlds that do not repeat; absent: the bounds of the clouds
  /// @param lines sub-lines per cell and axis along which coefficients are averaged
  /// @throws InputError for a box without volume, or a box where clouds repeat
  OrdinatesGrid(SpectralWorld world, Vec3i cells, const std::optional<Box3d>& box, int lines = 4);

  const Vec3i& cells() const noexcept { return cells_; }
  std::size_t size() const noexcept { return extinction.size(); }
  /// Sides of a cell, m.
  const Vec3d& cell_m() const noexcept { return cell_m_; }
  double cell_volume() const noexcept { return cell_m_.x * cell_m_.y * cell_m_.z; }
  double face_area(int axis) const noexcept { return cell_volume() / cell_m_[axis]; }
  Vec3d extent_m() const noexcept { return Vec3d(cells_.x * cell_m_.x, cells_.y * cell_m_.y, cells_.z * cell_m_.z); }
  bool periodic(int axis) const noexcept { return periodic_[static_cast<std::size_t>(axis)]; }
  /// One cell of a World that repeats along this axis: nothing varies along it.
  bool uniform(int axis) const noexcept { return periodic(axis) && cells_[axis] == 1; }
  const Affine& world_to_grid() const noexcept { return world_to_grid_; }
  const Affine& grid_to_world() const noexcept { return grid_to_world_; }
  std::size_t index(const Vec3i& cell) const noexcept {
    return static_cast<std::size_t>((cell.z * cells_.y + cell.y) * cells_.x + cell.x);
  }
  Vec3i cell_at(std::size_t index) const noexcept {
    const auto i = static_cast<int>(index);
    return {i % cells_.x, i / cells_.x % cells_.y, i / (cells_.x * cells_.y)};
  }

  /// The degree up to which phase functions are not zero, at most `most`.
  int phase_degree(int most) const;
  /// Moments of the mixture in a cell times its scattering, 1/m, degrees 0 .. values.size() - 1.
  void scattering_moments(std::size_t cell, std::span<double> values) const noexcept;
  /// Phase function of the mixture in a cell, 1/sr; 0 where nothing scatters.
  double phase(std::size_t cell, double cosine) const noexcept;

  /// Per cell: 1/m, 1/m, W/m3/sr.
  std::vector<double> extinction, scattering, emission;

 private:
  void make_frame(const std::optional<Box3d>& box);
  void choose_cells(Vec3i cells);
  void find_phases();
  void resample(int lines);

  SpectralWorld world_;
  Vec3i cells_{1, 1, 1};
  Vec3d cell_m_{1, 1, 1};
  std::array<bool, 3> periodic_{false, false, false};
  Vec3d voxel_m_{0, 0, 0};  // of the only cloud, in the grid's frame
  Affine world_to_grid_, grid_to_world_;
  std::vector<const PhaseFunction*> phases_;
  std::vector<std::vector<int>> phase_of_;             // [cloud][part]
  std::vector<std::vector<double>> phase_scattering_;  // [phase][cell], where there are several
  std::vector<std::vector<double>> phase_moments_;     // [phase][degree]
};

/// The cells along a ray, front to back.
class CellCursor {
 public:
  CellCursor(const OrdinatesGrid& grid, const Ray& world_ray, double t) noexcept;

  /// The cell at t, or nothing outside the grid; t never decreases from call to call.
  std::optional<std::size_t> cell(double t) noexcept {
    while (end_ <= t) step();
    return here();
  }
  /// Where the cell of the last call ends.
  double end() const noexcept { return end_; }
  /// The corner of the present cell, as many periods away as the ray is, in the grid's frame, m.
  Vec3d corner() const noexcept;

 private:
  void step() noexcept;
  std::optional<std::size_t> here() const noexcept;
  double crossing(int axis) const noexcept;

  const OrdinatesGrid* grid_;
  Vec3d origin_, direction_;  // in cells
  std::array<double, 3> place_{};
  std::array<double, 3> next_{};
  double end_;
};

/// Walks the World's segments along a ray and cuts them where the grid's cells end.
/// visit(begin, end, optics, cell or nothing, cursor) -> go on?
template <class Visit>
void march(SpectralWorld world, const OrdinatesGrid& grid, const Ray& ray, Visit&& visit) {
  WorldWalk walk(world, ray);
  std::optional<CellCursor> cursor;
  while (walk.next()) {
    double t = walk.begin();
    if (!cursor) cursor.emplace(grid, ray, t);
    while (t < walk.end()) {
      const std::optional<std::size_t> cell = cursor->cell(t);
      const double end = std::min(walk.end(), cursor->end());
      if (!visit(t, end, walk.optics(), cell, *cursor)) return;
      t = end;
    }
  }
}

}  // namespace obscura
