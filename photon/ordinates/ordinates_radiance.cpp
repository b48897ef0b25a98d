// What a solution of discrete ordinates looks like along rays: the World's own segments, the solution's
// scattered light, and the first scattering of sun and moon as exact as rays can make it.
#include <tbb/parallel_for.h>

#include <algorithm>

#include "photon/optics/purpose.h"
#include "photon/optics/transfer.h"
#include "photon/ordinates/ordinates_data.h"

namespace obscura {
namespace {

using Data = OrdinatesSolution::Data;

/// Below this transmission nothing behind counts.
constexpr double kOpaque = 1e-9;
/// Stretches over which the sun's light is integrated by two points, in optical depth.
constexpr double kSunStep = 0.5;

/// In thick cells the light near their faces is not resolved: fitted to half spaces of albedo 0.5 to 0.99 in cells of
/// depth 2 to 250 (photon/MEASURED.md, "Thick cells").
constexpr double kResolved = 1.5, kHalfResolved = 7;
/// Share of the correction that may be wrong.
constexpr double kLayerDoubt = 0.2;

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
      : data_(data),
        ray_(ray),
        from_(from),
        exact_(exact),
        local_(transform_ray(data.grid.world_to_grid(), ray)),
        air_(data.world.air_extinction()),
        air_radiance_(data.world.air_radiance()),
        harmonics_(data.moment_count(), 0.0) {
    spherical_harmonics(-local_.direction, data.degree, harmonics_.data());
    // Both the sun's light and the scattered light travel the other way.
    for (const Sun& sun : data.world->suns()) cosine_.push_back(sun.toward.dot(ray.direction));
  }

