// A cloud: an octree of densities (and temperature) with the optics of what it holds.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "octree/octree.h"
#include "photon/phase.h"
#include "photon/planck_table.h"

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
  int channel = -1;       ///< temperature channel, K = scale * value + offset_K; -1: none
  double scale = 1;
  double offset_K = 0;
  double constant_K = 0;  ///< used where there is no channel; 0: does not emit
};

struct Cloud {
  /// Most channels that its octree can have: kernels decode a brick of them without allocating.
  static constexpr int kMaxChannels = 16;

  std::string name;
  std::shared_ptr<const Octree> octree;
  Affine local_to_world;         ///< rotation, translation and uniform scale
  std::vector<Medium> media;     ///< several overlap: coefficients add
  Temperature temperature;
  /// Per interval, in place of Planck, W/m2/sr; nothing, or an empty list: Planck.
  std::vector<std::optional<double>> source;
  std::vector<double> emission;  ///< per interval, W/m3/sr per unit of the first medium's density
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
};

}  // namespace obscura
