#include "scene/hiding/obscuration.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "octree/base/error.h"
#include "photon/world/spectral_world.h"
#include "scene/file/scene_words.h"
#include "scene/run/origin.h"
#include "scene/session/session.h"
#include "sensor/sight/sight.h"

namespace obscura {
namespace {

/// Lines of sight on an object that a replica should have where pixels of a small one can have more, and at least.
constexpr double kLinesWanted = 512, kLinesNeeded = 16;
/// Most lines through a pixel in one replica for that.
constexpr double kMostLines = 256;
constexpr const char* kStopped = "stopped before there were two replicas: nothing is said";

/// An object that is looked at.
struct Target {
  std::size_t index;
  ObjectMask mask;
  int lines_per_pixel;  // in one replica
};

struct InView {
  std::vector<Target> targets;
  std::vector<std::string> left_out;
};

std::vector<float> dense(const std::vector<std::pair<std::uint32_t, float>>& shares, std::size_t pixels) {
  std::vector<float> result(pixels);
  for (const auto& [pixel, share] : shares) result[pixel] = share;
  return result;
}

/// Objects whose lines of sight can be told from their surroundings': those asked for, or all that are wholly in the
/// picture.
InView objects_in_view(Session& session, const ObscurationWish& wish, const Progress& progress) {
  const Camera camera(session.plan().camera);
  const auto shares = object_shares(session.world(), camera, progress);
  if (progress.cancelled()) throw NumericalError("obscuration", kStopped);
  const std::vector<ObjectDescription>& objects = session.scene().objects;
  const auto pixels = static_cast<std::size_t>(camera.columns()) * static_cast<std::size_t>(camera.rows());
  const double lines = std::ceil(static_cast<double>(session.rays_per_pixel()) / wish.replicas);

  std::vector<std::string> seen;
  for (std::size_t o = 0; o < objects.size(); ++o) {
    if (!shares[o].empty()) seen.push_back(objects[o].name);
  }
  InView view;
  std::vector<Problem> problems;
  for (std::size_t o = 0; o < objects.size(); ++o) {
    const std::string& name = objects[o].name;
    const bool asked = std::ranges::find(wish.objects, name) != wish.objects.end();
    if (!asked && !wish.objects.empty()) continue;
    std::string why, remedy;
    Target target{o, {}, 0};
    if (shares[o].empty()) {
      why = "is not in view";
      remedy = seen.empty() ? "no object is: look at one" : fmt::format("in view: {}", fmt::join(seen, ", "));
    } else {
      target.mask = mask_of(camera.columns(), camera.rows(), dense(shares[o], pixels), wish.ring_px);
      const double area = target.mask.area();
      target.lines_per_pixel = static_cast<int>(std::max(lines, std::min(kMostLines, std::ceil(kLinesWanted / area))));
      if (!asked && target.mask.at_border()) {
        why = "reaches beyond the picture";
        remedy = fmt::format("--object \"{}\" takes it all the same", name);
      } else if (area * target.lines_per_pixel < kLinesNeeded) {
        why = fmt::format("covers {:.2g} pixels: too little to be measured", area);
        remedy = "make the field of view smaller, or the resolution higher";
      } else if (static_cast<double>(target.mask.ring_size()) * target.lines_per_pixel < kLinesNeeded) {
        why = "leaves no surroundings in the picture";
        remedy = "make the field of view wider";
      }
    }
    if (why.empty()) {
      view.targets.push_back(std::move(target));
    } else if (asked) {
      problems.push_back({"--object " + name, "the object " + why, remedy});
    } else {
      view.left_out.push_back(name + " " + why);
    }
  }
  if (!problems.empty()) throw InputError(std::move(problems));
  if (view.targets.empty()) {
    throw InputError("objects", fmt::format("no object is wholly in the picture: {}", fmt::join(view.left_out, "; ")),
                     seen.empty() ? "look at one" : fmt::format("name one: --object \"{}\"", seen.front()));
  }
  return view;
}

void require_names(const Description& scene, const ObscurationWish& wish) {
  std::vector<Problem> problems;
  if (scene.clouds.empty()) problems.push_back({"clouds", "the scene has no cloud: nothing hides anything", "add one"});
  if (scene.objects.empty()) problems.push_back({"objects", "the scene has no object to look at", "add one"});
  std::vector<std::string> names;
  for (const ObjectDescription& object : scene.objects) names.push_back(object.name);
  for (const std::string& name : wish.objects) {
    if (names.empty() || std::ranges::find(names, name) != names.end()) continue;
    problems.push_back({"--object " + name, "the scene has no object of this name",
                        fmt::format("{}; there are: {}", detail::suggest(name, names), fmt::join(names, ", "))});
  }
  if (!problems.empty()) throw InputError(std::move(problems));
}

/// Anomalies among what was done.
struct Tally {
  std::uint64_t anomalies = 0, work = 0;

