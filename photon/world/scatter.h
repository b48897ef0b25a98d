// Scattering at a point of the World: the mixture of the media's phase functions by their scattering.
#pragma once

#include "photon/optics/sampling.h"
#include "photon/world/spectral_world.h"

namespace obscura {

/// What scatters at one point, made once and used for many directions. A small fixed list: of a point
/// that holds more than kMost scattering media the first are kept, which only a scene with dozens of
/// overlapping media at one place would see.
class LocalScattering {
 public:
  LocalScattering(SpectralWorld world, const Vec3d& point) noexcept {
    for (int c = 0; c < world->cloud_count(); ++c) {
      const CloudOptics& optics = world.optics(c);
      if (!optics.scatters()) continue;
      const Octree& octree = *world->clouds()[static_cast<std::size_t>(c)].octree;
      const Vec3d index = world->index_point(c, point);
      for (const CloudOptics::Part& part : optics.parts()) {
        const double scattering = part.scattering * static_cast<double>(octree.value(part.channel, index));
        if (scattering > 0 && count_ < kMost) {
          entries_[count_++] = {part.phase, part.in_map, scattering};
          total_ += scattering;
        }
      }
    }
  }

  /// Where a flight has collided: where there is only one medium, nothing has to be looked up. total() is then
  /// not known.
  static LocalScattering at_collision(SpectralWorld world, const Vec3d& point) noexcept {
    const CloudOptics::Part* only = world.only_medium();
    return only && only->scattering > 0 ? LocalScattering(*only) : LocalScattering(world, point);
  }

  /// 1/m
  double total() const noexcept { return total_; }

  /// Phase function of the mixture, 1/sr. 0 where nothing scatters.
  double phase(double cosine) const noexcept { return mixture(&Entry::phase, cosine); }
  /// The same, blunted for density estimates.
  double phase_in_map(double cosine) const noexcept { return mixture(&Entry::in_map, cosine); }

  /// A new direction from the mixture. u chooses the medium and then its lobe.
  Vec3d sample(const Vec3d& direction, double u, double v, double w) const noexcept {
    std::size_t i = 0;
    double target = u * total_;
    while (i + 1 < count_ && target >= entries_[i].scattering) target -= entries_[i++].scattering;
    const double choice = std::clamp(target / entries_[i].scattering, 0.0, 1.0 - 0x1p-53);
    return direction_about(direction, entries_[i].phase->sample(v, choice), 2 * kPi * w);
  }

 private:
  explicit LocalScattering(const CloudOptics::Part& only) noexcept : count_(1), total_(1) {
    entries_[0] = {only.phase, only.in_map, 1};
  }

  struct Entry {
    const PhaseFunction* phase;
    const PhaseFunction* in_map;
    double scattering;
  };

  double mixture(const PhaseFunction* Entry::*which, double cosine) const noexcept {
    if (count_ == 1) return (entries_[0].*which)->value(cosine);
    double sum = 0;
    for (std::size_t i = 0; i < count_; ++i) sum += entries_[i].scattering * (entries_[i].*which)->value(cosine);
    return total_ > 0 ? sum / total_ : 0.0;
  }

  static constexpr std::size_t kMost = 64;
  std::array<Entry, kMost> entries_;
  std::size_t count_ = 0;
  double total_ = 0;
};

}  // namespace obscura
