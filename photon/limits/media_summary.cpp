#include "photon/limits/media_summary.h"

#include <algorithm>

#include "photon/limits/summary_geometry.h"
#include "photon/paths/radiance.h"
#include "photon/world/footprint.h"
#include "photon/world/thickness.h"
#include "photon/world/world_walk.h"

namespace obscura {
namespace {

/// Factor that makes up for what rounding in sums of floats may have lost.
constexpr double kRounding = 1 + 1e-6;
/// Where a kelvin is counted in radiance.
constexpr double kCold_K = 250;

}  // namespace

LayerMaxima::LayerMaxima(const Octree& octree, const Affine& index_to_world) {
  const Box3i domain = octree.domain();
  const auto channels = static_cast<std::size_t>(octree.channel_count());
  if (domain.isEmpty()) return;
  const Vec3i size = domain.max - domain.min;
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    largest_[a].assign(channels, std::vector<float>(static_cast<std::size_t>(size[axis]), 0.0f));
    length_[a] = 0;
    for (int signs = 0; signs < 4; ++signs) {
      Vec3d way(1);
      way[(axis + 1) % 3] = signs & 1 ? 1 : -1;
      way[(axis + 2) % 3] = signs & 2 ? 1 : -1;
      length_[a] = std::max(length_[a], transform_direction(index_to_world, way).length());
      diagonal_ = std::max(diagonal_, transform_direction(index_to_world, way * Vec3d(size)).length());
    }
  }
  octree.for_each_leaf([&](const Cell& cell, std::span<const float> values) {
    for (int axis = 0; axis < 3; ++axis) {
      const int begin = std::max(cell.corner[axis] - domain.min[axis], 0);
      const int end = std::min(cell.corner[axis] + (1 << cell.level) - domain.min[axis], size[axis]);
      for (std::size_t c = 0; c < channels; ++c) {
        std::vector<float>& layers = largest_[static_cast<std::size_t>(axis)][c];
        for (int layer = begin; layer < end; ++layer) {
          layers[static_cast<std::size_t>(layer)] = std::max(layers[static_cast<std::size_t>(layer)], values[c]);
        }
      }
    }
  });
}

double LayerMaxima::largest_integral(const std::vector<double>& weights) const {
  double along = 0, most = kInfinity;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (largest_[axis].empty()) return 0;
    double sum = 0, largest = 0;
    for (std::size_t layer = 0; layer < largest_[axis].front().size(); ++layer) {
      double here = 0;
      for (std::size_t c = 0; c < weights.size(); ++c)
        here += weights[c] * static_cast<double>(largest_[axis][c][layer]);
      sum += here;
      largest = std::max(largest, here);
    }
    along = std::max(along, length_[axis] * sum);
    most = std::min(most, diagonal_ * largest);
  }
  return kRounding * std::min(along, most);
}

