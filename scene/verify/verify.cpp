#include "scene/verify/verify.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

#include "octree/base/error.h"
#include "scene/session/session.h"
#include "sensor/capture/render.h"

namespace obscura {
namespace {

/// Directions of a probe, and paths a side of a rectangle, in one pass.
constexpr int kProbeDirections = 2048;
constexpr int kFluxPaths = 16384;
/// Rays of a pixel for methods on a grid, whose radiance has no noise: they average over the pixel.
constexpr int kGridRays = 4;
/// What methods on a grid call their bias is about one standard deviation; a difference of twice of it is no
/// difference.
constexpr double kGridAllowance = 2;
/// Resolutions of parts of the picture and of single points and rectangles, in units of that of its mean.
constexpr double kCoarserPart = 1.5;
constexpr double kCoarserPoint = 4;

double allowance_of(const Method& method) noexcept { return method.type->cells ? kGridAllowance : 1; }

/// Methods must not share random numbers, nor passes: errors of differences would be wrong.
std::uint64_t seed_of(const VerifySettings& settings, const Method& method, int pass) {
  const std::vector<std::string> words = method_words();
  const auto index = static_cast<std::uint64_t>(std::ranges::find(words, method.type->word) - words.begin());
  return settings.seed * 1000003 + 1000 * (index + 1) + static_cast<std::uint64_t>(pass);
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

void add_means(const Film& film, int band, bool batches, double allowance,
               std::vector<std::optional<Measured>>& values) {
  const auto add = [&](const ImageMean& mean, const std::array<int, 4>& box) {
    Measured value = measured(mean, batches);
    value.bias = allowance * mean_bias(film, band, box);
    values.emplace_back(value);
  };
  add(film.mean(band), {0, 0, film.columns(), film.rows()});
  for (int t = 0; film.tile_count() > 1 && t < film.tile_count(); ++t)
    add(film.mean_of_tile(t, band), film.tile_box(t));
}

/// One run of a method: the numbers of quantities(), and the film.
struct Pass {
  std::vector<std::optional<Measured>> values;
  Film film;
  std::string what;
};

SamplerSettings sampling_of(Session& session, const Method& method) {
  SamplerSettings sampling = session.plan().sampling;
  if (method.type->cells) {
    sampling.max_oversampling = std::min(kGridRays, sampling.max_oversampling);
    sampling.adaptive.reset();
  }
  return sampling;
}

Pass run_pass(Session& session, const Method& method, std::uint64_t seed, const Progress& solve,
              const Progress& render) {
  const Estimator estimator = session.estimator(method, seed, solve);
  const Description& scene = session.scene();
  Pass result{{},
              session.render(session.plan().camera, sampling_of(session, method), method, seed, render).film,
              estimator.what};
  const bool batches = estimator.light && !estimator.light->maps.empty();
  const double allowance = allowance_of(method);
  for (int band = 0; band < result.film.bands() && !render.cancelled(); ++band) {
    add_means(result.film, band, batches, allowance, result.values);
    for (std::size_t p = 0; p < scene.probes.size(); ++p) {
      Measured here = estimator.fluence(band, scene.probes[p].position_m, kProbeDirections, p);
      here.bias *= allowance;
      result.values.emplace_back(here);
    }
    for (std::size_t r = 0; r < scene.flux.size(); ++r) {
      const std::optional<Crossing> power = estimator.crossing(band, r, kFluxPaths);
      result.values.push_back(power ? std::optional(power->forward) : std::nullopt);
      result.values.push_back(power ? std::optional(power->backward) : std::nullopt);
    }
  }
  return result;
}

VerifyPicture picture_of(const Film& film, int band, double allowance) {
  const auto copy = [&](Film::Value value) {
    const std::span<const float> values = film.values(band, value);
    return std::vector<float>(values.begin(), values.end());
  };
  VerifyPicture picture{copy(Film::Value::radiance), copy(Film::Value::error), copy(Film::Value::bias)};
  for (float& bias : picture.bias) bias *= static_cast<float>(allowance);
  return picture;
}

/// Methods with a random error run as often as asked; numbers and pictures are the means.
void run(Session& session, const Method& method, const VerifySettings& settings, const Progress& progress,
         VerifyMethod& result) {
  const int count = method.type->cells ? 1 : settings.passes;
  std::vector<Pass> passes;
  for (int p = 0; p < count && !progress.cancelled(); ++p) {
    const auto part = [&](int half) {
      return progress.part(session.scene().name + ": " + result.name, static_cast<std::uint64_t>(2 * p + half),
                           static_cast<std::uint64_t>(2 * count));
    };
    passes.push_back(run_pass(session, method, seed_of(settings, method, p), part(0), part(1)));
    if (p > 0) passes.front().film.merge(passes.back().film);
  }
  if (progress.cancelled()) return;
  for (std::size_t q = 0; q < passes.front().values.size(); ++q) {
    std::vector<Measured> values;
    for (const Pass& pass : passes) {
      if (pass.values[q]) values.push_back(*pass.values[q]);
    }
    result.values.push_back(values.empty() ? std::nullopt : std::optional(mean_of(values)));
  }
  for (int band = 0; band < passes.front().film.bands(); ++band)
    result.pictures.push_back(picture_of(passes.front().film, band, allowance_of(method)));
  const int rays = sampling_of(session, method).max_oversampling;
  result.what =
      fmt::format("{}{}; {} rays a pixel", count > 1 ? fmt::format("{} times ", count) : "", passes.front().what, rays);
}

void compare(const VerifySettings& settings, VerifiedScene& result) {
  const auto each_pair = [&result](const auto& visit) {
    for (std::size_t a = 0; a < result.methods.size(); ++a) {
      for (std::size_t b = a + 1; b < result.methods.size(); ++b) visit(a, b);
    }
  };
  AgreementRule rule;
  rule.false_alarm = settings.false_alarm / (3.0 * static_cast<double>(result.rows.size()) * settings.scenes);
  for (VerifyRow& row : result.rows) {
    rule.resolution = (settings.resolution > 0 ? settings.resolution : kJudged) * row.coarser;
    each_pair([&](std::size_t a, std::size_t b) {
      const auto &first = row.measured[a], &second = row.measured[b];
      if (first && second) row.pairs.push_back({a, b, agreement(*first, *second, rule)});
    });
  }
  for (std::size_t band = 0; band < result.bands.size(); ++band) {
    each_pair([&](std::size_t a, std::size_t b) {
      const auto &first = result.methods[a].pictures, &second = result.methods[b].pictures;
      if (first.empty() || second.empty()) return;
      result.pixels.push_back({result.bands[band], a, b, pixel_agreement(first[band].view(), second[band].view())});
    });
  }
}

}  // namespace

std::vector<Method> referees(Session& session) {
  std::vector<Method> result;
  const MethodType& chosen = *session.plan().photon;
  for (const std::string& word : method_words()) {
    for (const MethodType* type : methods()) {
      if (type->word != word || (word == chosen.word && type != &chosen)) continue;
      result.push_back(method_of(session.scene(), *type));
      break;
    }
  }
  return result;
}

VerifyMethod run_method(Session& session, const Method& method, const VerifySettings& settings,
                        const Progress& progress) {
  VerifyMethod result;
  result.name = method.type->word;
  const auto refuse = [&result](const std::exception& error) { result = {result.name, error.what(), 0, {}, {}, {}}; };
  const auto begin = std::chrono::steady_clock::now();
  try {
    run(session, method, settings, progress, result);
  } catch (const NumericalError& error) {
    refuse(error);
  } catch (const InputError& error) {
    // The scene has been built: what is wrong is wrong for this method.
    refuse(error);
  } catch (const ResourceError& error) {
    if (!method.type->cells) throw;
    refuse(error);
  }
  if (progress.cancelled()) result.refusal = "stopped";
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return result;
}

VerifiedScene compare_methods(const Description& scene, std::vector<VerifyMethod> methods,
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
  for (VerifyRow& row : result.rows) row.measured.resize(result.methods.size());
  for (std::size_t m = 0; m < result.methods.size(); ++m) {
    const auto& values = result.methods[m].values;
    for (std::size_t q = 0; q < values.size(); ++q) result.rows[q].measured[m] = values[q];
  }
  compare(settings, result);
  return result;
}

VerifiedScene verify_scene(const Description& scene, const VerifySettings& settings, const Progress& progress) {
  Session session(scene, scene.time_s, progress, 0);
  std::vector<VerifyMethod> methods;
  for (const Method& method : referees(session)) methods.push_back(run_method(session, method, settings, progress));
  if (!progress.cancelled()) return compare_methods(scene, std::move(methods), settings);
  VerifiedScene result;
  result.name = scene.name;
  result.methods = std::move(methods);
  result.partial = true;
  return result;
}

const VerifyMethod& VerifiedScene::method(std::string_view word) const {
  return *std::ranges::find(methods, word, &VerifyMethod::name);
}

std::size_t VerifiedScene::comparisons() const {
  std::size_t count = pixels.size();
  for (const VerifyRow& row : rows) count += row.pairs.size();
  return count;
}

std::size_t VerifiedScene::judged() const {
  std::size_t count = pixels.size();
  for (const VerifyRow& row : rows)
    count += static_cast<std::size_t>(
        std::ranges::count_if(row.pairs, [](const VerifyPair& pair) { return pair.agreement.judged(); }));
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
                                        label(row.band, row.quantity), methods[pair.first].name,
                                        methods[pair.second].name, 100 * a.relative, a.z, a.limit));
      } else if (demands_resolution && !a.sharp) {
        sentences.push_back(fmt::format("{}: {} and {} are too weak: only a difference of {:.1f} % would be seen",
                                        label(row.band, row.quantity), methods[pair.first].name,
                                        methods[pair.second].name, 100 * a.detectable));
      }
    }
  }
  for (const VerifyPixels& p : pixels) {
    if (p.agreement.agree) continue;
    sentences.push_back(fmt::format(
        "{}: the pixels of {} and {} differ by {:.2f} of their errors in the root mean square (limit {:.2f})",
        label(p.band, "picture"), methods[p.first].name, methods[p.second].name, p.agreement.rms_z, p.agreement.high));
  }
  // A band of which no number could be judged is not known to be right.
  for (const std::string& band : bands) {
    double least = std::numeric_limits<double>::infinity();
    bool compared = false, any = false;
    for (const VerifyRow& row : rows) {
      if (row.band != band) continue;
      for (const VerifyPair& pair : row.pairs) {
        compared = true;
        any = any || pair.agreement.judged();
        least = std::min(least, pair.agreement.samples_factor);
      }
    }
    if (!compared || any || demands_resolution) continue;
    sentences.push_back(fmt::format(
        "{}: nothing could be judged{}: {}", name, bands.size() > 1 ? " in band " + band : "",
        least < std::numeric_limits<double>::infinity()
            ? fmt::format("it takes {:.2g} times as many samples to see a difference of {:.0f} %", least, 100 * kJudged)
            : "there is no light, or the methods' biases hide any difference"));
  }
  if (comparisons() == 0 && !partial)
    sentences.push_back(name + ": nothing could be compared: fewer than two methods serve the scene");
  return sentences;
}

}  // namespace obscura
