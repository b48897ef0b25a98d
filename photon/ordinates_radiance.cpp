// What a solution of discrete ordinates looks like along rays: the World's own segments, the solution's
// scattered light, and the first scattering of sun and moon as exact as rays can make it.
#include <tbb/parallel_for.h>

#include <algorithm>

#include "photon/ordinates_data.h"
#include "photon/transfer.h"

namespace obscura {
namespace {

using Data = OrdinatesSolution::Data;

/// Below this transmission nothing behind counts.
constexpr double kOpaque = 1e-9;
/// Stretches over which the sun's light is integrated by two points, in optical depth.
constexpr double kSunStep = 0.5;

/// A stretch of a ray in one cell with constant coefficients.
struct Piece {
  double begin, end;
  double extinction;  // reduced, 1/m
  LocalOptics optics;
  std::size_t cell;
};

/// One ray on its way through the clouds, seen from its start.
class View {
 public:
  /// @param exact with the sun's first scattering, discs and reflections by rays of their own
  View(const Data& data, const Ray& ray, FaceId from, bool exact)
      : data_(data), ray_(ray), from_(from), exact_(exact), local_(transform_ray(data.grid.world_to_grid(), ray)),
        air_(data.world->air_extinction(data.interval)), air_radiance_(data.world->air_radiance(data.interval)),
        harmonics_(data.moment_count(), 0.0) {
    spherical_harmonics(-local_.direction, data.degree, harmonics_.data());
    // Both the sun's light and the scattered light travel the other way.
    for (const Sun& sun : data.world->suns()) cosine_.push_back(sun.toward.dot(ray.direction));
  }

  Incoming look() {
    Incoming in;
    double depth = 0;
    Stream stream(0, 0, 0);
    const SurfaceHit hit = data_.world->meet(ray_, from_, stream);
    ray_.t_max = std::min(ray_.t_max, hit.t);
    in.distance = hit.t;
    march(*data_.world, data_.interval, data_.grid, ray_,
          [&](double begin, double end, const LocalOptics& optics, std::optional<std::size_t> cell, const CellCursor& cursor) {
            depth += optics.extinction * (end - begin);
            const double extinction = data_.reduced(optics, cell);
            add_emission(begin, end, extinction, optics.emission);
            if (cell && optics.scattering > 0) {
              const Piece piece{begin, end, extinction, optics, *cell};
              add_scattered(piece, cursor.corner());
              if (exact_) add_sunlight(piece);
              add_first_light(piece);
            }
            passed_ *= std::exp(-extinction * (end - begin));
            return passed_ > kOpaque;
          });
    if (!(passed_ > kOpaque)) depth = kInfinity;
    in.transmission = std::exp(-depth);
    in.transmission_air = through_air(ray_.t_max);
    in.direct = radiance_;
    if (hit.exists()) {
      const SurfacePoint at = data_.world->surface_at(data_.interval, ray_, hit);
      const double end = at.emission(at.cosine) + (passed_ > kOpaque ? reflected(at) : 0.0);
      in.direct += passed_ * (in.transmission_air * end + (1 - in.transmission_air) * air_radiance_);
    } else {
      const double sky = data_.world->background(data_.interval, ray_.direction, false);
      const double disc = exact_ ? data_.world->background(data_.interval, ray_.direction) - sky : 0.0;
      in.direct += passed_ * sky + in.transmission * disc;
    }
    return in;
  }

 private:
  double through_air(double t) const noexcept { return air_ > 0 ? std::exp(-air_ * t) : 1.0; }

  void add_emission(double begin, double end, double extinction, double emission) {
    const double length = end - begin;
    const double seen = passed_ * through_air(begin) * effective_length(extinction + air_, length);
    radiance_ += seen * emission;
    // What the air before it glows where the cloud hides the air behind.
    if (air_ > 0) radiance_ += air_radiance_ * (passed_ * one_minus_exp(extinction * length) - extinction * seen);
  }

  /// Scattered light at the corners of a cell, W/m3/sr, for one unit of scattering.
  void look_into(std::size_t cell) {
    if (cell == cell_) return;
    cell_ = cell;
    const auto degrees = static_cast<std::size_t>(data_.degree) + 1;
    const double* const scatter = &data_.scatter[cell * degrees];
    const double unit = data_.grid.scattering[cell] > 0 ? 1 / data_.grid.scattering[cell] : 0.0;
    for (std::size_t c = 0; c < 8; ++c) {
      const double* const moments = &data_.moments[(8 * cell + c) * data_.moment_count()];
      double sum = 0;
      for (std::size_t l = 0, m = 0; l < degrees; ++l) {
        double part = 0;
        for (; m < (l + 1) * (l + 1); ++m) part += harmonics_[m] * moments[m];
        sum += scatter[l] * part;
      }
      corner_[c] = std::max(0.0, sum * unit);
    }
  }

