// Puffs: where they are and how large (release), how eddies displace what they hold (eddies), and
// the sum over puffs at every voxel of the bricks they reach.
#include "octree/source/puffs.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <tuple>

#include "octree/base/error.h"
#include "octree/source/eddies.h"

namespace obscura {
namespace {

constexpr double kAmbientK = 288;
constexpr double kGravity = 9.80665;
constexpr double kSourceSigma = 0.15;  // m, of the hot jet above a pot
constexpr double kSourceSpeed = 2;     // m/s, of the same
constexpr double kEntrainment = 0.35;  // sigma gained per metre of rise (radius 0.6 of it: Briggs 1975)
constexpr double kCutoff = 2.6;        // sigmas
constexpr int kClumps = 5;             // smaller puffs that a puff consists of
constexpr double kClumpSigma = 0.45;   // of the puff's; the rest of the variance is in their places
constexpr std::uint64_t kMaxVoxels = std::uint64_t{1} << 27;
constexpr std::uint32_t kPurpose = 0x70756666;  // this file's random numbers

struct Clump {
  Vec3d centre;
  double amplitude;  // g/m3 at the centre
  double falloff;    // 1 / (2 sigma^2)
  double sigma;
  int source;
};

/// What one source does with time: rise, growth, dilution.
class Plume {
 public:
  Plume(const PuffSource& source, const PuffSettings& settings)
      : source_(&source),
        wind_(settings.wind_m_s),
        turbulence_(settings.turbulence),
        sigma0_(std::max(kSourceSigma, 0.7 * settings.voxel_m)) {
    speed_ = std::max(0.5, wind_.length());
    // Buoyancy flux of the jet, F = g w r^2 (T - Ta) / T with r^2 = 2 sigma^2.
    const double excess = std::max(0.0, (source.K - kAmbientK) / source.K);
    const double flux = kGravity * kSourceSpeed * 2 * kSourceSigma * kSourceSigma * excess;
    rise_ = 1.6 * std::cbrt(flux / speed_);
  }

  /// Briggs' transitional rise of a bent-over plume: 1.6 F^(1/3) x^(2/3) / u at x = u t.
  double rise(double age) const noexcept { return rise_ * std::cbrt(age * age); }
  double sigma(double age) const noexcept {
    const double entrained = kEntrainment * rise(age);
    const double ambient = 0.3 * turbulence_ * speed_ * age + 0.02 * age;
    return std::sqrt(sigma0_ * sigma0_ + entrained * entrained + ambient * ambient);
  }
  Vec3d centre(double age) const noexcept { return source_->position_m + wind_ * age + Vec3d(0, 0, rise(age)); }
  double speed() const noexcept { return speed_; }
  /// Sigma of the smoke that has come as far as a point.
  double width_at(const Vec3d& point) const noexcept { return sigma((point - source_->position_m).length() / speed_); }

  /// Concentration on the axis of a smooth plume, or in the middle of a single puff, at a point's distance.
  double mean_concentration(const Vec3d& point) const noexcept {
    const double width = width_at(point);
    const double puff = source_->mass_g / std::pow(std::sqrt(2 * kPi) * width, 3);
    if (source_->burn_s == 0) return puff;
    return std::min(puff, source_->mass_g / source_->burn_s / (2 * kPi * width * width * speed_));
  }

  /// Concentration of the undiluted smoke at the source, g/m3: excess heat dilutes as mass does.
  double source_concentration() const noexcept {
    const double volume = std::max(source_->burn_s * 2 * kPi * kSourceSigma * kSourceSigma * kSourceSpeed,
                                   std::pow(2 * kPi, 1.5) * std::pow(kSourceSigma, 3));
    return source_->mass_g / volume;
  }