namespace {

/// Kelvin of the leaves that hold matter.
struct Kelvin {
  double coldest = kInfinity, warmest = -kInfinity;
};

Kelvin kelvin_of(const Cloud& cloud) {
  Kelvin range;
  const Temperature& t = cloud.temperature;
  if (t.channel < 0) return {t.constant_K, t.constant_K};
  cloud.octree->for_each_leaf([&](const Cell&, std::span<const float> values) {
    const bool matter = std::any_of(cloud.media.begin(), cloud.media.end(), [&](const Medium& medium) {
      return values[static_cast<std::size_t>(medium.channel)] > 0;
    });
    if (!matter) return;
    const double kelvin = t.scale * static_cast<double>(values[static_cast<std::size_t>(t.channel)]) + t.offset_K;
    range.coldest = std::min(range.coldest, kelvin);
    range.warmest = std::max(range.warmest, kelvin);
  });
  return range;
}

CloudLimits limits_of(SpectralWorld world, int c, const LayerMaxima& layers, const Kelvin& kelvin) {
  const Cloud& cloud = world->clouds()[static_cast<std::size_t>(c)];
  const CloudOptics& optics = world.optics(c);
  CloudLimits limits;
  std::vector<double> extinction(static_cast<std::size_t>(cloud.octree->channel_count()), 0.0);
  std::vector<double> scattering = extinction, absorption = extinction;
  for (const CloudOptics::Part& part : optics.parts()) {
    const auto channel = static_cast<std::size_t>(part.channel);
    extinction[channel] += part.extinction;
    scattering[channel] += part.scattering;
    absorption[channel] += part.extinction - part.scattering;
    if (!(part.extinction > 0)) continue;
    limits.albedo_max = std::max(limits.albedo_max, part.scattering / part.extinction);
    limits.albedo_min = std::min(limits.albedo_min, part.scattering / part.extinction);
    if (part.scattering > 0) limits.phase_max = std::max(limits.phase_max, part.phase->largest());
  }
  const auto largest = [&](const std::vector<double>& weights) {
    const double most = layers.largest_integral(weights);
    return most > 0 && world->frame(c).periodic() ? kInfinity : most;
  };
  limits.depth = largest(extinction);
  limits.depth_in_box = layers.largest_integral(extinction);
  limits.scattering_depth = largest(scattering);
  limits.absorption_depth = largest(absorption);

  limits.emits = optics.emits();
  if (limits.absorption_depth > 0) limits.source_min = 0;
  if (!limits.emits) return limits;
  const auto i = static_cast<std::size_t>(world.interval());
  const Band& band = world.band();
  if (!cloud.source.empty() && cloud.source[i]) {
    limits.source_min = limits.source_max = *cloud.source[i];
  } else if (!band.grey() && kelvin.warmest >= kelvin.coldest) {
    const auto planck = [&](double K) { return K > 0 ? band.planck(world.place_in_band().interval, K) : 0.0; };
    limits.source_min = planck(kelvin.coldest);
    limits.source_max = kRounding * planck(kelvin.warmest);
  }
  if (!(limits.absorption_depth > 0)) {
    limits.source_min = kInfinity;
    limits.source_max = 0;
  }
  if (world->contents().clouds[static_cast<std::size_t>(c)].emission.size() > i && cloud.emission[i] > 0)
    limits.source_max = kInfinity;
  return limits;
}

/// Largest and least radiance of a black body in the place of any of an object's points.
void add_object(SpectralWorld world, const Object& object, IntervalLimits& limits) {
  const Band& band = world.band();
  const auto i = static_cast<std::size_t>(world.interval());
  const auto add = [&](double black) {
    limits.surface_max = std::max(limits.surface_max, black);
    limits.surface_min = std::min(limits.surface_min, black);
  };
  for (const int slot : object.materials) {
    const Material& material = world->materials()[static_cast<std::size_t>(slot)];
    const MaterialOptics optics(material, world.interval());
    double factor = 1;
    for (const double at : material.angle_factor) factor = std::min(factor, at);
    const double reflectance = optics.reflects() ? 1 - material.emissivity[i] * factor : 0.0;
    limits.reflectance_max = std::max(limits.reflectance_max, reflectance);
    limits.mirror_max = std::max(limits.mirror_max, reflectance * material.specular);
    const double mean = 1 - optics.hemispherical_emissivity();
    if (mean > 0) limits.brdf_max = std::max(limits.brdf_max, reflectance * reflectance / (kPi * mean));
  }
  if (!object.radiance.empty() && object.radiance[i]) return add(*object.radiance[i]);
  const auto planck = [&](double K) {
    return !band.grey() && K > 0 ? band.planck(world.place_in_band().interval, K) : 0.0;
  };
  for (const double K : object.K) add(planck(K));
  if (!object.mesh) return;
  float coldest = std::numeric_limits<float>::infinity(), warmest = 0;
  for (const std::vector<float>* kelvin : {&object.mesh->vertex_K, &object.mesh->face_K}) {
    for (const float K : *kelvin) {
      coldest = std::min(coldest, K);
      warmest = std::max(warmest, K);
    }
  }
  if (!(warmest > 0)) return;
  add(planck(coldest));
  add(kRounding * planck(warmest));
}

/// The limits of everything but the clouds; what needs the view's rays is filled in later.
IntervalLimits surroundings(SpectralWorld world) {
  IntervalLimits limits;
  limits.band = world.place_in_band().band;
  limits.sky = world.sky();
  for (const Sun& sun : world->suns()) {
    limits.sun += world.value_of(sun.irradiance);
    if (world.value_of(sun.irradiance) > 0) {
      limits.disc = std::max(limits.disc, sun.diameter > 0 ? sun.radiance(world.interval()) : kInfinity);
    }
  }
  for (const Object& object : world->objects()) add_object(world, object, limits);
  for (const HotSphere& sphere : world->spheres()) {
    limits.sphere_max = std::max(limits.sphere_max, world.value_of(sphere.radiance));
    limits.sphere_min = std::min(limits.sphere_min, world.value_of(sphere.radiance));
  }
  for (const Beam& beam : world->beams()) limits.beams = limits.beams || world.value_of(beam.power) > 0;
  for (std::size_t s = world->source_count(); s < world->spheres().size(); ++s) {
    limits.beams = limits.beams || world.value_of(world->spheres()[s].radiance) > 0;
  }
  limits.air_extinction = world.air_extinction();
  limits.air = limits.air_extinction > 0 ? world.air_radiance() : 0.0;
  return limits;
}

void add_cloud(const CloudLimits& cloud, IntervalLimits& limits) {
  limits.depth += cloud.depth;
  limits.scattering_depth += cloud.scattering_depth;
  limits.absorption_depth += cloud.absorption_depth;
  limits.albedo_max = std::max(limits.albedo_max, cloud.albedo_max);
  limits.phase_max = std::max(limits.phase_max, cloud.phase_max);
  limits.source_max = std::max(limits.source_max, cloud.source_max);
  limits.source_min = std::min(limits.source_min, cloud.source_min);
  limits.emits = limits.emits || cloud.emits;
}

/// What a group of the view's rays sees in a band.
struct GroupSight {
  double radiance = 0;
  bool cloudy = false, surface = false;
};

/// What the view's rays see and cross.
/// @param seen of each group; radiance to be added to
void look(SpectralWorld world, const CameraView& view, IntervalLimits& limits, std::vector<GroupSight>& seen) {
  if (view.rays.empty()) return;
  RadianceSettings settings;
  settings.points = 8;
  settings.parts.map = settings.parts.sun_disc = false;
  std::vector<std::uint64_t> histories(view.rays.size());
  for (std::size_t r = 0; r < histories.size(); ++r) histories[r] = r;
  std::vector<Incoming> incoming(view.rays.size());
  incoming_radiance(world, nullptr, settings, view.rays, histories, incoming);
  seen.resize(view.rays.size() / view.together);
  const auto count = static_cast<double>(view.rays.size());
  for (std::size_t r = 0; r < view.rays.size(); ++r) {
    GroupSight& group = seen[r / view.together];
    group.radiance += incoming[r].total() / static_cast<double>(view.together);
    group.cloudy = group.cloudy || incoming[r].transmission < 1;
    group.surface = group.surface || incoming[r].distance < kInfinity;
    limits.lost += (1 - incoming[r].transmission) / count;
    limits.surfaces_hit += (incoming[r].distance < kInfinity) / count;
    Ray ray = view.rays[r];
    ray.t_max = std::min(ray.t_max, incoming[r].distance);
    if (world->periodic() && !(ray.t_max < kInfinity)) ray.t_max = ray.t_min + 20 * world->map_period().length();
    WorldWalk walk(world, ray);
    while (walk.next()) limits.segments += 1 / count;
  }
}

}  // namespace

