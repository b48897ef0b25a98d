// The first collision of light that comes from one direction: sun, moon and beams. Followed through the
// World itself, so that nothing is lost to the grid but where in a cell it scatters.
#include <tbb/parallel_for.h>

#include <algorithm>

#include "photon/optics/purpose.h"
#include "photon/optics/transfer.h"
#include "photon/ordinates/ordinates_data.h"

namespace obscura::detail {
namespace {

using Data = OrdinatesSolution::Data;

/// What light of one direction does in a cell: means over the cell, and the first moment of its scattering
/// about the middle, in half sides.
struct CellLight {
  double fluence = 0;   // W/m2
  double absorbed = 0;  // W/m3
  double scattered = 0;
  Vec3d moment{0, 0, 0};
};

/// A stretch of light through a cell, from its entry on: integrals of transmission along it.
struct Stretch {
  double passed = 1;  // what is left at the end
  double length = 0;
  double fluence = 0;  // m
  double absorbed = 0;
  double scattered = 0;
  double scattered_place = 0;  // first moment of it, m

  void add(double reduced, double scattering, double absorption, double begin, double end) {
    const double d = end - begin, tau = reduced * d;
    const double gain = passed * effective_length(reduced, d);
    const double far = tau > 0 ? linear_source_weights(tau).far / tau : 0.5;  // integral of x e^(-tau x)
    fluence += gain;
    absorbed += absorption * gain;
    scattered += scattering * gain;
    scattered_place += scattering * (begin * gain + passed * d * d * far);
    passed *= std::exp(-tau);
    length = end;
  }
};

/// The light's source in a cell from its mean and first moment.
void put_source(Data& data, std::size_t cell, const CellLight& light, const Vec3d& direction,
                std::vector<double>& source) {
  if (!(light.scattered > 0)) return;
  const auto degrees = static_cast<std::size_t>(data.degree) + 1;
  const double* const scatter = &data.scatter[cell * degrees];
  if (!(scatter[0] > 0)) return;
  std::vector<double> harmonics(degrees * degrees);
  spherical_harmonics(direction, data.degree, harmonics.data());
  // The centre stays: with lumped matrices light sits at the corners, else slopes are three times as steep.
  const double steep = data.lumped[cell] ? 1 : 3;
  for (std::size_t corner = 0; corner < 8; ++corner) {
    double value = light.scattered;
    for (int a = 0; a < 3; ++a) value += (corner >> a & 1 ? steep : -steep) * light.moment[a];
    double* const to = &source[(8 * cell + corner) * data.moment_count()];
    for (std::size_t l = 0, m = 0; l < degrees; ++l) {
      for (; m < (l + 1) * (l + 1); ++m) to[m] += value * scatter[l] / scatter[0] * harmonics[m];
    }
  }
}

/// The sun's light in a cell, from lines towards it through 2 x 2 x 2 places. On each line it is exact, and
/// so is its mean over layers.
CellLight sunlight(const Data& data, std::size_t cell, const Sun& sun, const Vec3d& toward) {
  const OrdinatesGrid& grid = data.grid;
  const double irradiance = data.world.value_of(sun.irradiance);
  const Vec3i at = grid.cell_at(cell);
  const Vec3d h = grid.cell_m(), corner(at.x * h.x, at.y * h.y, at.z * h.z);
  const double gauss = 1 / std::sqrt(3.0);
  CellLight light;
  for (int n = 0; n < 8; ++n) {
    const Vec3d local(n & 1 ? gauss : -gauss, n & 2 ? gauss : -gauss, n & 4 ? gauss : -gauss);
    Vec3d point;
    double ahead = kInfinity, behind = kInfinity;  // to the cell's faces, towards the sun and away from it
    for (int a = 0; a < 3; ++a) {
      point[a] = corner[a] + 0.5 * (1 + local[a]) * h[a];
      if (grid.uniform(a) || toward[a] == 0) continue;
      const double up = (corner[a] + h[a] - point[a]) / std::abs(toward[a]),
                   down = (point[a] - corner[a]) / std::abs(toward[a]);
      ahead = std::min(ahead, toward[a] > 0 ? up : down);
      behind = std::min(behind, toward[a] > 0 ? down : up);
    }
    const Vec3d entry = transform_point(grid.grid_to_world(), point + ahead * toward);
    const Ray shadow{entry, sun.toward, 0, kInfinity};
    Stream stream = StreamName{.history = cell}.stream();
    if (data.world->blocked({transform_point(grid.grid_to_world(), point), sun.toward, 0, kInfinity}, {}, stream))
      continue;
    const double arriving = irradiance * std::exp(-data.depth(shadow));
    Stretch stretch;
    const double chord = ahead + behind;
    double before = 0;
    const auto add = [&](double k, double s, double a, double begin, double end) {
      if (begin > before) stretch.add(0, 0, 0, before, begin);
      stretch.add(k, s, a, begin, end);
      before = end;
    };
    WorldWalk walk(data.world, {entry, -sun.toward, 0, chord});
    while (walk.next()) {
      const LocalOptics optics = walk.optics();
      const double forward = data.forward[cell] * optics.scattering;
      add(optics.extinction - forward, optics.scattering - forward, optics.extinction - optics.scattering, walk.begin(),
          walk.end());
    }
    if (before < chord) stretch.add(0, 0, 0, before, chord);
    const double weight = arriving / (8 * chord);
    light.fluence += weight * stretch.fluence;
    light.absorbed += weight * stretch.absorbed;
    const double scattered = weight * stretch.scattered;
    if (!(scattered > 0)) continue;
    light.scattered += scattered;
    const Vec3d centre = point + (ahead - stretch.scattered_place / stretch.scattered) * toward - corner;
    for (int a = 0; a < 3; ++a) {
      if (!grid.uniform(a)) light.moment[a] += scattered * (2 * centre[a] / h[a] - 1);
    }
  }
  return light;
}

/// A beam's light in all cells that it crosses, along lines over its disc.
void add_beam(Data& data, const Beam& beam, std::vector<CellLight>& cells) {
  const OrdinatesGrid& grid = data.grid;
  constexpr int kLines = 400;
  const int lines = beam.radius > 0 ? kLines : 1;
  const auto [u, v] = orthonormal_basis(beam.direction);
  for (int n = 0; n < lines; ++n) {
    // Equal areas, turned by the golden angle (Vogel, Math. Biosci. 44, 1979).
    const double r = lines > 1 ? beam.radius * std::sqrt((n + 0.5) / lines) : 0.0;
    const double phi = n * kPi * (3 - std::sqrt(5.0));
    Ray ray{beam.position + r * std::cos(phi) * u + r * std::sin(phi) * v, beam.direction, 0, kInfinity};
    Stream stream = StreamName{.history = static_cast<std::uint64_t>(n)}.stream();
    ray.t_max = data.world->meet(ray, {}, stream).t;
    double power = data.world.value_of(beam.power) / lines / grid.cell_volume();
    const Ray local = transform_ray(grid.world_to_grid(), ray);
    march(data.world, grid, ray,
          [&](double begin, double end, const LocalOptics& optics, std::optional<std::size_t> cell,
              const CellCursor& cursor) {
            const double forward = cell ? data.forward[*cell] * optics.scattering : 0.0;
            Stretch stretch;
            stretch.add(optics.extinction - forward, optics.scattering - forward, optics.extinction - optics.scattering,
                        0, end - begin);
            if (cell) {
              CellLight& light = cells[*cell];
              light.fluence += power * stretch.fluence;
              light.absorbed += power * stretch.absorbed;
              light.scattered += power * stretch.scattered;
              if (stretch.scattered > 0) {
                const Vec3d place = local.at(begin + stretch.scattered_place / stretch.scattered) - cursor.corner();
                for (int a = 0; a < 3; ++a) {
                  if (!grid.uniform(a))
                    light.moment[a] += power * stretch.scattered * (2 * place[a] / grid.cell_m()[a] - 1);
                }
              }
            }
            power *= stretch.passed;
            return power > 0;
          });
  }
}

/// Sunlight that delta-M takes for scattered straight on leaves the grid together with the unscattered light. What it
/// exceeds the truly unscattered light by is counted as leaving scattered light.
void add_forward_light(Data& data, const Sun& sun, const Vec3d& toward) {
  const OrdinatesGrid& grid = data.grid;
  if (std::all_of(data.forward.begin(), data.forward.end(), [](double share) { return share == 0; })) return;
  const Vec3i& n = grid.cells();
  const Vec3d& h = grid.cell_m();
  for (int axis = 0; axis < 3; ++axis) {
    if (grid.periodic(axis) || toward[axis] == 0) continue;
    const int first = axis == 0 ? 1 : 0, second = axis == 2 ? 1 : 2;
    const std::size_t side = toward[axis] > 0 ? 0 : 1;
    std::vector<double>& leaving = data.leaving[static_cast<std::size_t>(axis)][side];
    leaving.resize(static_cast<std::size_t>(n[first] * n[second]));
    std::vector<double> surpluses(leaving.size());
    tbb::parallel_for(0, n[first] * n[second], [&](int face) {
      double surplus = 0;
      for (int place = 0; place < 4; ++place) {
        Vec3d point;
        point[axis] = side == 0 ? 0.0 : n[axis] * h[axis];
        const double gauss = std::sqrt(1.0 / 12);
        point[first] = (face % n[first] + 0.5 + (place & 1 ? gauss : -gauss)) * h[first];
        point[second] = (face / n[first] + 0.5 + (place & 2 ? gauss : -gauss)) * h[second];
        const Ray back{transform_point(grid.grid_to_world(), point), sun.toward, 0, kInfinity};
        Stream stream = StreamName{.history = static_cast<std::uint64_t>(face)}.stream();
        if (data.world->blocked(back, {}, stream)) continue;
        double whole = 0;
        data.world.optical_depths({&back, 1}, {&whole, 1});
        surplus += 0.25 * data.world.value_of(sun.irradiance) * std::abs(toward[axis]) *
                   (std::exp(-data.depth(back)) - std::exp(-whole));
      }
      leaving[static_cast<std::size_t>(face)] += surplus;
      surpluses[static_cast<std::size_t>(face)] = surplus;
    });
    for (const double surplus : surpluses) data.powers.first_scattered += surplus * grid.face_area(axis);
  }
}

/// Sunlight that reaches the sides of surfaces without a collision.
void light_surfaces(Data& data, const Sun& sun) {
  tbb::parallel_for(std::size_t{0}, data.surfaces.sides.size(), [&](std::size_t n) {
    OrdinatesSide& side = data.surfaces.sides[n];
    const double cosine = side.id.exists() && side.inside ? sun.toward.dot(side.normal) : 0.0;
    if (!(cosine > 0) || !(side.reflectance > 0)) return;
    const Ray shadow{side.position, sun.toward, data.world->surfaces().clearance(), kInfinity};
    Stream stream = StreamName{}.stream();
    if (data.world->blocked(shadow, side.id, stream)) return;
    side.sunlight += cosine * data.world.value_of(sun.irradiance) * std::exp(-data.depth(shadow));
  });
}

void add_light(Data& data, const std::vector<CellLight>& cells, const Vec3d& direction, bool sun,
               std::vector<double>& source) {
  Data::FirstLight& first =
      data.first.emplace_back(Data::FirstLight{transform_direction(data.grid.grid_to_world(), direction), sun, {}});
  tbb::parallel_for(std::size_t{0}, cells.size(),
                    [&](std::size_t cell) { put_source(data, cell, cells[cell], direction, source); });
  for (std::size_t cell = 0; cell < cells.size(); ++cell) {
    data.uncollided[cell] += cells[cell].fluence;
    first.scattered.push_back(cells[cell].scattered);
    data.powers.first_scattered += cells[cell].scattered * data.grid.cell_volume();
    data.powers.first_absorbed += cells[cell].absorbed * data.grid.cell_volume();
  }
}

}  // namespace

void add_first_collisions(Data& data, std::vector<double>& source) {
  data.uncollided.assign(data.grid.size(), 0.0);
  std::vector<CellLight> cells(data.grid.size());
  for (const Sun& sun : data.world->suns()) {
    if (!(data.world.value_of(sun.irradiance) > 0)) continue;
    const Vec3d toward = transform_direction(data.grid.world_to_grid(), sun.toward);
    tbb::parallel_for(std::size_t{0}, cells.size(),
                      [&](std::size_t cell) { cells[cell] = sunlight(data, cell, sun, toward); });
    add_light(data, cells, -toward, true, source);
    light_surfaces(data, sun);
    add_forward_light(data, sun, toward);
  }
  for (const Beam& beam : data.world->beams()) {
    if (!(data.world.value_of(beam.power) > 0)) continue;
    std::fill(cells.begin(), cells.end(), CellLight{});
    add_beam(data, beam, cells);
    add_light(data, cells, transform_direction(data.grid.world_to_grid(), beam.direction), false, source);
  }
}

}  // namespace obscura::detail