  Incoming look() {
    Incoming in;
    double depth = 0;
    Stream stream = StreamName{}.stream();
    const SurfaceHit hit = data_.world->meet(ray_, from_, stream);
    ray_.t_max = std::min(ray_.t_max, hit.t);
    in.distance = hit.t;
    march(data_.world, data_.grid, ray_,
          [&](double begin, double end, const LocalOptics& optics, std::optional<std::size_t> cell,
              const CellCursor& cursor) {
            depth += optics.extinction * (end - begin);
            const double extinction = data_.reduced(optics, cell);
            add_emission(begin, end, extinction, optics.emission);
            if (cell && cell != layer_cell_) enter(*cell, begin, cursor.corner(), in);
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
    in.direct = std::max(0.0, radiance_);
    if (hit.exists()) {
      const SurfacePoint at = data_.world.surface_at(ray_, hit);
      const double end = at.emission(at.cosine) + (passed_ > kOpaque ? reflected(at) : 0.0);
      in.direct += passed_ * (in.transmission_air * end + (1 - in.transmission_air) * air_radiance_);
    } else {
      const double sky = data_.world.background(ray_.direction, false);
      const double disc = exact_ ? data_.world.background(ray_.direction) - sky : 0.0;
      in.direct += passed_ * sky + in.transmission * disc;
    }
    return in;
  }

 private:
  /// Mean radiance of collided light in a cell, over all directions and corners.
  double mean_light(std::size_t cell) const noexcept {
    double sum = 0;
    for (std::size_t c = 0; c < 8; ++c) sum += data_.moments[(8 * cell + c) * data_.moment_count()];
    return sum / (8 * std::sqrt(4 * kPi));
  }

  /// Where a ray looks into a thick cell out of one that is brighter or darker, light falls off towards the face within
  /// a layer that the cell does not resolve. A half space of a uniform source shows the share gamma (1 + 2 mu) / (1 + 2
  /// mu gamma) of the difference (Hapke, J. Geophys. Res. 86, 1981, eq. 8: within 2 % of Chandrasekhar's H), gamma^2
  /// the share of absorption in the transport extinction. What the cell shows too much of it is taken off, as far as
  /// the layer is not resolved.
  void enter(std::size_t cell, double t, const Vec3d& corner, Incoming& in) {
    const std::size_t before = layer_cell_.value_or(cell);
    const bool first = !layer_cell_ && t <= ray_.t_min;
    layer_cell_ = cell;
    if (first) return;  // the ray begins in it
    const double outside = before == cell ? data_.world.background(ray_.direction, false) : mean_light(before);
    const OrdinatesGrid& grid = data_.grid;
    const Vec3d at = local_.at(t) - corner;
    int axis = -1;
    double nearest = kInfinity;
    for (int a = 0; a < 3; ++a) {
      if (grid.uniform(a)) continue;
      const double off = std::min(std::abs(at[a]), std::abs(grid.cell_m()[a] - at[a])) / grid.cell_m()[a];
      if (off < nearest) nearest = off, axis = a;
    }
    if (axis < 0) return;
    const auto degrees = static_cast<std::size_t>(data_.degree) + 1;
    const double* const scatter = &data_.scatter[cell * degrees];
    const double absorption = std::max(0.0, data_.extinction[cell] - scatter[0]);
    const double transport = data_.extinction[cell] - (degrees > 1 ? scatter[1] : 0.0);
    if (!(absorption > 0) || !(scatter[0] > 0) || !(transport > 0)) return;
    const double gamma = std::sqrt(absorption / transport), mu = std::abs(local_.direction[axis]);
    const double hidden = 1 - gamma * (1 + 2 * mu) / (1 + 2 * mu * gamma);
    const double depth = std::sqrt(3 * absorption * transport) * grid.cell_m()[axis];
    const double unresolved = std::max(0.0, depth - kResolved) / (depth + kHalfResolved);
    const double layer = passed_ * through_air(t) * hidden * (mean_light(cell) - outside);
    radiance_ -= unresolved * layer;
    in.bias += kLayerDoubt * std::min(1.0, depth * depth / (kHalfResolved * kResolved)) * std::abs(layer);
  }

  double through_air(double t) const noexcept { return transmission_over(air_, t); }

  void add_emission(double begin, double end, double extinction, double emission) {
    const double length = end - begin;
    const double seen = passed_ * through_air(begin) * effective_length(extinction + air_, length);
    radiance_ += seen * emission;
    // The air in front of this stretch, in place of the air behind that the cloud hides.
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
    for (int a = 0; a < 3; ++a)
      weight[a] = data_.grid.uniform(a) ? 0.5 : std::clamp(at[a] / data_.grid.cell_m()[a], 0.0, 1.0);
    double sum = 0;
    for (std::size_t c = 0; c < 8; ++c) {
      sum += corner_[c] * (c & 1 ? weight[0] : 1 - weight[0]) * (c & 2 ? weight[1] : 1 - weight[1]) *
             (c & 4 ? weight[2] : 1 - weight[2]);
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
        const Vec3d middle((other.x + 0.5) * grid.cell_m().x, (other.y + 0.5) * grid.cell_m().y,
                           (other.z + 0.5) * grid.cell_m().z);
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
    const Vec3d a = transform_point(data_.grid.grid_to_world(), from),
                b = transform_point(data_.grid.grid_to_world(), to);
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
    for (std::size_t s = 0; s < cosine_.size(); ++s) {
      const Sun& sun = data_.world->suns()[s];
      if (!(data_.world.value_of(sun.irradiance) > 0)) continue;
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
          Stream stream = StreamName{}.stream();
          if (data_.world->blocked(shadow, {}, stream)) continue;
          radiance_ += 0.5 * seen * through_air(t) * piece.optics.scattering * phase *
                       data_.world.value_of(sun.irradiance) * std::exp(-data_.depth(shadow));
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
      const double seen =
          passed_ * through_air(piece.begin) * effective_length(piece.extinction + air_, piece.end - piece.begin);
      radiance_ += seen * scattered * data_.grid.phase(piece.cell, -light.direction.dot(ray_.direction));
    }
  }

  /// Radiance that a surface reflects: sunlight, and what further rays find in all other directions. For these further
  /// rays (not exact) it is what the nearest opaque face of the grid reflects.
  double reflected(const SurfacePoint& at) const {
    if (!at.reflects()) return 0;
    if (!exact_) {
      const OrdinatesSide* const side = data_.surfaces.nearest(data_.grid, at.position, at.normal);
      return side ? side->reflected : data_.reflected_far(at);
    }
    const SpectralWorld world = data_.world;
    const double clearance = world->surfaces().clearance();
    double sum = 0;
    for (const Sun& sun : world->suns()) {
      // A few places of the disc: its half shadows are as wide as pixels.
      const int places = sun.diameter > 0 ? 16 : 1;
      const auto [east, north] = orthonormal_basis(sun.toward);
      for (int n = 0; n < places; ++n) {
        const double r = places > 1 ? std::sin(0.5 * sun.diameter) * std::sqrt((n + 0.5) / places) : 0.0,
                     phi = n * kPi * (3 - std::sqrt(5.0));
        const Vec3d toward = r * std::cos(phi) * east + r * std::sin(phi) * north + std::sqrt(1 - r * r) * sun.toward;
        const double cosine = toward.dot(at.normal);
        const Ray shadow{at.position, toward.normalized(), clearance, kInfinity};
        Stream stream = StreamName{}.stream();
        if (!(cosine > 0) || world->blocked(shadow, at.id, stream)) continue;
        const double irradiance = world.value_of(sun.irradiance) / places;
        sum += at.material->diffuse(cosine, at.cosine) * cosine * irradiance * std::exp(-data_.depth(shadow));
      }
    }
    // Equal shares of the cosine-weighted hemisphere.
    const int rows = data_.gather, columns = 2 * rows;
    const auto [u, v] = orthonormal_basis(at.normal);
    for (int n = 0; n < rows * columns; ++n) {
      const double sine2 = (n / columns + 0.5) / rows, cosine = std::sqrt(1 - sine2);
      const double phi = 2 * kPi * (n % columns + (n / columns % 2 ? 0.25 : 0.75)) / columns;
      const Vec3d direction = std::sqrt(sine2) * (std::cos(phi) * u + std::sin(phi) * v) + cosine * at.normal;
      sum += kPi / (rows * columns) * at.material->diffuse(cosine, at.cosine) *
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
  std::optional<std::size_t> layer_cell_;  // that the ray is in
  double corner_[8]{};
};

}  // namespace

void OrdinatesSolution::radiance(std::span<const Ray> rays, std::span<Incoming> incoming) const {
  tbb::parallel_for(std::size_t{0}, rays.size(),
                    [&](std::size_t i) { incoming[i] = View(*data_, rays[i], {}, true).look(); });
}

double detail::seen_quickly(const OrdinatesSolution::Data& data, const Ray& ray) {
  return View(data, ray, {}, false).look().direct;
}

}  // namespace obscura
