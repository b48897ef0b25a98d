#include "photon/world/check_contents.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "octree/base/error.h"

namespace obscura {
namespace {

/// How far a unit vector's length may be from 1, and an albedo above it, by rounding.
constexpr double kRounding = 1e-6;

bool finite(const Vec3d& v) noexcept { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }

class Checker {
 public:
  explicit Checker(const WorldContents& contents) : contents_(contents) {
    for (const Band& band : contents.bands) intervals_ += band.intervals().size();
  }

  std::vector<Problem> run() {
    bands();
    for (std::size_t c = 0; c < contents_.clouds.size(); ++c) cloud(contents_.clouds[c], c);
    for (std::size_t m = 0; m < contents_.materials.size(); ++m)
      material(contents_.materials[m], fmt::format("material {}", m));
    for (std::size_t o = 0; o < contents_.objects.size(); ++o) object(contents_.objects[o], o);
    for (std::size_t s = 0; s < contents_.sources.size(); ++s)
      sphere(contents_.sources[s], fmt::format("source {}", s));
    for (std::size_t s = 0; s < contents_.particles.size(); ++s)
      sphere(contents_.particles[s], fmt::format("particle {}", s));
    for (std::size_t b = 0; b < contents_.beams.size(); ++b) beam(contents_.beams[b], fmt::format("beam {}", b));
    if (contents_.sun) sun(*contents_.sun, "sun");
    if (contents_.moon) sun(*contents_.moon, "moon");
    if (!contents_.sky.empty()) values(contents_.sky, "sky", "radiance", kInfinity);
    if (contents_.atmosphere) {
      values(contents_.atmosphere->extinction, "atmosphere", "extinction", kInfinity);
      values(contents_.atmosphere->radiance, "atmosphere", "radiance", kInfinity);
    }
    return std::move(problems_);
  }

 private:
  void problem(std::string where, std::string what, std::string hint) {
    problems_.push_back({std::move(where), std::move(what), std::move(hint)});
  }

  /// One value from 0 to `most` for each interval.
  void values(const std::vector<double>& list, const std::string& where, const char* name, double most) {
    length(list.size(), where, name);
    for (std::size_t i = 0; i < list.size(); ++i) {
      if (list[i] >= 0 && list[i] <= most && std::isfinite(list[i])) continue;
      return problem(where, fmt::format("{} {} in interval {}", name, list[i], i),
                     most < kInfinity ? "give a number from 0 to 1" : "give a finite number, at least 0");
    }
  }
  void values(const std::vector<std::optional<double>>& list, const std::string& where, const char* name) {
    if (list.empty()) return;
    length(list.size(), where, name);
    for (std::size_t i = 0; i < list.size(); ++i) {
      if (!list[i] || (*list[i] >= 0 && std::isfinite(*list[i]))) continue;
      return problem(where, fmt::format("{} {} in interval {}", name, *list[i], i), "give a finite number, at least 0");
    }
  }
  void length(std::size_t size, const std::string& where, const char* name) {
    if (size != intervals_)
      problem(where, fmt::format("{} values of {} for {} intervals", size, name, intervals_),
              "give one value for each interval of each band, in their order");
  }
  void share(double value, const std::string& where, const char* name) {
    if (!(value >= 0 && value <= 1)) problem(where, fmt::format("{} {}", name, value), "give a number from 0 to 1");
  }
  void at_least_0(double value, const std::string& where, const char* name) {
    if (!(value >= 0 && std::isfinite(value)))
      problem(where, fmt::format("{} {}", name, value), "give a finite number, at least 0");
  }
  void unit(const Vec3d& direction, const std::string& where, const char* name) {
    if (!(std::abs(direction.length() - 1) < kRounding))
      problem(where, fmt::format("{} has the length {}", name, direction.length()), "give a unit vector");
  }
  void place(const Affine& placed, const std::string& where) {
    double sum = 0;
    for (int i = 0; i < 4; ++i) {
      for (int j = 0; j < 3; ++j) sum += placed[i][j];
    }
    if (!std::isfinite(sum) || !(std::abs(linear_determinant(placed)) > 0))
      problem(where, "its placement is not finite or has no volume",
              "give a rotation, a translation and a scale above 0");
  }