  double scattered_at(double t, const Vec3d& corner) const noexcept {
    const Vec3d at = local_.at(t) - corner;
    double weight[3];
    for (int a = 0; a < 3; ++a) weight[a] = data_.grid.uniform(a) ? 0.5 : std::clamp(at[a] / data_.grid.cell_m()[a], 0.0, 1.0);
    double sum = 0;
    for (std::size_t c = 0; c < 8; ++c) {
      sum += corner_[c] * (c & 1 ? weight[0] : 1 - weight[0]) * (c & 2 ? weight[1] : 1 - weight[1]) * (c & 4 ? weight[2] : 1 - weight[2]);
    }
    return sum;
  }

  /// A neighbour of the cell whose middle the place sees, or nothing.
  std::optional<std::size_t> seen_neighbour(std::size_t cell, const Vec3d& place) const {
    const OrdinatesGrid& grid = data_.grid;
    const Vec3i at = grid.cell_at(cell);
    std::optional<std::size_t> best;
    double nearest = kInfinity;
    for (int a = 0; a < 3; ++a) {
      for (const int step : {-1, 1}) {
        Vec3i other = at;
        other[a] += step;
        if (other[a] < 0 || other[a] >= grid.cells()[a]) continue;
        const Vec3d middle((other.x + 0.5) * grid.cell_m().x, (other.y + 0.5) * grid.cell_m().y, (other.z + 0.5) * grid.cell_m().z);
        const double distance = (middle - place).length();
        if (distance < nearest && sees(place, middle)) {
          nearest = distance;
          best = grid.index(other);
        }
      }
    }
    return best;
  }

  bool sees(const Vec3d& from, const Vec3d& to) const {
    const Vec3d a = transform_point(data_.grid.grid_to_world(), from), b = transform_point(data_.grid.grid_to_world(), to);
    const double distance = (b - a).length();
    return !(distance > 0) || !data_.world->surfaces().occluded({a, (b - a) / distance, 0, distance});
  }

  void add_scattered(const Piece& piece, const Vec3d& corner) {
    look_into(piece.cell);
    // On the other side of a surface than the middle of its cell: the light is that of the neighbour.
    if (!data_.surfaces.empty() && data_.surfaces.touched[piece.cell]) {
      const Vec3d place = local_.at(0.5 * (piece.begin + piece.end));
      if (!sees(place, corner + 0.5 * data_.grid.cell_m())) {
        const std::optional<std::size_t> other = seen_neighbour(piece.cell, place);
        if (!other) return;
        look_into(*other);
        double mean = 0;
        for (const double c : corner_) mean += c / 8;
        radiance_ += passed_ * through_air(piece.begin) * piece.optics.scattering * mean *
                     effective_length(piece.extinction + air_, piece.end - piece.begin);
        return;
      }
    }
    // Two halves, in each of them linear along the ray.
    const double k = piece.extinction + air_;
    const double half = 0.5 * (piece.end - piece.begin);
    double passed = passed_ * through_air(piece.begin);
    double near = scattered_at(piece.begin, corner);
    for (int part = 1; part <= 2; ++part) {
      const double far = scattered_at(piece.begin + part * half, corner);
      const double tau = k * half;
      const LinearSourceWeights weights = linear_source_weights(tau);
      const double gain = tau > 1e-9 ? (weights.near * near + weights.far * far) / k : 0.5 * half * (near + far);
      radiance_ += passed * piece.optics.scattering * gain;
      passed *= std::exp(-tau);
      near = far;
    }
  }

  /// The first scattering, by the exact phase function, of light whose forward share counts as not scattered
  /// (Nakajima & Tanaka, J. Quant. Spectrosc. Radiat. Transf. 40, 1988).
  void add_sunlight(const Piece& piece) {
    const auto interval = static_cast<std::size_t>(data_.interval);
    for (std::size_t s = 0; s < cosine_.size(); ++s) {
      const Sun& sun = data_.world->suns()[s];
      if (!(sun.irradiance[interval] > 0)) continue;
      const double phase = data_.grid.phase(piece.cell, cosine_[s]);
      const double depth = piece.extinction * (piece.end - piece.begin);
      const int steps = std::clamp(static_cast<int>(std::ceil(depth / kSunStep)), 1, 1 << 16);
      // Equal steps in what is lost, the last ones where nothing is left.
      const double step = (piece.end - piece.begin) / steps;
      double passed = passed_;
      for (int i = 0; i < steps && passed > kOpaque; ++i) {
        const double tau = piece.extinction * step;
        const double seen = passed * effective_length(piece.extinction, step);
        for (const double u : {0.5 - std::sqrt(1.0 / 12), 0.5 + std::sqrt(1.0 / 12)}) {
          // The place where a share u of what this step adds has been added.
          const double at = tau > 1e-6 ? -std::log1p(-u * one_minus_exp(tau)) / tau : u;
          const double t = piece.begin + (i + at) * step;
          const Ray shadow{ray_.at(t), sun.toward, 0, kInfinity};
          Stream stream(0, 0, 0);
          if (data_.world->blocked(shadow, {}, stream)) continue;
          radiance_ += 0.5 * seen * through_air(t) * piece.optics.scattering * phase * sun.irradiance[interval] * std::exp(-data_.depth(shadow));
        }
        passed *= std::exp(-tau);
      }
    }
  }