  void add(const Light& light) {
    anomalies += light.anomalies;
    work += light.emitted;
  }
  void add(const RadianceCounts& counts) {
    anomalies += counts.anomalies;
    work += counts.rays + counts.work[Work::scattering];
  }
};

/// The detector's noise at its integration time as a difference of temperature; none where all bands are grey.
std::optional<double> noise_K(const DetectorSettings& detector, std::span<const Band> bands) {
  for (const Band& band : bands) {
    if (!band.grey()) return noise_radiance(detector, band) / band.planck_derivative(detector.nedt_at_K);
  }
  return std::nullopt;
}

/// The blur of a map is no part of any interval.
void warn_of_blur(Session& cloudy, const Method& method, std::vector<std::string>& warnings) {
  if (method.type != &kPhotonMap) return;
  for (int i = 0; i < cloudy.world().interval_count(); ++i) {
    if (!SpectralWorld(cloudy.world(), i).surfaces_reflect()) continue;
    warnings.emplace_back(
        "surfaces reflect and nothing is gathered: the blur of the photon map, which no interval holds, may be larger "
        "than the contrast; compare with --method path");
    return;
  }
}

/// Replicas by target and band.
using Found = std::vector<std::vector<std::vector<SightReplica>>>;

}  // namespace

Obscuration find_obscuration(const Description& scene, const ObscurationWish& wish, const Progress& progress) {
  require_names(scene, wish);
  Obscuration result;
  result.scene = scene.name;
  result.hash = scene.hash;
  result.seed = scene.render.seed;
  result.time_s = wish.time_s.value_or(scene.time_s);
  result.wish = wish;
  result.warnings = scene.warnings;

  Description clear_scene = scene;
  clear_scene.clouds.clear();
  Session cloudy(scene, result.time_s, progress, 0), clear(clear_scene, result.time_s, progress, 0);
  const std::vector<std::string>& planned = cloudy.plan().warnings;
  result.warnings.insert(result.warnings.end(), planned.begin(), planned.end());
  InView view = objects_in_view(cloudy, wish, progress);
  result.left_out = view.left_out;

  if (const DetectorSettings& detector = scene.sensor.detector; !wish.thresholds.difference_K && detector.nedt_K > 0) {
    result.wish.thresholds.difference_K = noise_K(detector, cloudy.world().bands());
  }

  // Both looks are estimated in one way, or the methods would be part of what they differ by.
  const Method method = cloudy.plan().method;
  warn_of_blur(cloudy, method, result.warnings);

  Found found(view.targets.size(), std::vector<std::vector<SightReplica>>(scene.bands.size()));
  Tally tally;
  for (int replica = 0; replica < wish.replicas && !progress.cancelled(); ++replica) {
    // The first replica has the scene's own seed: its photons make the pictures too.
    const std::uint64_t seed = scene.render.seed + 1000003 * static_cast<std::uint64_t>(replica);
    std::vector<std::vector<Sight>> sights(2);
    for (std::size_t side = 0; side < 2; ++side) {
      Session& session = side == 0 ? cloudy : clear;
      const Progress part = progress.part("replicas", 2 * static_cast<std::uint64_t>(replica) + side,
                                          2 * static_cast<std::uint64_t>(wish.replicas));
      const Estimator estimator = session.estimator(method, seed, part);
      if (estimator.light) tally.add(*estimator.light);
      const CameraSettings& camera = session.plan().camera;
      for (const Target& target : view.targets) {
        const SightRays rays = sight_rays(Camera(camera), target.mask, target.lines_per_pixel, seed);
        sights[side].push_back(
            look(session.world(), estimator.radiance, rays, static_cast<std::uint32_t>(target.index), part));
        tally.add(sights[side].back().counts);
      }
      if (replica == 0 && wish.pictures && !progress.cancelled()) {
        const Rendered made = session.render(camera, session.plan().sampling, method, seed, part);
        (side == 0 ? result.with : result.without) =
            develop(made.film, session.world().bands(), origin_of(session, method, made.counts, seed, result.time_s));
      }
    }
    if (progress.cancelled()) break;
    for (std::size_t t = 0; t < view.targets.size(); ++t) {
      for (std::size_t b = 0; b < scene.bands.size(); ++b) {
        found[t][b].push_back({std::move(sights[0][t].transmission[b]), std::move(sights[0][t].looks[b]),
                               std::move(sights[1][t].looks[b])});
      }
    }
    ++result.replicas;
  }
  result.partial = progress.cancelled();
  if (result.replicas < 2) throw NumericalError("obscuration", kStopped);

  for (std::size_t t = 0; t < view.targets.size(); ++t) {
    Target& target = view.targets[t];
    ObjectObscuration object;
    object.name = scene.objects[target.index].name;
    object.lines_per_pixel = target.lines_per_pixel * result.replicas;
    if (target.mask.at_border())
      object.notes.emplace_back("the object reaches beyond the picture: only what is in view is measured");
    for (std::size_t b = 0; b < scene.bands.size(); ++b) {
      const auto blind = [](const SightReplica& r) { return r.transmission.empty() || !(r.with.surround_lines > 0); };
      if (std::ranges::any_of(found[t][b], blind)) {
        throw InputError("--object " + object.name,
                         "some replicas have no line of sight to the object or to its surroundings",
                         "make the field of view smaller, or the resolution higher");
      }
      object.bands.push_back(find_obscuration(cloudy.world().bands()[b], found[t][b], result.wish.thresholds));
    }
    object.mask = std::move(target.mask);
    result.objects.push_back(std::move(object));
  }
  if (static_cast<double>(tally.anomalies) > 1e-6 * static_cast<double>(tally.work)) {
    result.failure = fmt::format("{} impossible values in {} rays and photons: more than one in a million",
                                 tally.anomalies, tally.work);
  }
  return result;
}

}  // namespace obscura