  void bands() {
    const bool anything = !contents_.clouds.empty() || !contents_.objects.empty() || !contents_.sources.empty() ||
                          !contents_.particles.empty() || !contents_.beams.empty() || !contents_.sky.empty() ||
                          contents_.sun || contents_.moon || contents_.atmosphere;
    if (contents_.bands.empty() && anything) problem("bands", "there are none", "give one at least");
  }

  void cloud(const Cloud& cloud, std::size_t number) {
    const std::string where =
        cloud.name.empty() ? fmt::format("cloud {}", number) : fmt::format("cloud \"{}\"", cloud.name);
    place(cloud.local_to_world, where);
    for (const double period : cloud.period_m) at_least_0(period, where, "period_m");
    values(cloud.source, where, "source");
    if (!cloud.emission.empty()) values(cloud.emission, where, "emission", kInfinity);
    if (!cloud.emission.empty() && cloud.media.empty())
      problem(where, "an emission per unit of density, and no medium", "give a medium, whose density it belongs to");
    if (!cloud.octree) return problem(where, "it has no octree", "give one, if need be an empty one");
    const int channels = cloud.octree->channel_count();
    const auto channel = [&](int c, const std::string& of, const char* name) {
      if (c >= 0 && c < channels) return true;
      problem(of, fmt::format("{} channel {} of {}", name, c, channels), "channels are numbered from 0");
      return false;
    };
    for (std::size_t m = 0; m < cloud.media.size(); ++m) {
      const Medium& medium = cloud.media[m];
      const std::string here = fmt::format("{}, medium {}", where, m);
      values(medium.extinction, here, "extinction", kInfinity);
      values(medium.albedo, here, "albedo", 1 + kRounding);
      if (!channel(medium.channel, here, "density")) continue;
      const auto bounds = cloud.octree->bounds(medium.channel);
      // Bounds are rounded outward.
      if (!std::isfinite(bounds.max) || !std::isfinite(bounds.min) || bounds.min < -kRounding * std::abs(bounds.max))
        problem(here, fmt::format("its density has voxels from {} to {}", bounds.min, bounds.max),
                "give finite densities, at least 0");
    }
    const Temperature& t = cloud.temperature;
    if (t.channel >= 0) channel(t.channel, where, "temperature");
    if (!std::isfinite(t.scale) || !std::isfinite(t.offset_K))
      problem(where, fmt::format("temperature {} * value + {} K", t.scale, t.offset_K), "give finite numbers");
    at_least_0(t.constant_K, where, "constant_K");
  }

  void material(const Material& material, const std::string& where) {
    values(material.emissivity, where, "emissivity", 1);
    share(material.specular, where, "specular");
    share(material.permeable, where, "permeable");
    at_least_0(material.roughness, where, "roughness");
    if (material.angle_deg.size() != material.angle_factor.size())
      problem(where, fmt::format("{} angles and {} factors", material.angle_deg.size(), material.angle_factor.size()),
              "give one factor for each angle");
    const bool increasing =
        std::ranges::adjacent_find(material.angle_deg, std::greater_equal<>()) == material.angle_deg.end();
    if (!material.angle_deg.empty() &&
        !(increasing && material.angle_deg.front() >= 0 && material.angle_deg.back() <= 90))
      problem(where, "its angles do not increase from 0 to 90 degrees", "give them in order");
    for (const double factor : material.angle_factor) at_least_0(factor, where, "angle_factor");
  }

  void object(const Object& object, std::size_t number) {
    const std::string where =
        object.name.empty() ? fmt::format("object {}", number) : fmt::format("object \"{}\"", object.name);
    place(object.local_to_world, where);
    values(object.radiance, where, "radiance");
    if (object.materials.empty()) problem(where, "it has no material", "name one at least");
    for (const int m : object.materials) {
      if (m < 0 || static_cast<std::size_t>(m) >= contents_.materials.size())
        problem(where, fmt::format("material {} of {}", m, contents_.materials.size()),
                "materials are numbered from 0");
    }
    if (object.K.size() < object.materials.size())
      problem(where, fmt::format("{} temperatures for {} materials", object.K.size(), object.materials.size()),
              "give one for each material, 0 for those that do not emit");
    for (const double K : object.K) at_least_0(K, where, "temperature");
    if (object.mesh) return mesh(*object.mesh, object.materials.size(), where);
    if (!(object.radius > 0 && std::isfinite(object.radius)))
      problem(where, fmt::format("it has no mesh, and the radius {}", object.radius),
              "give a mesh, or a radius above 0");
  }

