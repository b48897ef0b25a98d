// A cloud: an octree of densities (and temperature) with the optics of what it holds.
#pragma once

#include <algorithm>
#include <array>
#include <memory>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "octree/tree/octree.h"
#include "photon/optics/phase.h"
#include "photon/optics/planck_table.h"

namespace obscura {

/// One kind of matter. Coefficients are per unit of the density channel, one value per spectral
/// interval of the World (the intervals of all bands, in order).
struct Medium {
  int channel = 0;                 ///< density channel of the cloud's octree
  std::vector<double> extinction;  ///< 1/m per unit of density, >= 0
  std::vector<double> albedo;      ///< single-scattering albedo, [0, 1]
  PhaseFunction phase = PhaseFunction::isotropic();
};

/// Where a cloud's temperature comes from; the default does not emit.
struct Temperature {
  int channel = -1;  ///< temperature channel, K = scale * value + offset_K; -1: none
  double scale = 1;
  double offset_K = 0;
  double constant_K = 0;  ///< used where there is no channel; 0: does not emit
};

struct Cloud {
  /// Most channels that its octree can have: kernels decode a brick of them without allocating.
  static constexpr int kMaxChannels = 16;

  std::string name;
  std::shared_ptr<const Octree> octree;
  Affine local_to_world;      ///< rotation, translation and uniform scale
  std::vector<Medium> media;  ///< several overlap: coefficients add
  Temperature temperature;
  /// Per interval, in place of Planck, W/m2/sr; nothing, or an empty list: Planck.
  std::vector<std::optional<double>> source;
  std::vector<double> emission;          ///< per interval, W/m3/sr per unit of the first medium's density
  std::array<double, 2> period_m{0, 0};  ///< along the local x and y axes; 0: not periodic
};

/// What one point of the World does to light at one spectral interval.
struct LocalOptics {
  double extinction = 0;  ///< 1/m
  double scattering = 0;  ///< 1/m
  double emission = 0;    ///< W/m3/sr: k_a B and what is added

  LocalOptics& operator+=(const LocalOptics& other) noexcept {
    extinction += other.extinction;
    scattering += other.scattering;
    emission += other.emission;
    return *this;
  }
};

/// A cell of an octree taken whole: what stands for its optics, and the largest deviations from that inside it.
struct CoarseOptics {
  LocalOptics mean;
  double extinction = 0;  ///< 1/m
  double emission = 0;    ///< W/m3/sr
};

/// A cloud seen at one spectral interval: everything a kernel needs, no spectra, no names.
class CloudOptics {
 public:
  struct Part {
    int channel;
    double extinction, scattering;  ///< 1/m per unit of density
    const PhaseFunction* phase;
    const PhaseFunction* in_map;  ///< blunted to what the few photons of a density estimate can resolve
  };
  /// Highest value of a phase function in a density estimate, over that of an isotropic one.
  static constexpr double kMapPeak = 256;

  /// @param interval of the band; @param index the same interval among all of the World's.
  CloudOptics(const Cloud& cloud, const Band& band, int interval, int index);

  /// @param value callable: channel -> value of the present cell.
  template <class Value>
  LocalOptics at(Value&& value) const noexcept {
    LocalOptics result;
    for (const Part& part : parts_) {
      const double density = value(part.channel);
      result.extinction += density * part.extinction;
      result.scattering += density * part.scattering;
    }
    if (emits_) {
      result.emission = (result.extinction - result.scattering) * source(value);
      if (added_ != 0) result.emission += added_ * value(parts_.front().channel);
    }
    return result;
  }

  /// Of a cell. Extinction and scattering are their means. Of the mean of k_a B it is known to lie between the mean k_a
  /// times the least and the largest B: the middle is taken.
  /// @param bounds callable: channel -> Bounds of the cell
  /// @param allows called with the largest deviation of the extinction; nothing more is computed where it says no
  template <class CellBounds, class Allows>
  std::optional<CoarseOptics> coarse(CellBounds&& bounds, Allows&& allows) const noexcept {
    CoarseOptics cell;
    double least = 0, most = 0;  // absorption
    for (const Part& part : parts_) {
      const Bounds b = bounds(part.channel);
      const double low = b.min, high = b.max, middle = b.mean;
      cell.extinction += part.extinction * std::max(high - middle, middle - low);
      cell.mean.extinction += part.extinction * middle;
      cell.mean.scattering += part.scattering * middle;
      least += (part.extinction - part.scattering) * low;
      most += (part.extinction - part.scattering) * high;
    }
    if (!allows(cell.extinction)) return std::nullopt;
    if (!emits_) return cell;
    double coldest = constant_source_, warmest = constant_source_;
    if (temperature_.channel >= 0) std::tie(coldest, warmest) = source_range(bounds(temperature_.channel));
    const double mean = (cell.mean.extinction - cell.mean.scattering) * 0.5 * (coldest + warmest);
    cell.mean.emission = mean;
    cell.emission = std::max(most * warmest - mean, mean - least * coldest);
    return cell;
  }
  /// Largest emission over extinction that the cloud can have, W/m2/sr; infinite where it may emit without absorbing.
  double largest_source() const noexcept { return largest_source_; }

  const std::vector<Part>& parts() const noexcept { return parts_; }
  /// Extinction in 1/m per unit of every channel: the weights of the octree's walks.
  const std::vector<double>& extinction_weights() const noexcept { return weights_; }
  bool emits() const noexcept { return emits_; }
  bool scatters() const noexcept { return scatters_; }
  /// Emission over extinction where that ratio is the same in the whole cloud, W/m2/sr.
  std::optional<double> uniform_source() const noexcept { return uniform_source_; }

 private:
  template <class Value>
  double source(Value&& value) const noexcept {
    if (temperature_.channel < 0) return constant_source_;
    return (*planck_)(temperature_.scale * value(temperature_.channel) + temperature_.offset_K);
  }

  // Least and largest radiance of a black body where the temperature channel has these bounds, W/m2/sr.
  std::pair<double, double> source_range(const Bounds& value) const noexcept;

  std::vector<Part> parts_;
  std::vector<std::shared_ptr<const PhaseFunction>> blunted_;
  std::vector<double> weights_;
  bool emits_ = false;
  bool scatters_ = false;
  Temperature temperature_;
  double constant_source_ = 0;  // W/m2/sr, where there is no temperature channel
  double added_ = 0;            // W/m3/sr per unit of density
  std::optional<PlanckTable> planck_;
  std::optional<double> uniform_source_;
  double largest_source_ = 0;
};

}  // namespace obscura