  /// The first scattering as the grid has it.
  void add_first_light(const Piece& piece) {
    for (const Data::FirstLight& light : data_.first) {
      const double scattered = light.scattered[piece.cell];
      if (!(scattered > 0) || (light.sun && exact_)) continue;
      const double seen = passed_ * through_air(piece.begin) * effective_length(piece.extinction + air_, piece.end - piece.begin);
      radiance_ += seen * scattered * data_.grid.phase(piece.cell, -light.direction.dot(ray_.direction));
    }
  }

  /// What a surface reflects: sunlight at first hand and what comes from all other directions, by rays; for
  /// rays of that kind themselves, what the nearest opaque face of the grid reflects.
  double reflected(const SurfacePoint& at) const {
    if (!at.reflects()) return 0;
    if (!exact_) {
      const OrdinatesSide* const side = data_.surfaces.nearest(data_.grid, at.position, at.normal);
      return side ? side->reflected : data_.reflected_far(at);
    }
    const World& world = *data_.world;
    const double clearance = world.surfaces().clearance();
    double sum = 0;
    for (const Sun& sun : world.suns()) {
      const double cosine = sun.toward.dot(at.normal);
      const Ray shadow{at.position, sun.toward, clearance, kInfinity};
      Stream stream(0, 0, 0);
      if (!(cosine > 0) || world.blocked(shadow, at.id, stream)) continue;
      sum += at.material->diffuse(cosine, at.cosine) * cosine * sun.irradiance[static_cast<std::size_t>(data_.interval)] * std::exp(-data_.depth(shadow));
    }
    // Equal shares of the cosine-weighted hemisphere.
    constexpr int kRows = 12, kColumns = 24;
    const auto [u, v] = orthonormal_basis(at.normal);
    for (int n = 0; n < kRows * kColumns; ++n) {
      const double sine2 = (n / kColumns + 0.5) / kRows, cosine = std::sqrt(1 - sine2);
      const double phi = 2 * kPi * (n % kColumns + (n / kColumns % 2 ? 0.25 : 0.75)) / kColumns;
      const Vec3d direction = std::sqrt(sine2) * (std::cos(phi) * u + std::sin(phi) * v) + cosine * at.normal;
      sum += kPi / (kRows * kColumns) * at.material->diffuse(cosine, at.cosine) *
             View(data_, {at.position, direction.normalized(), clearance, kInfinity}, at.id, false).look().direct;
    }
    return sum;
  }

  const Data& data_;
  Ray ray_;
  FaceId from_;
  bool exact_;
  Ray local_;
  double air_, air_radiance_;
  std::vector<double> harmonics_;
  std::vector<double> cosine_;
  double passed_ = 1;
  double radiance_ = 0;
  std::size_t cell_ = ~std::size_t{0};
  double corner_[8]{};
};

/// A part of the sphere of directions: the cosine to z and the azimuth, both as shares.
struct Patch {
  double z, phi, side_z, side_phi;
  double integral;
};

/// Patches that are marked or beside one that is; rows of twice as many patches, which close upon themselves.
std::vector<bool> with_neighbours(const std::vector<bool>& marked, int rows) {
  std::vector<bool> result(marked.size());
  const int columns = 2 * rows;
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      if (!marked[static_cast<std::size_t>(row * columns + column)]) continue;
      for (int r = std::max(0, row - 1); r <= std::min(rows - 1, row + 1); ++r) {
        for (int c = -1; c <= 1; ++c) result[static_cast<std::size_t>(r * columns + (column + c + columns) % columns)] = true;
      }
    }
  }
  return result;
}

}  // namespace

void OrdinatesSolution::radiance(std::span<const Ray> rays, std::span<Incoming> incoming) const {
  tbb::parallel_for(std::size_t{0}, rays.size(), [&](std::size_t i) { incoming[i] = View(*data_, rays[i], {}, true).look(); });
}

OrdinatesEstimate OrdinatesSolution::fluence_at(const Vec3d& point) const {
  constexpr int kRows = 24, kLevels = 7;
  constexpr double kTolerance = 2e-4;
  const World& world = *data_->world;
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
        p.integral += kPi * p.side_z * p.side_phi * View(*data_, ray, {}, false).look().direct;
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
        parts.push_back({p.z + (n & 1 ? 0.5 * p.side_z : 0.0), p.phi + (n & 2 ? 0.5 * p.side_phi : 0.0), 0.5 * p.side_z, 0.5 * p.side_phi, 0});
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
  for (const Sun& sun : world.suns()) {
    const Ray shadow{point, sun.toward, 0, kInfinity};
    Stream stream(0, 0, 0);
    if (world.blocked(shadow, {}, stream)) continue;
    double depth = 0;
    world.optical_depths(data_->interval, {&shadow, 1}, {&depth, 1});
    fluence.value += sun.irradiance[static_cast<std::size_t>(data_->interval)] * std::exp(-depth);
  }
  return fluence;
}

}  // namespace obscura