IntervalLimits MediaSummary::limits(int interval, const std::vector<bool>& kept) const {
  IntervalLimits limits = intervals[static_cast<std::size_t>(interval)];
  limits.depth = limits.scattering_depth = limits.absorption_depth = 0;
  limits.albedo_max = limits.phase_max = limits.source_max = 0;
  limits.source_min = kInfinity;
  limits.emits = false;
  for (std::size_t c = 0; c < clouds.size(); ++c) {
    if (kept[c]) add_cloud(clouds[c].intervals[static_cast<std::size_t>(interval)], limits);
  }
  return limits;
}

MediaSummary summarize(const World& world, const CameraView& view) {
  MediaSummary summary;
  for (const MethodType* type : methods()) {
    Method method;
    method.type = type;
    if (unfit(world, method)) summary.unfit.push_back(type);
  }
  summary.periodic = world.periodic();
  for (int c = 0; c < world.cloud_count(); ++c) {
    const Cloud& cloud = world.clouds()[static_cast<std::size_t>(c)];
    const LayerMaxima layers(*cloud.octree, cloud.octree->index_to_local() * cloud.local_to_world);
    const Kelvin kelvin = kelvin_of(cloud);
    CloudSummary& entry = summary.clouds.emplace_back();
    entry.name = cloud.name;
    entry.periodic = world.frame(c).periodic();
    entry.in_view = entry.periodic || !detail::outside(view, detail::corners_of(world, c));
    std::vector<double> amounts(static_cast<std::size_t>(cloud.octree->channel_count()), 0.0);
    for (const Medium& medium : cloud.media) amounts[static_cast<std::size_t>(medium.channel)] = 1;
    entry.empty = !(layers.largest_integral(amounts) > 0);
    entry.warmest_K = kelvin.warmest >= kelvin.coldest ? kelvin.warmest : 0;
    for (int i = 0; i < world.interval_count(); ++i)
      entry.intervals.push_back(limits_of({world, i}, c, layers, kelvin));
  }
  std::vector<std::vector<GroupSight>> seen(world.bands().size());
  summary.bands.resize(world.bands().size());
  const bool sealed = detail::no_dark_backs(world, view);
  for (int i = 0; i < world.interval_count(); ++i) {
    IntervalLimits limits = surroundings({world, i});
    for (const CloudSummary& cloud : summary.clouds) add_cloud(cloud.intervals[static_cast<std::size_t>(i)], limits);
    // The minimum principle: nothing that is at least a black body of this radiance lets any be less
    // (photon/METHODS.md, "Bounds and the builder's measure").
    limits.floor = sealed ? std::min({limits.sky, limits.surface_min, limits.sphere_min, limits.source_min}) : 0.0;
    if (limits.air_extinction > 0) limits.floor = std::min(limits.floor, limits.air);
    limits.scattering_seen = largest_scattering_depth({world, i});
    limits.mean_cosine = largest_mean_cosine({world, i});
    look({world, i}, view, limits, seen[static_cast<std::size_t>(limits.band)]);
    summary.bands[static_cast<std::size_t>(limits.band)].floor += limits.floor;
    summary.intervals.push_back(limits);
  }
  for (std::size_t b = 0; b < seen.size(); ++b) {
    BandScale& scale = summary.bands[b];
    const Band& band = world.bands()[b];
    if (!band.grey()) scale.per_kelvin = band.planck_derivative(kCold_K);
    double cloudy = kInfinity, on_surfaces = kInfinity, all = kInfinity;
    for (const GroupSight& group : seen[b]) {
      all = std::min(all, group.radiance);
      if (group.cloudy) cloudy = std::min(cloudy, group.radiance);
      if (group.surface) on_surfaces = std::min(on_surfaces, group.radiance);
    }
    const auto known = [](double least) { return least < kInfinity ? std::max(0.0, least) : 0.0; };
    scale.least_cloudy = known(cloudy);
    scale.least_on_surfaces = known(on_surfaces);
    scale.least = known(all);
  }
  summary.reach_m = detail::reach(world, view);
  summary.box_out_of_view = detail::box_out_of_view(world, view);
  for (const Sun& sun : world.suns()) {
    summary.shaded.push_back(detail::shaded(world, view, sun));
    summary.disc_in_view.push_back(detail::sees_disc(view, sun));
  }
  return summary;
}

}  // namespace obscura
