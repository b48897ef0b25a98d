#include "scene/verify/verify.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "octree/base/error.h"
#include "photon/ordinates/ordinates_referee.h"
#include "photon/paths/fluence.h"
#include "photon/paths/path_tracer.h"
#include "scene/session/session.h"
#include "sensor/capture/render.h"

namespace obscura {
namespace {

/// Directions of a probe, and paths a side of a rectangle, in one pass.
constexpr int kProbeDirections = 2048;
constexpr int kFluxPaths = 16384;
/// Rays of a pixel for the ordinates, whose radiance has no noise: they average over the pixel.
constexpr int kOrdinatesRays = 4;
/// What the ordinates call their error is about one standard error; a difference of twice of it is no difference.
constexpr double kOrdinatesAllowance = 2;
/// Most cells along an axis.
constexpr int kMostCells = 32;
/// Resolutions of parts of the picture and of single points and rectangles, in units of that of its mean.
constexpr double kCoarserPart = 1.5;
constexpr double kCoarserPoint = 4;

std::size_t index_of(Referee method) noexcept { return static_cast<std::size_t>(method); }

/// Methods must not share random numbers, nor passes: errors of differences would be wrong.
std::uint64_t seed_of(const VerifySettings& settings, Referee method, int pass) {
  return settings.seed * 1000003 + 1000 * (index_of(method) + 1) + static_cast<std::uint64_t>(pass);
}

/// What is measured, in the order in which methods give it.
std::vector<VerifyRow> quantities(const Description& scene) {
  const Film film({scene.sensor.resolution, 1});
  std::vector<VerifyRow> rows;
  for (const BandDescription& band : scene.bands) {
    const auto row = [&](std::string quantity, double coarser) {
      rows.push_back({std::move(quantity), band.name, coarser, {}, {}});
    };
    row("mean", 1);
    for (int t = 0; film.tile_count() > 1 && t < film.tile_count(); ++t) {
      const auto [x, y, columns, lines] = film.tile_box(t);
      row(fmt::format("x {}-{} y {}-{}", x, x + columns - 1, y, y + lines - 1), kCoarserPart);
    }
    for (const ProbeDescription& probe : scene.probes) row("fluence " + probe.name, kCoarserPoint);
    for (const FluxDescription& flux : scene.flux) {
      row("flux " + flux.name + " forward", kCoarserPoint);
      row("flux " + flux.name + " backward", kCoarserPoint);
    }
  }
  return rows;
}

Measured measured(const ImageMean& mean, bool batches) {
  return {mean.mean, mean.standard_error, batches ? kBatches - 1.0 : std::numeric_limits<double>::infinity(), 0};
}

/// The estimated bias of a mean: estimates of pixels scatter about it.
double mean_bias(const Film& film, int band, const std::array<int, 4>& box) {
  const std::span<const float> bias = film.values(band, Film::Value::bias);
  double sum = 0;
  for (int y = box[1]; y < box[1] + box[3]; ++y) {
    for (int x = box[0]; x < box[0] + box[2]; ++x) sum += bias[static_cast<std::size_t>(y * film.columns() + x)];
  }
  return std::abs(sum) / (box[2] * box[3]);
}

void add_means(const Film& film, int band, bool batches, std::vector<std::optional<Measured>>& values) {
  const auto add = [&](const ImageMean& mean, const std::array<int, 4>& box) {
    Measured value = measured(mean, batches);
    value.bias = mean_bias(film, band, box);
    values.emplace_back(value);
  };
  add(film.mean(band), {0, 0, film.columns(), film.rows()});
  for (int t = 0; film.tile_count() > 1 && t < film.tile_count(); ++t)
    add(film.mean_of_tile(t, band), film.tile_box(t));
}

/// One run of photon map or path tracer: the numbers of quantities(), and the film.
struct Pass {
  std::vector<std::optional<Measured>> values;
  Film film;
};

Measured flux_by_photons(const BatchTally& shares) {
  BatchTally batches = shares;
  for (double& watts : batches) watts *= kBatches;
  const BatchMean mean = batch_mean(batches);
  return {mean.mean, mean.standard_error, kBatches - 1.0, 0};
}

Measured flux_by_paths(const Session& session, int band, std::size_t rectangle, bool forward) {
  const World& world = session.world();
  PathSettings settings;
  settings.specular_depth = session.plan().radiance.specular_depth;
  settings.scattering_depth = session.plan().radiance.scattering_depth;
  settings.seed = session.plan().radiance.seed;
  Measured sum;
  for (int i = 0; i < world.interval_count(); ++i) {
    if (world.interval(i).band != band) continue;
    const PathFlux power = path_flux(world, i, settings, session.rectangles()[rectangle], kFluxPaths, rectangle);
    const BatchMean& side = forward ? power.forward : power.backward;
    sum.value += side.mean;
    sum.error = std::hypot(sum.error, side.standard_error);
  }
  return sum;
}

Measured fluence_by_rays(const Session& session, const Light& light, int band, std::size_t probe) {
  const World& world = session.world();
  Measured sum;
  for (int i = 0; i < world.interval_count(); ++i) {
    if (world.interval(i).band != band) continue;
    const PhotonMaps* maps = light.maps.empty() ? nullptr : &light.maps[static_cast<std::size_t>(i)];
    const Fluence here = fluence(world, i, maps, session.plan().radiance, session.scene().probes[probe].position_m,
                                 kProbeDirections, probe);
    sum.value += here.mean;
    sum.error = std::hypot(sum.error, here.standard_error);
    sum.bias += std::abs(here.bias);
    if (maps) sum.freedom = kBatches - 1.0;
  }
  return sum;
}

Pass run_pass(Session& session, Referee method, const VerifySettings& settings, int pass, const Progress& progress) {
  RenderDescription render = session.scene().render;
  render.method = method == Referee::path ? MethodKind::path : MethodKind::photon;
  render.seed = seed_of(settings, method, pass);
  session.set_render(render);
  const auto part = [&](int half) {
    return progress.part(session.scene().name + ": " + name_of(method), static_cast<std::uint64_t>(2 * pass + half),
                         static_cast<std::uint64_t>(2 * settings.passes));
  };
  const Light& light = session.light(part(0));
  Pass result{{}, session.render(part(1)).film};
  const bool batches = !light.maps.empty();
  for (std::size_t b = 0; b < session.scene().bands.size(); ++b) {
    const int band = static_cast<int>(b);
    add_means(result.film, band, batches, result.values);
    if (progress.cancelled()) continue;
    for (std::size_t p = 0; p < session.scene().probes.size(); ++p) {
      result.values.emplace_back(fluence_by_rays(session, light, band, p));
    }
    for (std::size_t r = 0; r < session.rectangles().size(); ++r) {
      for (const bool forward : {true, false}) {
        result.values.emplace_back(
            batches ? flux_by_photons(forward ? light.bands[b].flux[r].forward : light.bands[b].flux[r].backward)
                    : flux_by_paths(session, band, r, forward));
      }
    }
  }
  return result;
}

VerifyPicture picture_of(const Film& film, int band) {
  const auto copy = [&](Film::Value value) {
    const std::span<const float> values = film.values(band, value);
    return std::vector<float>(values.begin(), values.end());
  };
  return {copy(Film::Value::radiance), copy(Film::Value::error), copy(Film::Value::bias)};
}

/// Photon map or path tracer, as often as asked; numbers and pictures are the means.
void run_random(Session& session, Referee method, const VerifySettings& settings, const Progress& progress,
                VerifyMethod& result) {
  if (method == Referee::path) refuse_unfit_paths(session.world());
  std::vector<Pass> passes;
  for (int p = 0; p < settings.passes && !progress.cancelled(); ++p) {
    passes.push_back(run_pass(session, method, settings, p, progress));
    if (p > 0) passes.front().film.merge(passes.back().film);
  }
  if (progress.cancelled()) return;
  for (std::size_t q = 0; q < passes.front().values.size(); ++q) {
    std::vector<Measured> values;
    for (const Pass& pass : passes) values.push_back(*pass.values[q]);
    result.values.emplace_back(mean_of(values));
  }
  for (int band = 0; band < passes.front().film.bands(); ++band)
    result.pictures.push_back(picture_of(passes.front().film, band));
  const RenderDescription& render = session.scene().render;
  const int rays = session.plan().sampling.max_oversampling;
  const std::string gather = session.plan().radiance.gather_bounces > 0
                                 ? fmt::format("final gather by {} paths a pixel", render.samples)
                                 : std::string("no final gather");
  result.what = method == Referee::path
                    ? fmt::format("{} times {} paths a pixel over {} rays", settings.passes, render.samples, rays)
                    : fmt::format("{} maps of {} photons, {} nearest, {}, {} rays a pixel", settings.passes,
                                  render.photons, render.nearest, gather, rays);
}

/// Whether all cells of a grid are the same along an axis.
bool same_along(const OrdinatesGrid& grid, int axis) {
  for (std::size_t i = 0; i < grid.size(); ++i) {
    Vec3i first = grid.cell_at(i);
    first[axis] = 0;
    const std::size_t j = grid.index(first);
    const auto same = [&](const std::vector<double>& values) {
      return std::abs(values[i] - values[j]) <= 1e-9 * std::abs(values[j]);
    };
    if (!same(grid.extinction) || !same(grid.scattering) || !same(grid.emission)) return false;
  }
  return true;
}

/// Cells of the finest grid: one where a World that repeats does not vary (told by a prime number of cells), else
/// as the ordinates choose them, in halves where there is room, so that the coarse grid of their own error holds
/// the voxels too.
Vec3i cells_of(const World& world) {
  Vec3i wish(0);
  if (world.periodic()) {
    const OrdinatesGrid trial(world, 0, Vec3i(13, 13, 0), std::nullopt, 2);
    for (int axis = 0; axis < 2; ++axis) wish[axis] = trial.periodic(axis) && same_along(trial, axis) ? 1 : 0;
  }
  Vec3i cells = OrdinatesGrid(world, 0, wish, std::nullopt, 1).cells();
  if (2 * std::max({cells.x, cells.y, cells.z}) > kMostCells) return cells;
  for (int axis = 0; axis < 3; ++axis) cells[axis] *= cells[axis] > 1 ? 2 : 1;
  return cells;
}

void run_ordinates(const Session& session, const VerifySettings& settings, const Progress& progress,
                   VerifyMethod& result) {
  const World& world = session.world();
  const Description& scene = session.scene();
  const std::string stage = scene.name + ": " + name_of(Referee::ordinates);
  const auto parts = static_cast<std::uint64_t>(world.interval_count()) + 1;
  OrdinatesSettings fine;
  fine.cells = cells_of(world);
  std::vector<OrdinatesReferee> solved;
  for (int i = 0; i < world.interval_count(); ++i) {
    if (progress.cancelled()) return;
    solved.emplace_back(world, i, fine, progress.part(stage, static_cast<std::uint64_t>(i), parts));
  }

  const Estimator by_ordinates = [&](int interval, double, std::span<const Ray> rays, std::span<const std::uint64_t>,
                                     std::span<Incoming> incoming) {
    std::vector<OrdinatesEstimate> estimates(rays.size());
    solved[static_cast<std::size_t>(interval)].radiance(rays, estimates, incoming);
    for (std::size_t r = 0; r < rays.size(); ++r) {
      incoming[r].direct = estimates[r].value;
      incoming[r].bias = kOrdinatesAllowance * estimates[r].error;
    }
    RadianceCounts counts;
    counts.rays = rays.size();
    return counts;
  };
  SamplerSettings sampling;
  sampling.max_oversampling = std::min(kOrdinatesRays, scene.sensor.max_oversampling);
  sampling.seed = seed_of(settings, Referee::ordinates, 0);
  const Film film =
      render(world, by_ordinates, Camera(session.plan().camera), sampling, progress.part(stage, parts - 1, parts)).film;

  for (std::size_t b = 0; b < scene.bands.size(); ++b) {
    const int band = static_cast<int>(b);
    add_means(film, band, false, result.values);
    for (const ProbeDescription& probe : scene.probes) {
      if (progress.cancelled()) return;
      Measured sum;
      for (int i = 0; i < world.interval_count(); ++i) {
        if (world.interval(i).band != band) continue;
        const OrdinatesEstimate here = solved[static_cast<std::size_t>(i)].fluence_at(probe.position_m);
        sum.value += here.value;
        sum.bias += kOrdinatesAllowance * here.error;
      }
      result.values.emplace_back(sum);
    }
    for (std::size_t r = 0; r < session.rectangles().size(); ++r)
      result.values.insert(result.values.end(), 2, std::nullopt);
    result.pictures.push_back(picture_of(film, band));
  }
  const Vec3i& cells = solved.front().finest().grid().cells();
  int sweeps = 0;
  for (const OrdinatesReferee& interval : solved) sweeps = std::max(sweeps, interval.finest().iterations());
  result.what = fmt::format("{} x {} x {} cells, S{}, {} sweeps, and half of both; {} rays a pixel", cells.x, cells.y,
                            cells.z, fine.order, sweeps, sampling.max_oversampling);
}

void compare(const VerifySettings& settings, VerifiedScene& result) {
  const auto each_pair = [](const auto& visit) {
    for (std::size_t a = 0; a < kReferees.size(); ++a) {
      for (std::size_t b = a + 1; b < kReferees.size(); ++b) visit(kReferees[a], kReferees[b]);
    }
  };
  AgreementRule rule;
  rule.false_alarm = settings.false_alarm / (3.0 * static_cast<double>(result.rows.size()) * settings.scenes);
  for (VerifyRow& row : result.rows) {
    rule.resolution = settings.resolution * row.coarser;
    each_pair([&](Referee a, Referee b) {
      const auto &first = row.measured[index_of(a)], &second = row.measured[index_of(b)];
      if (first && second) row.pairs.push_back({a, b, agreement(*first, *second, rule)});
    });
  }
  for (std::size_t band = 0; band < result.bands.size(); ++band) {
    each_pair([&](Referee a, Referee b) {
      const auto &first = result.method(a).pictures, &second = result.method(b).pictures;
      if (first.empty() || second.empty()) return;
      result.pixels.push_back({result.bands[band], a, b, pixel_agreement(first[band].view(), second[band].view())});
    });
  }
}

}  // namespace

const char* name_of(Referee method) noexcept {
  constexpr std::array<const char*, 3> names{"photon", "path", "ordinates"};
  return names[index_of(method)];
}

VerifyMethod run_method(Session& session, Referee method, const VerifySettings& settings, const Progress& progress) {
  VerifyMethod result;
  const auto begin = std::chrono::steady_clock::now();
  try {
    if (method == Referee::ordinates) {
      run_ordinates(session, settings, progress, result);
    } else {
      run_random(session, method, settings, progress, result);
    }
  } catch (const NumericalError& error) {
    result = {};
    result.refusal = error.what();
  } catch (const InputError& error) {
    // The scene has been built: what is wrong is wrong for this method.
    result = {};
    result.refusal = error.what();
  } catch (const ResourceError& error) {
    if (method != Referee::ordinates) throw;
    result = {};
    result.refusal = error.what();
  }
  if (progress.cancelled()) result.refusal = "stopped";
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return result;
}

VerifiedScene compare_methods(const Description& scene, ByReferee<VerifyMethod> methods,
                              const VerifySettings& settings) {
  VerifiedScene result;
  result.name = scene.name;
  result.resolution = scene.sensor.resolution;
  for (const BandDescription& band : scene.bands) {
    result.bands.push_back(band.name);
    result.grey.push_back(band.grey());
  }
  result.demands_resolution = settings.resolution > 0;
  result.methods = std::move(methods);
  result.rows = quantities(scene);
  for (std::size_t m = 0; m < kReferees.size(); ++m) {
    const auto& values = result.methods[m].values;
    for (std::size_t q = 0; q < values.size(); ++q) result.rows[q].measured[m] = values[q];
  }
  compare(settings, result);
  return result;
}

VerifiedScene verify_scene(const Description& scene, const VerifySettings& settings, const Progress& progress) {
  Session session(scene, scene.time_s, progress, 0);
  ByReferee<VerifyMethod> methods;
  for (const Referee method : kReferees) methods[index_of(method)] = run_method(session, method, settings, progress);
  if (!progress.cancelled()) return compare_methods(scene, std::move(methods), settings);
  VerifiedScene result;
  result.name = scene.name;
  result.methods = std::move(methods);
  result.partial = true;
  return result;
}

void shrink_picture(Description& scene, int pixels) {
  const int largest = std::max(scene.sensor.resolution[0], scene.sensor.resolution[1]);
  if (largest <= pixels) return;
  for (int& side : scene.sensor.resolution) {
    side = std::max(1, static_cast<int>(std::lround(static_cast<double>(side) * pixels / largest)));
  }
}

std::size_t VerifiedScene::comparisons() const {
  std::size_t count = pixels.size();
  for (const VerifyRow& row : rows) count += row.pairs.size();
  return count;
}

std::vector<std::string> VerifiedScene::failures() const {
  std::vector<std::string> sentences;
  const auto label = [&](const std::string& band, const std::string& quantity) {
    return bands.size() > 1 ? fmt::format("{}: {} ({})", name, quantity, band) : fmt::format("{}: {}", name, quantity);
  };
  for (const VerifyRow& row : rows) {
    for (const VerifyPair& pair : row.pairs) {
      const Agreement& a = pair.agreement;
      if (!a.agree) {
        sentences.push_back(fmt::format("{}: {} and {} differ by {:.2f} %, {:.1f} standard errors (limit {:.1f})",
                                        label(row.band, row.quantity), name_of(pair.first), name_of(pair.second),
                                        100 * a.relative, a.z, a.limit));
      } else if (demands_resolution && !a.sharp) {
        sentences.push_back(fmt::format("{}: {} and {} are too weak: only a difference of {:.1f} % would be seen",
                                        label(row.band, row.quantity), name_of(pair.first), name_of(pair.second),
                                        100 * a.detectable));
      }
    }
  }
  for (const VerifyPixels& p : pixels) {
    if (p.agreement.agree) continue;
    sentences.push_back(fmt::format(
        "{}: the pixels of {} and {} differ by {:.2f} of their errors in the root mean square (limit {:.2f})",
        label(p.band, "picture"), name_of(p.first), name_of(p.second), p.agreement.rms_z, p.agreement.high));
  }
  if (comparisons() == 0 && !partial)
    sentences.push_back(name + ": nothing could be compared: fewer than two methods serve the scene");
  return sentences;
}

}  // namespace obscura
