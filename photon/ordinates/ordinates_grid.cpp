#include "photon/ordinates/ordinates_grid.h"

#include <tbb/parallel_for.h>

#include <algorithm>

#include "octree/base/error.h"

namespace obscura {

OrdinatesGrid::OrdinatesGrid(SpectralWorld world, Vec3i cells, const std::optional<Box3d>& box, int lines)
    : world_(world) {
  if (box && world->periodic()) {
    throw InputError("ordinates", "a box is given for clouds that repeat", "leave the box out: the grid is one period");
  }
  make_frame(box);
  choose_cells(cells);
  find_phases();
  resample(std::max(1, lines));
}

void OrdinatesGrid::make_frame(const std::optional<Box3d>& box) {
  // Axes: those of the only cloud, else of the map, which are the periodic cell's or the World's.
  Affine axes = world_->map_to_world();
  Box3d bounds;
  const bool one = world_->cloud_count() == 1 && !box && !world_->frame(0).local_bounds.isEmpty();
  if (one) {
    const Cloud& cloud = world_->clouds().front();
    double scale = 1;
    for (int a = 0; a < 3; ++a) {
      Vec3d side(cloud.local_to_world[a][0], cloud.local_to_world[a][1], cloud.local_to_world[a][2]);
      scale = side.length();
      for (int i = 0; i < 3; ++i) axes[a][i] = side[i] / scale;
    }
    const CloudFrame& frame = world_->frame(0);
    const Vec3d corner = transform_point(cloud.local_to_world, frame.local_bounds.min);
    for (int i = 0; i < 3; ++i) axes[3][i] = corner[i];
    bounds = Box3d(Vec3d(0), scale * frame.local_bounds.size());
    for (int a = 0; a < 3; ++a) {
      Vec3d unit(0);
      unit[a] = scale;
      voxel_m_[a] = 1 / (transform_direction(cloud.octree->local_to_index(), unit / (scale * scale)).length());
    }
  } else {
    // Where there is no cloud any grid is right.
    const Box3d nothing(world_->origin() - Vec3d(0.5), world_->origin() + Vec3d(0.5));
    const Box3d in_world = box ? *box : world_->cloud_bounds().isEmpty() ? nothing : world_->cloud_bounds();
    if (box) {
      axes.makeIdentity();
      axes.setTranslation(box->min);
    }
    bounds = transform_box(axes.inverse(), in_world);
  }
  for (int a = 0; a < 2; ++a) {
    const double period = world_->map_period()[a];
    if (!(period > 0)) continue;
    periodic_[static_cast<std::size_t>(a)] = true;
    bounds.min[a] = 0;
    bounds.max[a] = period;
  }
  const Vec3d corner = transform_point(axes, bounds.min);
  for (int i = 0; i < 3; ++i) axes[3][i] = corner[i];
  grid_to_world_ = axes;
  world_to_grid_ = axes.inverse();
  cell_m_ = bounds.size();
}

void OrdinatesGrid::choose_cells(Vec3i cells) {
  const Vec3d size = cell_m_;
  const double longest = std::max({size.x, size.y, size.z});
  for (int a = 0; a < 3; ++a) {
    if (!(size[a] > 0)) throw InputError("ordinates", "the grid's box is flat", "give a box with a volume");
    if (cells[a] < 0) throw InputError("ordinates", "a number of cells is negative", "give 0 to let it be chosen");
    if (cells[a] == 0) {
      cells[a] = std::max(1, static_cast<int>(std::lround(32 * size[a] / longest)));
      // Whole voxels in a cell, where that is possible.
      if (voxel_m_[a] > 0) {
        const int voxels = std::max(1, static_cast<int>(std::lround(size[a] / voxel_m_[a])));
        if (voxels <= cells[a]) cells[a] = voxels;
        const int most = cells[a];
        for (int fewer = most; 2 * fewer > most; --fewer) {
          if (voxels % fewer != 0) continue;
          cells[a] = fewer;
          break;
        }
      }
    }
    cell_m_[a] = size[a] / cells[a];
  }
  cells_ = cells;
}

void OrdinatesGrid::find_phases() {
  for (int c = 0; c < world_->cloud_count(); ++c) {
    std::vector<int>& of = phase_of_.emplace_back();
    for (const CloudOptics::Part& part : world_.optics(c).parts()) {
      const auto same = [&](const PhaseFunction* other) {
        for (const double cosine : {-1.0, -0.7, -0.2, 0.1, 0.5, 0.83, 0.97, 1.0}) {
          if (other->value(cosine) != part.phase->value(cosine)) return false;
        }
        return other->mean_cosine() == part.phase->mean_cosine();
      };
      auto found = std::find_if(phases_.begin(), phases_.end(), same);
      if (found == phases_.end()) {
        phases_.push_back(part.phase);
        found = phases_.end() - 1;
      }
      of.push_back(static_cast<int>(found - phases_.begin()));
    }
  }
  for (const PhaseFunction* phase : phases_) {
    std::vector<double>& moments = phase_moments_.emplace_back();
    for (int l = 0; l <= 40; ++l) moments.push_back(phase->moment(l));
  }
}

void OrdinatesGrid::resample(int lines) {
  const auto count =
      static_cast<std::size_t>(cells_.x) * static_cast<std::size_t>(cells_.y) * static_cast<std::size_t>(cells_.z);
  extinction.assign(count, 0.0);
  scattering.assign(count, 0.0);
  emission.assign(count, 0.0);
  const bool mixed = phases_.size() > 1;
  if (mixed) phase_scattering_.assign(phases_.size(), std::vector<double>(count, 0.0));
  // Lines along z through a regular grid of places; a column of cells belongs to one task.
  tbb::parallel_for(0, cells_.x * cells_.y, [&](int column) {
    const int i = column % cells_.x, j = column / cells_.x;
    const double share = 1 / (cell_m_.z * lines * lines);
    for (int place = 0; place < lines * lines; ++place) {
      const Vec3d start((i + (place % lines + 0.5) / lines) * cell_m_.x,
                        (j + (place / lines + 0.5) / lines) * cell_m_.y, 0);
      const Ray ray = transform_ray(grid_to_world_, {start, Vec3d(0, 0, 1), 0, cells_.z * cell_m_.z});
      march(
          world_, *this, ray,
          [&](double begin, double end, const LocalOptics& optics, std::optional<std::size_t> cell, const CellCursor&) {
            if (!cell) return true;
            // Rounding at the border between columns must not reach into the neighbour's.
            const std::size_t own = index(Vec3i(i, j, cell_at(*cell).z));
            const double weight = (end - begin) * share;
            extinction[own] += weight * optics.extinction;
            scattering[own] += weight * optics.scattering;
            emission[own] += weight * optics.emission;
            if (!mixed || !(optics.scattering > 0)) return true;
            const Vec3d point = ray.at(0.5 * (begin + end));
            for (int c = 0; c < world_->cloud_count(); ++c) {
              const Octree& octree = *world_->clouds()[static_cast<std::size_t>(c)].octree;
              const Vec3d at = world_->index_point(c, point);
              const auto& parts = world_.optics(c).parts();
              for (std::size_t p = 0; p < parts.size(); ++p) {
                const auto phase = static_cast<std::size_t>(phase_of_[static_cast<std::size_t>(c)][p]);
                phase_scattering_[phase][own] +=
                    weight * parts[p].scattering * static_cast<double>(octree.value(parts[p].channel, at));
              }
            }
            return true;
          });
    }
  });
}

int OrdinatesGrid::phase_degree(int most) const {
  int degree = 0;
  for (const std::vector<double>& moments : phase_moments_) {
    for (int l = 1; l <= std::min(most, 40); ++l) {
      if (std::abs(moments[static_cast<std::size_t>(l)]) > 1e-12) degree = std::max(degree, l);
    }
  }
  return degree;
}

void OrdinatesGrid::scattering_moments(std::size_t cell, std::span<double> values) const noexcept {
  std::fill(values.begin(), values.end(), 0.0);
  for (std::size_t p = 0; p < phases_.size(); ++p) {
    const double part = phases_.size() == 1 ? scattering[cell] : phase_scattering_[p][cell];
    for (std::size_t l = 0; l < values.size(); ++l) values[l] += part * phase_moments_[p][l];
  }
}

double OrdinatesGrid::phase(std::size_t cell, double cosine) const noexcept {
  if (phases_.size() == 1) return phases_.front()->value(cosine);
  double sum = 0, total = 0;
  for (std::size_t p = 0; p < phases_.size(); ++p) {
    sum += phase_scattering_[p][cell] * phases_[p]->value(cosine);
    total += phase_scattering_[p][cell];
  }
  return total > 0 ? sum / total : 0.0;
}

CellCursor::CellCursor(const OrdinatesGrid& grid, const Ray& world_ray, double t) noexcept : grid_(&grid), end_(t) {
  const Ray ray = transform_ray(grid.world_to_grid(), world_ray);
  for (int a = 0; a < 3; ++a) {
    origin_[a] = ray.origin[a] / grid.cell_m()[a];
    direction_[a] = ray.direction[a] / grid.cell_m()[a];
    const double at = origin_[a] + t * direction_[a];
    // On a face the cell is the one that the ray goes into; a little rounding does not make another.
    const double nearest = std::round(at);
    const bool on_face = std::abs(at - nearest) < 1e-11 * (1 + std::abs(at) + std::abs(origin_[a]));
    double place = on_face ? nearest : std::floor(at);
    if (on_face && direction_[a] < 0) place -= 1;
    place_[static_cast<std::size_t>(a)] = place;
    next_[static_cast<std::size_t>(a)] = crossing(a);
  }
  end_ = std::min({next_[0], next_[1], next_[2]});
}

double CellCursor::crossing(int axis) const noexcept {
  if (grid_->uniform(axis) || direction_[axis] == 0) return kInfinity;
  const double border = place_[static_cast<std::size_t>(axis)] + (direction_[axis] > 0 ? 1 : 0);
  return (border - origin_[axis]) / direction_[axis];
}

void CellCursor::step() noexcept {
  for (int a = 0; a < 3; ++a) {
    const auto n = static_cast<std::size_t>(a);
    if (next_[n] > end_) continue;
    place_[n] += direction_[a] > 0 ? 1 : -1;
    next_[n] = crossing(a);
  }
  end_ = std::min({next_[0], next_[1], next_[2]});
}

std::optional<std::size_t> CellCursor::here() const noexcept {
  Vec3i cell;
  for (int a = 0; a < 3; ++a) {
    const int n = grid_->cells()[a];
    double place = place_[static_cast<std::size_t>(a)];
    if (grid_->uniform(a)) {
      place = 0;
    } else if (grid_->periodic(a)) {
      place -= n * std::floor(place / n);
    } else if (place < 0 || place >= n) {
      return std::nullopt;
    }
    cell[a] = static_cast<int>(place);
  }
  return grid_->index(cell);
}

Vec3d CellCursor::corner() const noexcept {
  return Vec3d(place_[0] * grid_->cell_m().x, place_[1] * grid_->cell_m().y, place_[2] * grid_->cell_m().z);
}

}  // namespace obscura
