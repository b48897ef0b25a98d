// Fluence at a point from a solution of discrete ordinates: its radiance along rays in all directions.
#include <tbb/parallel_for.h>

#include <algorithm>

#include "photon/optics/purpose.h"
#include "photon/ordinates/ordinates_data.h"

namespace obscura {
namespace {

/// A part of the sphere of directions: the cosine to z and the azimuth, both as shares.
struct Patch {
  double z, phi, side_z, side_phi;
  double integral;
};

/// The marked patches and their neighbours. Patches lie in rows, twice as many columns as rows; a row closes upon
/// itself.
std::vector<bool> with_neighbours(const std::vector<bool>& marked, int rows) {
  std::vector<bool> result(marked.size());
  const int columns = 2 * rows;
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      if (!marked[static_cast<std::size_t>(row * columns + column)]) continue;
      for (int r = std::max(0, row - 1); r <= std::min(rows - 1, row + 1); ++r) {
        for (int c = -1; c <= 1; ++c)
          result[static_cast<std::size_t>(r * columns + (column + c + columns) % columns)] = true;
      }
    }
  }
  return result;
}

}  // namespace

OrdinatesEstimate OrdinatesSolution::fluence_at(const Vec3d& point) const {
  constexpr int kRows = 24, kLevels = 7;
  constexpr double kTolerance = 2e-4;
  // Patches of equal solid angle about an axis that no edge of a scene follows, four rays in each. Where the
  // four parts of a patch add up to something else they are divided again.
  const Vec3d pole = Vec3d(0.31, -0.57, 0.83).normalized();
  const auto [east, north] = orthonormal_basis(pole);
  const Vec3d u = east, v = north;
  const auto integrate = [&](std::vector<Patch>& patches) {
    tbb::parallel_for(std::size_t{0}, patches.size(), [&](std::size_t i) {
      Patch& p = patches[i];
      for (int n = 0; n < 4; ++n) {
        const double gauss = std::sqrt(1.0 / 12);
        const double z = 2 * (p.z + p.side_z * (0.5 + (n & 1 ? gauss : -gauss))) - 1;
        const double phi = 2 * kPi * (p.phi + p.side_phi * (0.5 + (n & 2 ? gauss : -gauss)));
        const double sine = std::sqrt(std::max(0.0, 1 - z * z));
        const Vec3d direction = sine * std::cos(phi) * u + sine * std::sin(phi) * v + z * pole;
        const Ray ray{point, direction.normalized(), 0, kInfinity};
        p.integral += kPi * p.side_z * p.side_phi * detail::seen_quickly(*data_, ray);
      }
    });
  };
  std::vector<Patch> patches;
  for (int row = 0; row < kRows; ++row) {
    for (int column = 0; column < 2 * kRows; ++column) {
      patches.push_back({static_cast<double>(row) / kRows, 0.5 * column / kRows, 1.0 / kRows, 0.5 / kRows, 0});
    }
  }
  integrate(patches);
  double total = 0;
  for (const Patch& p : patches) total += p.integral;
  OrdinatesEstimate fluence;
  double squares = 0;
  for (int level = 1; level <= kLevels && !patches.empty(); ++level) {
    std::vector<Patch> parts;
    for (const Patch& p : patches) {
      for (int n = 0; n < 4; ++n) {
        parts.push_back({p.z + (n & 1 ? 0.5 * p.side_z : 0.0), p.phi + (n & 2 ? 0.5 * p.side_phi : 0.0), 0.5 * p.side_z,
                         0.5 * p.side_phi, 0});
      }
    }
    integrate(parts);
    const double allowed = kTolerance * total / std::sqrt(static_cast<double>(patches.size()));
    std::vector<double> sums(patches.size(), 0.0);
    std::vector<bool> rough(patches.size());
    for (std::size_t i = 0; i < patches.size(); ++i) {
      for (std::size_t part = 4 * i; part < 4 * i + 4; ++part) sums[i] += parts[part].integral;
      rough[i] = std::abs(sums[i] - patches[i].integral) > allowed;
    }
    // What is bright may reach a little into a patch whose rays have all missed it.
    if (level == 1) rough = with_neighbours(rough, kRows);
    std::vector<Patch> again;
    for (std::size_t i = 0; i < patches.size(); ++i) {
      if (rough[i] && level < kLevels) {
        const auto first = parts.begin() + static_cast<std::ptrdiff_t>(4 * i);
        again.insert(again.end(), first, first + 4);
      } else {
        const double change = sums[i] - patches[i].integral;
        fluence.value += sums[i];
        squares += change * change;
      }
    }
    patches = std::move(again);
  }
  fluence.error = 2 * std::sqrt(squares) + kTolerance * fluence.value;
  const SpectralWorld world = data_->world;
  for (const Sun& sun : world->suns()) {
    const Ray shadow{point, sun.toward, 0, kInfinity};
    Stream stream = StreamName{}.stream();
    if (world->blocked(shadow, {}, stream)) continue;
    double depth = 0;
    world.optical_depths({&shadow, 1}, {&depth, 1});
    fluence.value += world.value_of(sun.irradiance) * std::exp(-depth);
  }
  return fluence;
}

}  // namespace obscura
