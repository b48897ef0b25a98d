// The keys of the scene file, each written once: reader and schema are both visitors of these functions.
//   v.required / v.optional(key, member, limits, what it is): the member's value is the default
//   v.later(key, default, what): not available yet, refused unless it holds its default
//   v.form(key[, word]): the keys that follow belong to the form that has this key (with this word) ...
//   v.every_form(): ... until here; v.sets(member, value): what the form means
//   v.exactly_one(keys): one of these keys has to be given
#pragma once

#include <cmath>

#include "octree/io/volume_formats.h"
#include "scene/file/scene_json.h"
#include "scene/file/scene_limits.h"

namespace obscura::detail {

template <class V>
void keys(V& v, PlaceDescription& p) {
  v.optional("translate_m", p.translate_m, any(), "shift, applied last");
  v.optional("rotate_deg", p.rotate_deg, any(), "rotation about x, then y, then z, right-handed");
  v.optional("scale", p.scale, above(0), "size factor, applied first; density is unchanged");
}

template <class V>
void keys(V& v, BandDescription& b) {
  v.optional("name", b.name, any(), "name of the band's channels; default band1, band2, ...");
  v.optional("um", b.um, numbers(2, above(0)), "lower and upper wavelength; without it the band is grey");
  v.optional("samples", b.samples, between(1, 10000), "spectral intervals in the band");
  v.optional("response", b.response, at_least(0), "spectral response, not normalised");
}

template <class V>
void keys(V& v, GridDescription& g) {
  v.form("file");
  v.sets(g.kind, GridKind::file);
  v.required("file", g.file, files(volume_extensions()), "volume: " + volume_format_list());
  v.form("shape", "sphere");
  v.sets(g.kind, GridKind::sphere);
  v.required("radius_m", g.radius_m, above(0), "radius");
  v.required("voxel_m", g.voxel_m, above(0), "edge of a voxel");
  v.form("shape", "box");
  v.sets(g.kind, GridKind::box);
  v.required("size_m", g.size_m, above(0), "edges, centred on the origin");
  v.required("voxel_m", g.voxel_m, above(0), "edge of a voxel");
  v.form("shape", "gaussian");
  v.sets(g.kind, GridKind::gaussian);
  v.required("sigma_m", g.sigma_m, above(0), "standard deviation");
  v.required("size_m", g.size_m, above(0), "edges of the grid, centred on the origin");
  v.required("voxel_m", g.voxel_m, above(0), "edge of a voxel");
}

template <class V>
void keys(V& v, PuffSource& s) {
  v.required("position_m", s.position_m, any(), "where it burns");
  v.required("mass_g", s.mass_g, at_least(0), "smoke that it gives in all");
  v.optional("burn_s", s.burn_s, at_least(0), "how long it burns; 0: all at once");
  v.optional("K", s.K, above_to(0, 5000), "temperature of the fresh smoke");
}

template <class V>
void keys(V& v, PuffSettings& p) {
  v.required("sources", p.sources, items(1), "pyrotechnic sources");
  v.optional("wind_m_s", p.wind_m_s, any(), "wind");
  v.optional("turbulence", p.turbulence, between(0, 1), "how much the puffs are broken up");
  v.optional("age_s", p.age_s, between(0, 3600), "time since the sources were lit");
  v.optional("voxel_m", p.voxel_m, above(0), "edge of a voxel");
  v.optional("seed", p.seed, at_least(0), "seed of the noise");
}

enum class PhaseKind { isotropic, rayleigh, henyey_greenstein, double_henyey_greenstein, table };
struct PhaseDescription {
  PhaseKind kind = PhaseKind::isotropic;
  double g = 0;                          // henyey_greenstein
  double g1 = 0, g2 = 0, weight = 1;     // double_henyey_greenstein
  std::vector<double> angle_deg, value;  // table, or
  std::filesystem::path file;
};
template <class V>
void keys(V& v, PhaseDescription& p) {
  v.default_form("type", "isotropic");
  v.form("type", "rayleigh");
  v.sets(p.kind, PhaseKind::rayleigh);
  v.form("type", "henyey_greenstein");
  v.sets(p.kind, PhaseKind::henyey_greenstein);
  v.required("g", p.g, between(-1, 1), "mean cosine");
  v.form("type", "double_henyey_greenstein");
  v.sets(p.kind, PhaseKind::double_henyey_greenstein);
  v.required("g1", p.g1, between(-1, 1), "mean cosine of the first lobe");
  v.required("g2", p.g2, between(-1, 1), "mean cosine of the second lobe");
  v.required("weight", p.weight, between(0, 1), "share of the first lobe");
  v.form("type", "table");
  v.sets(p.kind, PhaseKind::table);
  v.exactly_one({"angle_deg", "file"});
  v.optional("angle_deg", p.angle_deg, numbers(2, between(0, 180)), "scattering angles from 0 (forward) to 180");
  v.optional("value", p.value, numbers(2, at_least(0), false), "phase function there, in any unit");
  v.optional("file", p.file, any(), "table with the header angle_deg,value");
}

template <class V>
void keys(V& v, MediumDescription& m) {
  v.optional("density", m.density, any(), "grid of the amount, e.g. g/m3");
  const bool coefficients = v.later("coefficients", Json::object(), "per band, grids of coefficients");
  const bool mie = v.later("mie", Json::object(), "optics of spheres");
  v.later("radius", Json::object(), "grid of the droplets' radius");
  if (coefficients || mie) {
    v.optional("extinction", m.extinction, at_least(0), "1/m per unit of density");
  } else {
    v.required("extinction", m.extinction, at_least(0), "1/m per unit of density");
  }
  v.optional("albedo", m.albedo, between(0, 1), "scattered share of the extinction");
  PhaseDescription phase;
  v.optional("phase", phase, any(), "where scattered light goes");
  v.phase_function(phase, m.phase);
}

template <class V>
void keys(V& v, TemperatureDescription& t) {
  v.form("grid");
  v.required("grid", t.grid, any(), "grid of the temperature");
  v.optional("scale", t.scale, any(), "factor that gives kelvin");
  v.optional("offset_K", t.offset_K, any(), "added after the factor");
  v.form("K");
  v.required("K", t.K, at_least(0), "temperature of the whole cloud");
}

/// ".vdb and .nvdb": volumes that do not say where they end.
inline std::string formats_without_size() {
  std::string list;
  for (const VolumeFormat& format : volume_formats()) {
    if (!format.tells_lattice_size) list += (list.empty() ? "" : " and ") + format.extensions.front();
  }
  return list;
}

template <class V>
void keys(V& v, CloudDescription& c) {
  v.optional("name", c.name, any(), "for messages and the report; default cloud1, cloud2, ...");
  v.exactly_one({"grid", "frames", "puffs"});
  v.optional("grid", c.grid, any(), "a volume from a file, or a shape");
  v.later("frames", Json::object(), "a cloud that changes");
  v.optional("puffs", c.puffs, any(), "a generated smoke cloud");
  v.required("media", c.media, items(1), "what the grids do to light; several add up");
  v.optional("temperature", c.temperature, any(), "absent: the cloud does not emit");
  v.optional("source", c.source, at_least(0), "in place of Planck: emission = absorption * source");
  v.optional("emission", c.emission, at_least(0), "W/m3/sr per unit of density, added as it is");
  v.optional("place", c.place, any(), "where the cloud stands");
  v.later("trajectory", Json::array(), "poses over time");
  v.later("carried_by", nullptr, "object that carries the cloud");
  std::vector<Axis> axes;
  std::vector<double> periods;
  v.optional("periodic", axes, any(), "axes along which the cloud repeats for ever");
  v.optional("period_m", periods, numbers(1, above(0), false),
             "one period for each periodic axis; required for " + formats_without_size());
  v.periods(axes, periods, c);
}

template <class V>
void keys(V& v, GroupDescription& g) {
  v.optional("material", g.material, any(), "name of a material; default the object's");
  v.optional("K", g.K, at_least(0), "temperature; default the object's");
}

struct SurfaceTemperatureDescription {
  std::filesystem::path file;
};
template <class V>
void keys(V& v, SurfaceTemperatureDescription& t) {
  v.required("file", t.file, any(),
             "table with the header face,K or vertex,K; numbers from 0 in the mesh file's order, those left out "
             "have the object's K");
}

template <class V>
void keys(V& v, ObjectDescription& o) {
  v.form("mesh");
  v.sets(o.kind, SurfaceKind::mesh);
  v.required("mesh", o.mesh, files({".obj", ".ply", ".stl", ".gltf", ".glb", ".asc", ".asc.gz"}),
             "triangles: Wavefront, Stanford, STL or glTF; or terrain: an ESRI ASCII grid");
  v.optional("groups", o.groups, any(), "material and temperature by a group's or a material's name in the file");
  std::optional<SurfaceTemperatureDescription> temperature;
  v.optional("temperature", temperature, any(), "kelvin per face or vertex");
  if (temperature) o.temperature = temperature->file;
  v.form("shape", "plane");
  v.sets(o.kind, SurfaceKind::plane);
  v.required("size_m", o.plane_m, above(0), "sides, in z = 0 and centred on the origin; faces up");
  v.form("shape", "box");
  v.sets(o.kind, SurfaceKind::box);
  v.required("size_m", o.box_m, above(0), "edges, centred on the origin; faces outward");
  v.form("shape", "sphere");
  v.sets(o.kind, SurfaceKind::sphere);
  v.required("radius_m", o.radius_m, above(0), "radius, about the origin; faces outward");
  v.every_form();
  v.optional("name", o.name, any(), "for messages and the report; default object1, object2, ...");
  v.optional("material", o.material, any(), "name of a material; absent: emissivity 1");
  v.optional("K", o.K, at_least(0), "temperature; absent: emits nothing; not in a grey band");
  v.optional("radiance", o.radiance, at_least(0), "in place of K, times emissivity");
  v.optional("double_sided", o.double_sided, any(),
             "false: the back emits nothing and absorbs everything; true: both sides emit and reflect");
  v.optional("place", o.place, any(), "where the object stands");
  v.later("trajectory", Json::array(), "poses over time");
  v.later("carried_by", nullptr, "object that carries this one");
}

struct AngleFactorDescription {
  std::vector<double> angle_deg, factor;
};
template <class V>
void keys(V& v, AngleFactorDescription& a) {
  v.required("angle_deg", a.angle_deg, numbers(1, between(0, 90)), "angles from the normal");
  v.required("factor", a.factor, numbers(1, at_least(0), false), "of the emissivity there, linear in between");
}

template <class V>
void keys(V& v, MaterialDescription& m) {
  v.optional("emissivity", m.emissivity, between(0, 1), "reflectance is 1 - emissivity");
  std::optional<AngleFactorDescription> by_angle;
  v.optional("emissivity_by_angle", by_angle, any(), "the emissivity's change with angle; the product is cut at 1");
  if (by_angle) v.angle_factor(by_angle->angle_deg, by_angle->factor, m);
  v.optional("specular", m.specular, between(0, 1), "share of the reflectance that is mirror-like");
  v.optional("roughness", m.roughness, at_least(0),
             "standard deviation of a mirror's direction cosines; 0: a perfect mirror");
  v.optional("permeable", m.permeable, between(0, 1), "share of the light that passes straight through, as by a net");
}

template <class V>
void keys(V& v, SourceDescription& s) {
  v.optional("name", s.name, any(), "for messages");
  v.required("position_m", s.position_m, any(), "centre");
  v.required("radius_m", s.radius_m, above(0), "radius");
  v.optional("K", s.K, at_least(0), "temperature; not in a grey band");
  v.optional("radiance", s.radiance, at_least(0), "in place of K");
}

template <class V>
void keys(V& v, SkyDescription& s) {
  v.optional("radiance", s.radiance, at_least(0), "radiance over the full sphere");
  if (v.later("elevation_deg", nullptr, "sky by elevation")) {
    v.skip("K");  // a list then
  } else {
    v.optional("K", s.K, at_least(0), "temperature of a black sky; not in a grey band");
  }
  v.later("file", nullptr, "sky from an image");
}

/// Unit vector: x is east, y is north.
inline Vec3d toward_sky(double zenith_deg, double azimuth_deg) noexcept {
  const double z = zenith_deg * kPi / 180, a = azimuth_deg * kPi / 180;
  return {std::sin(z) * std::sin(a), std::sin(z) * std::cos(a), std::cos(z)};
}
template <class V>
void keys(V& v, SunDescription& s) {
  bool angles = false;
  double zenith_deg = 0, azimuth_deg = 0;
  v.form("toward");
  v.required("toward", s.toward, any(), "direction from the scene to the sun");
  v.form("zenith_deg");
  v.sets(angles, true);
  v.required("zenith_deg", zenith_deg, between(0, 180), "angle between the sun and straight up");
  v.optional("azimuth_deg", azimuth_deg, between(-360, 360), "from north (y), clockwise");
  v.every_form();
  if (angles) s.toward = toward_sky(zenith_deg, azimuth_deg);
  v.optional("irradiance", s.irradiance, at_least(0), "normal to the beam");
  v.optional("diameter_deg", s.diameter_deg, from_below(0, 180), "apparent diameter");
}

template <class V>
void keys(V& v, AtmosphereDescription& a) {
  v.optional("extinction_per_m", a.extinction_per_m, at_least(0), "extinction of the air, which absorbs");
  v.optional("K", a.K, at_least(0), "temperature of the air, default 288; not in a grey band");
  v.optional("radiance", a.radiance, at_least(0), "in place of K: radiance of endless air");
}

struct ParticlesDescription {
  std::filesystem::path file;
};
template <class V>
void keys(V& v, ParticlesDescription& p) {
  v.required("file", p.file, any(), "table with the header s,x_m,y_m,z_m,radius_m,K");
}

struct EnvironmentDescription {
  std::optional<SkyDescription> sky;
  std::optional<SunDescription> sun, moon;
  std::optional<AtmosphereDescription> atmosphere;
};
template <class V>
void keys(V& v, EnvironmentDescription& e) {
  v.optional("sky", e.sky, any(), "light from everywhere");
  v.optional("sun", e.sun, any(), "a distant disc of light");
  v.optional("moon", e.moon, any(), "a second distant disc of light");
  v.optional("atmosphere", e.atmosphere, any(), "clear air between the scene's elements");
}

template <class V>
void keys(V& v, AntialiasingDescription& a) {
  v.optional("polygons", a.polygons, between(0, 1e9),
             "refine where the spot holds at least this many different polygons; 0: everywhere");
  v.optional("polygons_strict", a.polygons_strict, between(0, 1e9), "the same, counting all polygons");
  v.optional("materials", a.materials, between(0, 1e9),
             "refine where the spot holds at least this many materials; 0: everywhere");
  v.optional("normal_deg", a.normal_deg, between(0, 360), "refine where normals differ by more");
  v.optional("depth", a.depth, at_least(0), "refine where the depth varies by more, relative");
  v.optional("temperature_K", a.temperature_K, at_least(0), "refine where the temperature varies by more");
  v.optional("emissivity", a.emissivity, at_least(0), "refine where the emissivity varies by more");
  v.optional("shadow", a.shadow, at_least(0), "refine where the sunlit share varies by more");
  v.optional("transmission", a.transmission, at_least(0), "refine where the clouds' transmission varies by more");
  v.optional("radiance", a.radiance, at_least(0),
             "refine where the radiance varies by more, relative, beyond its noise");
  v.optional("error", a.error, above(0), "more rays until the pixel's relative standard error is below; null: off");
}

template <class V>
void keys(V& v, DetectorBand& b) {
  v.optional("psf_sigma_px", b.psf_sigma_px, between(0, 1000), "the band's own; replaces psf_file too");
  v.optional("nedt_K", b.nedt_K, between(0, 1e4), "the band's own; replaces ner too");
  v.optional("ner", b.ner, between(0, 1e30), "the band's own; replaces nedt_K too");
  v.optional("gain", b.gain, above_to(0, 1e30), "the band's own");
  v.optional("offset", b.offset, between(-1e30, 1e30), "the band's own");
  v.optional("range", b.range, numbers(2, between(-1e30, 1e30)), "the band's own");
}

template <class V>
void keys(V& v, DetectorSettings& d) {
  v.optional("psf_sigma_px", d.psf_sigma_px, between(0, 1000),
             "standard deviation of a gaussian point spread, in pixels");
  std::filesystem::path psf;
  v.optional("psf_file", psf, any(), "picture of a point, in its place: one channel, odd sides");
  v.point_spread(psf, d);
  v.optional("nedt_K", d.nedt_K, between(0, 1e4), "noise: equivalent temperature difference; not in a grey band");
  v.optional("nedt_at_K", d.nedt_at_K, above_to(0, 1e4), "the scene's temperature where nedt_K holds");
  v.optional("ner", d.ner, between(0, 1e30), "in place of nedt_K: noise-equivalent radiance of the band");
  v.optional("integration_s", d.integration_s, above_to(0, 1e9),
             "integration time: the noise falls with its root from the reference's");
  v.optional("reference_integration_s", d.reference_integration_s, above_to(0, 1e9),
             "integration time at which the noise is stated");
  v.optional("dead_share", d.dead_share, between(0, 1), "share of pixels without response");
  v.optional("gain_nonuniformity", d.gain_nonuniformity, between(0, 1),
             "standard deviation of the pixels' gain, relative");
  v.optional("offset_nonuniformity", d.offset_nonuniformity, between(0, 1e30),
             "standard deviation of the pixels' offset, a radiance");
  v.optional("gain", d.gain, above_to(0, 1e30), "signal = gain * radiance + offset");
  v.optional("offset", d.offset, between(-1e30, 1e30), "signal = gain * radiance + offset");
  v.optional("bits", d.bits, between(0, 16), "of the counts; 0: none");
  v.optional("range", d.range, numbers(2, between(-1e30, 1e30)), "signals of the least and the greatest count");
  v.optional("bands", d.bands, any(), "by a band's name, what it has in place of these");
  v.optional("seed", d.seed, at_least(0), "of dead pixels and non-uniformity; absent: the render's");
}

template <class V>
void keys(V& v, SensorDescription& s) {
  v.required("position_m", s.position_m, any(), "where the sensor is");
  v.required("look_at_m", s.look_at_m, any(), "the point in the image's centre");
  v.optional("up", s.up, any(), "upwards in the image");
  v.optional("projection", s.projection, any(), "kind of camera");
  v.optional("fov_deg", s.fov_deg, above_to(0, 360),
             "perspective: full horizontal angle, below 180; fisheye: across the shorter side");
  v.optional("width_m", s.width_m, above(0), "orthographic: width of the picture; required there");
  v.optional("resolution", s.resolution, between(1, 65536), "pixels across and down");
  v.optional("max_oversampling", s.max_oversampling, between(1, 65536), "rays per pixel at most");
  v.optional("antialiasing", s.antialiasing, any(), "where to send more rays");
  v.optional("specular_depth", s.specular_depth, between(0, 1e9), "mirror reflections at most");
  v.optional("scattering_depth", s.scattering_depth, between(0, 1e9), "scatterings at most; null: no limit");
  v.optional("detector", s.detector, any(), "what the detector does to the radiance");
}

template <class V>
void keys(V& v, ProbeDescription& p) {
  v.optional("name", p.name, any(), "for the report; default probe1, probe2, ...");
  v.required("position_m", p.position_m, any(), "where the fluence is wanted");
}

template <class V>
void keys(V& v, FluxDescription& f) {
  v.optional("name", f.name, any(), "for the report; default flux1, flux2, ...");
  v.required("center_m", f.center_m, any(), "centre of the rectangle");
  v.required("normal", f.normal, any(), "forward is along it");
  v.required("size_m", f.size_m, above(0), "edges of the rectangle");
}

template <class V>
void keys(V& v, BeamDescription& b) {
  v.required("position_m", b.position_m, any(), "where the light starts");
  v.required("toward", b.toward, any(), "where the light goes");
  v.optional("radius_m", b.radius_m, at_least(0), "radius of the beam");
  v.optional("power", b.power, at_least(0), "power of the beam");
}

template <class V>
void keys(V& v, RenderDescription& r) {
  v.optional("method", r.method, any(), "how multiple scattering is found");
  v.optional("photons", r.photons, between(0, 4294967295.0), "photons emitted, per band");
  v.optional("nearest", r.nearest, between(1, 100000), "photons of a density estimate");
  v.optional("kernel", r.kernel, any(), "weight over the distance in a density estimate");
  v.optional("photon_power_min", r.photon_power_min, at_least(0), "photons below this are not stored");
  v.optional("directions", r.directions, any(), "how photons leave their sources");
  v.optional("final_gather", r.final_gather, between(0, 1), "bounces of final gather; null: the plan decides");
  v.optional("samples", r.samples, between(1, 1e9), "paths per pixel of final gather and method path");
  v.optional("octree_tolerance", r.octree_tolerance, from_below(0, 1), "error of a ray's transmission");
  v.optional("target_error", r.target_error, inside(0, 1), "image error to reach; photons and samples are then chosen");
  v.optional("time_limit_s", r.time_limit_s, above(0), "for the whole run; photons and samples are then chosen");
  v.later("memory_MiB", nullptr, "memory to stay below");
  v.optional("seed", r.seed, at_least(0), "seed of all random numbers");
  v.optional("effects", r.effects, names(effect_names()),
             "effects to force on or off, e.g. {\"atmosphere\": true}; what is absent stays off");
}

template <class V>
void keys(V& v, Description& d) {
  int version = 1;
  std::string schema;
  v.required("obscura", version, between(1, 1), "version of the format");
  v.optional("$schema", schema, any(), "for editors; not read");
  v.optional("name", d.name, any(), "what the scene shows");
  v.optional("time_s", d.time_s, any(), "the picture's time");
  v.required("bands", d.bands, items(1), "what the sensor tells apart");
  v.optional("clouds", d.clouds, any(), "volumes that emit, absorb and scatter");
  v.optional("objects", d.objects, any(), "surfaces");
  v.optional("materials", d.materials, any(), "materials of surfaces, by name");
  v.optional("sources", d.sources, any(), "hot spheres");
  std::optional<ParticlesDescription> particles;
  v.optional("particles", particles, any(), "hot particles over time");
  if (particles) v.particles(*particles, d.particles);
  EnvironmentDescription environment;
  v.optional("environment", environment, any(), "sky, sun, moon and air");
  d.sky = environment.sky;
  d.sun = environment.sun;
  d.moon = environment.moon;
  d.atmosphere = environment.atmosphere;
  v.required("sensor", d.sensor, any(), "the camera");
  v.optional("probes", d.probes, any(), "points whose fluence goes to the report");
  v.optional("flux", d.flux, any(), "rectangles whose power goes to the report");
  v.optional("beams", d.beams, any(), "collimated light");
  v.optional("render", d.render, any(), "how to compute");
}

}  // namespace obscura::detail