  void mesh(const Mesh& mesh, std::size_t materials, const std::string& where) {
    const auto bad_vertex = std::ranges::find_if_not(mesh.vertices, finite);
    if (bad_vertex != mesh.vertices.end())
      problem(where, fmt::format("vertex {} is not finite", bad_vertex - mesh.vertices.begin()), "give finite places");
    for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
      const std::uint32_t most = std::ranges::max(mesh.faces[f]);
      if (most < mesh.vertices.size()) continue;
      problem(where, fmt::format("face {} names vertex {} of {}", f, most, mesh.vertices.size()),
              "vertices are numbered from 0");
      break;
    }
    const auto as_many = [&](std::size_t size, std::size_t wanted, const char* what, const char* of) {
      if (size != 0 && size != wanted)
        problem(where, fmt::format("{} {} for {} {}", size, what, wanted, of), "give one for each, or none");
    };
    as_many(mesh.slots.size(), mesh.faces.size(), "slots", "faces");
    as_many(mesh.vertex_K.size(), mesh.vertices.size(), "vertex temperatures", "vertices");
    as_many(mesh.face_K.size(), mesh.faces.size(), "face temperatures", "faces");
    if (!mesh.slots.empty() && std::ranges::max(mesh.slots) >= materials)
      problem(where, fmt::format("slot {} of {} materials", std::ranges::max(mesh.slots), materials),
              "slots are numbered from 0");
    // NaN is the object's temperature.
    for (const std::vector<float>* kelvin : {&mesh.vertex_K, &mesh.face_K}) {
      for (const float K : *kelvin) {
        if (!(K < 0) && !std::isinf(K)) continue;
        problem(where, fmt::format("a temperature of {} K", K), "give kelvin");
        break;
      }
    }
  }

  void sphere(const HotSphere& sphere, const std::string& where) {
    if (!finite(sphere.center)) problem(where, "its center is not finite", "give a finite place");
    at_least_0(sphere.radius, where, "radius");
    values(sphere.radiance, where, "radiance", kInfinity);
  }
  void beam(const Beam& beam, const std::string& where) {
    if (!finite(beam.position)) problem(where, "its position is not finite", "give a finite place");
    unit(beam.direction, where, "direction");
    at_least_0(beam.radius, where, "radius");
    values(beam.power, where, "power", kInfinity);
  }
  void sun(const Sun& sun, const std::string& where) {
    unit(sun.toward, where, "toward");
    if (!(sun.diameter >= 0 && sun.diameter < kPi))
      problem(where, fmt::format("diameter {} radians", sun.diameter), "give an angle from 0 to below pi");
    values(sun.irradiance, where, "irradiance", kInfinity);
  }

  const WorldContents& contents_;
  std::size_t intervals_ = 0;
  std::vector<Problem> problems_;
};

}  // namespace

void check_contents(const WorldContents& contents) {
  std::vector<Problem> problems = Checker(contents).run();
  if (!problems.empty()) throw InputError(std::move(problems));
}

void check_rays(SpectralWorld world, std::span<const Ray> rays, std::size_t histories, std::size_t results) {
  if (world.interval() < 0 || world.interval() >= world->interval_count()) {
    throw InputError("rays", fmt::format("interval {} of {}", world.interval(), world->interval_count()),
                     "intervals are numbered from 0, through all bands");
  }
  if (histories != rays.size() || results != rays.size()) {
    throw InputError("rays", fmt::format("{} rays, {} histories and {} results", rays.size(), histories, results),
                     "give as many of each");
  }
  for (std::size_t r = 0; r < rays.size(); ++r) {
    if (std::abs(rays[r].direction.length2() - 1) < 2 * kRounding && finite(rays[r].origin)) continue;
    throw InputError(
        fmt::format("ray {}", r),
        fmt::format("its direction has the length {}, or its origin is not finite", rays[r].direction.length()),
        "give unit vectors and finite places");
  }
}

}  // namespace obscura
