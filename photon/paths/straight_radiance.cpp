#include "photon/paths/straight_radiance.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "photon/optics/purpose.h"
#include "photon/optics/transfer.h"
#include "photon/paths/direct_light.h"
#include "photon/paths/leg_steps.h"

namespace obscura::detail {
namespace {

class StraightPass {
 public:
  StraightPass(SpectralWorld world, const RadianceSettings& settings, std::span<const Ray> rays,
               std::span<const std::uint64_t> histories, std::span<Incoming> incoming)
      : world_(world),
        settings_(settings),
        rays_(rays),
        histories_(histories),
        incoming_(incoming),
        air_(world.air_extinction()),
        attenuates_(world.attenuates()) {
    counts_.rays = rays.size();
  }

  RadianceCounts run() {
    const bool masked = !world_->surfaces().empty();
    const bool emits = settings_.parts.emission && world_.emits();
    const std::optional<double> source = air_ > 0 ? std::nullopt : world_.uniform_source();
    // Where leaves are followed in any case, they tell the depth too.
    const bool followed = (emits && !source) || (air_ > 0 && attenuates_ && settings_.parts.emission);
    WorkCounts& work = counts_.work;
    if (masked) work[Work::masking] += rays_.size();
    if (air_ > 0) work[Work::atmosphere] += rays_.size();
    if (attenuates_) work[Work::extinction] += rays_.size();

    std::vector<SurfaceHit> hits;
    std::vector<Ray> ended;
    std::span<const Ray> rays = rays_;
    // Only what lies along a ray has to know beforehand where it ends.
    if (masked && (attenuates_ || followed || air_ > 0)) {
      hits.resize(rays_.size());
      ended.assign(rays_.begin(), rays_.end());
      for (std::size_t i = 0; i < hits.size(); ++i) {
        hits[i] = first_hit(i);
        ended[i].t_max = std::min(rays_[i].t_max, hits[i].t);
      }
      rays = ended;
    }
    std::vector<double> depths(attenuates_ ? rays.size() : 0);
    if (attenuates_ && !followed) world_.optical_depths(rays, depths);

    const Straight straight{rays, hits, depths, source, emits, followed};
    if (masked) {
      air_ > 0 ? add_up<true, true>(straight) : add_up<true, false>(straight);
    } else {
      air_ > 0 ? add_up<false, true>(straight) : add_up<false, false>(straight);
    }
    return counts_;
  }

 private:
  SurfaceHit first_hit(std::size_t i) {
    if (!world_->permeable()) return world_->surfaces().intersect(rays_[i]);
    Stream stream = StreamName{settings_.seed, histories_[i], Purpose::radiance, world_.interval(), kMeetStep}.stream();
    return world_->meet(rays_[i], {}, stream);
  }

  /// What is known of straight rays: where each ends unless that does not matter yet, and the clouds' depth unless
  /// leaves are followed.
  struct Straight {
    std::span<const Ray> rays;
    std::span<const SurfaceHit> hits;
    std::span<const double> depths;
    std::optional<double> source;
    bool emits, followed;
  };

  template <bool kMasked, bool kAir>
  void add_up(const Straight& straight) {
    const bool background = settings_.parts.background, discs = settings_.parts.sun_disc && !world_->suns().empty();
    const bool glows = world_.glows(), followed = straight.followed, emits = straight.emits;
    const double sky = world_.sky(), source = straight.source.value_or(0.0);
    const double* depths = followed || straight.depths.empty() ? nullptr : straight.depths.data();
    const Ray* rays = straight.rays.data();
    Incoming* incoming = incoming_.data();
    std::uint64_t emissions = 0;
    const bool ends_known = !straight.hits.empty();
    for (std::size_t i = 0; i < straight.rays.size(); ++i) {
      SurfaceHit hit;
      if constexpr (kMasked) hit = ends_known ? straight.hits[i] : first_hit(i);
      double depth = depths ? depths[i] : 0.0;
      double along = 0;
      if (followed) {
        along = light_along(world_, rays[i], nullptr, &depth);
        emissions += emits && (depth > 0 || glows);
      } else if (emits && depth > 0) {
        along = source * one_minus_exp(depth);
        ++emissions;
      }
      const double transmission = depth == 0 ? 1.0 : std::exp(-depth);
      double direct = 0;
      if (background) {
        direct = transmission * (kMasked && hit.exists() ? behind(rays[i], hit)
                                 : discs                 ? world_.background(rays[i].direction)
                                                         : sky);
      }
      direct += along;
      if (!std::isfinite(direct)) {
        direct = 0;
        ++counts_.anomalies;
      }
      Incoming& in = incoming[i];
      in.direct = direct;
      in.map.fill(0);
      in.bias = in.variance = 0;
      in.transmission = transmission;
      in.transmission_air = kAir ? air(rays[i].t_max) : 1.0;
      in.distance = kMasked ? hit.t : kInfinity;
    }
    counts_.work[Work::emission] += emissions;
  }

  double behind(const Ray& ray, const SurfaceHit& hit) {
    ++counts_.work[Work::surfaces];
    return surface_behind(world_, ray, hit, air(hit.t));
  }

  double air(double distance) const noexcept { return transmission_over(air_, distance); }

  SpectralWorld world_;
  const RadianceSettings& settings_;
  std::span<const Ray> rays_;
  std::span<const std::uint64_t> histories_;
  std::span<Incoming> incoming_;
  double air_;
  bool attenuates_;
  RadianceCounts counts_;
};

}  // namespace

RadianceCounts straight_radiance(SpectralWorld world, const RadianceSettings& settings, std::span<const Ray> rays,
                                 std::span<const std::uint64_t> histories, std::span<Incoming> incoming) {
  return StraightPass(world, settings, rays, histories, incoming).run();
}

}  // namespace obscura::detail