 private:
  const PuffSource* source_;
  Vec3d wind_;
  double turbulence_, sigma0_, speed_, rise_;
};

Vec3d normal3(Stream& random) noexcept {
  // Box-Muller, twice.
  const double r1 = std::sqrt(-2 * std::log(random.uniform())), a1 = 2 * kPi * random.uniform();
  const double r2 = std::sqrt(-2 * std::log(random.uniform())), a2 = 2 * kPi * random.uniform();
  return {r1 * std::cos(a1), r1 * std::sin(a1), r2 * std::cos(a2)};
}

/// The clumps of one source's puffs at settings.age_s.
void release(const Plume& plume, const PuffSource& source, int index, const PuffSettings& settings,
             std::vector<Clump>& clumps) {
  const double oldest = settings.age_s;
  const double youngest = std::max(0.0, settings.age_s - source.burn_s);
  const double released = source.burn_s > 0 ? source.mass_g * std::min(1.0, oldest / source.burn_s) : source.mass_g;
  if (released <= 0) return;

  // Puffs at most half a sigma apart, so that a smooth plume stays smooth; named by their birth, so
  // that a puff is the same one at every age of the cloud.
  std::vector<double> ages;
  if (oldest - youngest <= 0) ages = {oldest};
  double step = 0.5 * plume.sigma(0) / (plume.speed() + kSourceSpeed);
  step = std::max(step, source.burn_s / 20000);
  for (double birth = 0.5 * step; birth < oldest - youngest; birth += step) ages.push_back(oldest - birth);
  if (ages.empty()) ages = {0.5 * (oldest + youngest)};

  std::vector<Clump> all;
  double total = 0;
  for (std::size_t puff = 0; puff < ages.size(); ++puff) {
    Stream random(settings.seed, (std::uint64_t(index) << 32) + puff, kPurpose);
    const double age = ages[puff];
    const double sigma = plume.sigma(age);
    // Old puffs overlap many others: one of several is kept and gets the mass of all.
    const auto stride = static_cast<std::size_t>(std::max(1.0, std::floor(0.3 * sigma / (step * plume.speed()))));
    if (puff % stride != 0) continue;
    for (int k = 0; k < kClumps; ++k) {
      const Vec3d offset = normal3(random) * (std::sqrt(1 - kClumpSigma * kClumpSigma) * sigma);
      const double own = kClumpSigma * sigma * std::exp(0.35 * (2 * random.uniform() - 1));
      const double mass = static_cast<double>(stride) * -std::log(random.uniform());
      total += mass;
      all.push_back({plume.centre(age) + offset, mass / (std::pow(2 * kPi, 1.5) * own * own * own), 1 / (2 * own * own),
                     own, index});
    }
  }
  for (Clump& clump : all) {
    clump.amplitude *= released / total;
    clumps.push_back(clump);
  }
}

void check(const PuffSettings& settings) {
  std::vector<Problem> problems;
  const auto require = [&](bool good, std::string where, double value, const char* hint) {
    if (!good) problems.push_back({std::move(where), fmt::format("is {}", value), hint});
  };
  require(!settings.sources.empty(), "puffs/sources", 0, "give at least one source");
  for (std::size_t i = 0; i < settings.sources.size(); ++i) {
    const PuffSource& source = settings.sources[i];
    const std::string where = fmt::format("puffs/sources/{}", i);
    require(source.mass_g >= 0 && std::isfinite(source.mass_g), where + "/mass_g", source.mass_g, "must be 0 or more");
    require(source.burn_s >= 0 && std::isfinite(source.burn_s), where + "/burn_s", source.burn_s, "must be 0 or more");
    require(source.K > 0 && source.K <= 5000, where + "/K", source.K, "must lie between 0 and 5000");
    require(std::isfinite(source.position_m.length()), where + "/position_m", source.position_m.length(),
            "must be finite");
  }
  require(settings.wind_m_s.length() <= 100, "puffs/wind_m_s", settings.wind_m_s.length(), "at most 100 m/s");
  require(settings.turbulence >= 0 && settings.turbulence <= 1, "puffs/turbulence", settings.turbulence,
          "must lie between 0 and 1");
  require(settings.age_s >= 0 && settings.age_s <= 3600, "puffs/age_s", settings.age_s, "must lie between 0 and 3600");
  require(settings.voxel_m > 0 && std::isfinite(settings.voxel_m), "puffs/voxel_m", settings.voxel_m,
          "must be positive");
  if (!problems.empty()) throw InputError(problems);
}

struct CornerOrder {
  bool operator()(const Vec3i& a, const Vec3i& b) const noexcept {
    return std::tie(a.z, a.y, a.x) < std::tie(b.z, b.y, b.x);
  }
};

/// The state of the computation. The voxels of a brick are written by one thread.
struct Smoke {
  std::vector<Vec3i> bricks;
  std::vector<std::array<float, 512>> density, temperature;
};

}  // namespace

VoxelStream puffs_stream(const PuffSettings& settings) {
  check(settings);
  const double voxel = settings.voxel_m;

  // The clumps of all sources.
  std::vector<Plume> plumes;
  std::vector<Clump> clumps;
  double released = 0;
  bool ground = true;
  for (const PuffSource& source : settings.sources) {
    plumes.emplace_back(source, settings);
    release(plumes.back(), source, static_cast<int>(plumes.size()) - 1, settings, clumps);
    released += source.burn_s > 0 ? source.mass_g * std::min(1.0, settings.age_s / source.burn_s) : source.mass_g;
    ground = ground && source.position_m.z >= 0;
  }

  VoxelStream stream;
  stream.name = "puffs";
  stream.channels = {"density", "temperature"};
  stream.background = {0.0f, static_cast<float>(kAmbientK)};
  stream.index_to_local.setScale(voxel);
  stream.bounds = Box3i(Vec3i(0), Vec3i(0));
  stream.pour = [](const VoxelSink&) {};
  if (clumps.empty() || released == 0) return stream;

  double widest = 0;
  for (const Plume& plume : plumes) widest = std::max(widest, plume.sigma(settings.age_s));
  const detail::Eddies eddies(settings.seed, settings.turbulence, widest, voxel);

  // Clumps by bins of bricks, reaching as far as eddies carry them.
  const double brick_m = 8 * voxel;
  const int bricks_per_bin = std::max(1, static_cast<int>(std::ceil(widest / brick_m)));
  const double bin_m = bricks_per_bin * brick_m;
  std::map<Vec3i, std::vector<std::uint32_t>, CornerOrder> bins;
  std::vector<double> reach(clumps.size());
  for (std::size_t i = 0; i < clumps.size(); ++i) {
    const Clump& clump = clumps[i];
    const Plume& plume = plumes[clump.source];
    reach[i] = kCutoff * clump.sigma + eddies.farthest(plume.width_at(clump.centre));
    Vec3i low, high;
    for (int axis = 0; axis < 3; ++axis) {
      low[axis] = static_cast<int>(std::floor((clump.centre[axis] - reach[i]) / bin_m));
      high[axis] = static_cast<int>(std::floor((clump.centre[axis] + reach[i]) / bin_m));
    }
    if (ground) low.z = std::max(low.z, 0), high.z = std::max(high.z, 0);
    for (int z = low.z; z <= high.z; ++z)
      for (int y = low.y; y <= high.y; ++y)
        for (int x = low.x; x <= high.x; ++x) bins[Vec3i(x, y, z)].push_back(static_cast<std::uint32_t>(i));
  }
  const std::uint64_t voxels = bins.size() * 512ull * bricks_per_bin * bricks_per_bin * bricks_per_bin;
  if (voxels > kMaxVoxels)
    throw InputError("puffs/voxel_m",
                     fmt::format("{} m gives about {:.1f} million voxels of smoke", voxel, 1e-6 * double(voxels)),
                     fmt::format("at most {} million are possible; take {:.2g} m or more", kMaxVoxels >> 20,
                                 voxel * std::cbrt(double(voxels) / double(kMaxVoxels)) * 1.05));

  auto smoke = std::make_shared<Smoke>();
  std::vector<const std::vector<std::uint32_t>*> candidates;
  for (const auto& [bin, list] : bins)
    for (int z = 0; z < bricks_per_bin; ++z)
      for (int y = 0; y < bricks_per_bin; ++y)
        for (int x = 0; x < bricks_per_bin; ++x) {
          smoke->bricks.push_back((bin * bricks_per_bin + Vec3i(x, y, z)) * 8);
          candidates.push_back(&list);
        }
  smoke->density.resize(smoke->bricks.size());
  smoke->temperature.resize(smoke->bricks.size());
  std::vector<double> sums(smoke->bricks.size(), 0.0);

  double coldest_K = 0, hottest_K = 0;  // above the air; smoke that mixes is never outside its sources' range
  for (const PuffSource& source : settings.sources) {
    coldest_K = std::min(coldest_K, source.K - kAmbientK);
    hottest_K = std::max(hottest_K, source.K - kAmbientK);
  }
  std::vector<double> undiluted;
  for (const Plume& plume : plumes) undiluted.push_back(plume.source_concentration());

  const double sharpness = 0.5 * std::min(1.0, settings.turbulence / 0.3);
  const Vec3d drift = settings.wind_m_s * settings.age_s;

  // Mass and excess heat at every voxel: where did the eddies bring this air from, and what was there?
  tbb::parallel_for(std::size_t{0}, smoke->bricks.size(), [&](std::size_t b) {
    const Vec3d low = Vec3d(smoke->bricks[b]) * voxel;
    const Vec3d high = low + Vec3d(brick_m);
    std::vector<std::vector<const Clump*>> near(plumes.size());
    for (const std::uint32_t i : *candidates[b]) {
      double distance2 = 0;
      for (int axis = 0; axis < 3; ++axis) {
        const double c = clumps[i].centre[axis];
        const double d = c < low[axis] ? low[axis] - c : c > high[axis] ? c - high[axis] : 0;
        distance2 += d * d;
      }
      if (distance2 < reach[i] * reach[i]) near[clumps[i].source].push_back(&clumps[i]);
    }
    if (std::all_of(near.begin(), near.end(), [](const auto& list) { return list.empty(); })) return;
    const auto fill = [&](int v) {
      const Vec3d x = low + (Vec3d(v & 7, (v >> 3) & 7, v >> 6) + Vec3d(0.5)) * voxel;
      double density = 0, excess_K = 0;
      // The eddies are as large as the plume of the nearest source lets them be, and move with the wind.
      double width = kInfinity;
      for (const Plume& plume : plumes) width = std::min(width, plume.width_at(x));
      Vec3d from = eddies.origin_of(x - drift, width) + drift;
      if (ground) from.z = std::abs(from.z);
      for (std::size_t s = 0; s < plumes.size(); ++s) {
        double concentration = 0;
        for (const Clump* clump : near[s]) {
          const Vec3d d = from - clump->centre;
          const double cut = kCutoff * kCutoff * 0.5;
          const double exponent = d.length2() * clump->falloff;
          if (exponent < cut) concentration += clump->amplitude * std::exp(-exponent);
          if (!ground) continue;
          const double mirrored = (d.length2() + 4 * from.z * clump->centre.z) * clump->falloff;
          if (mirrored < cut) concentration += clump->amplitude * std::exp(-mirrored);
        }
        if (concentration == 0) continue;
        // Engulfed air stays clean: what is far below the plume's mean is thinned out, which leaves
        // edges and voids; the mass is made good below.
        const double edge = sharpness * plumes[s].mean_concentration(x);
        concentration *= concentration * concentration / (concentration * concentration + edge * edge);
        if (concentration < 1e-3 * edge) continue;
        density += concentration;
        excess_K += (settings.sources[s].K - kAmbientK) * std::min(1.0, concentration / undiluted[s]);
      }
      smoke->density[b][v] = static_cast<float>(density);
      smoke->temperature[b][v] = static_cast<float>(kAmbientK + std::clamp(excess_K, coldest_K, hottest_K));
      return density;
    };
    // A sample of one voxel in eight decides whether there is any smoke in the brick.
    double sampled = 0;
    for (int v = 0; v < 512; ++v)
      if ((v & 0b001001001) == 0) sampled += fill(v);
    if (sampled == 0) return;
    for (int v = 0; v < 512; ++v) sums[b] += fill(v);
  });

  // The mass that was released, to rounding: cut-off tails and stretching are made good by one factor.
  double sum = 0;
  for (const double part : sums) sum += part;
  if (!(sum > 0))
    throw InputError("puffs/voxel_m", fmt::format("{} m is too coarse for this smoke", voxel), "take a smaller voxel");
  const auto factor = static_cast<float>(released / (sum * voxel * voxel * voxel));
  for (std::size_t b = 0; b < smoke->bricks.size(); ++b) {
    if (sums[b] == 0) continue;
    for (float& value : smoke->density[b]) value *= factor;
    stream.bounds.extendBy(smoke->bricks[b]);
    stream.bounds.extendBy(smoke->bricks[b] + Vec3i(8));
  }

  stream.pour = [smoke](const VoxelSink& sink) {
    tbb::parallel_for(std::size_t{0}, smoke->bricks.size(), [&](std::size_t b) {
      const auto& density = smoke->density[b];
      if (std::none_of(density.begin(), density.end(), [](float d) { return d > 0; })) return;
      const float* channels[] = {density.data(), smoke->temperature[b].data()};
      sink.brick(smoke->bricks[b], channels);
    });
  };
  return stream;
}

}  // namespace obscura
