// The keys of bands and clouds, and of the place where a cloud or an object stands. scene_keys.h says how they are
// read.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "octree/io/volume_formats.h"
#include "scene/file/scene_json.h"
#include "scene/file/scene_limits.h"

namespace obscura::detail {

template <class V>
void keys(V& v, BandDescription& b) {
  v.optional("name", b.name, any(), "name of the band's channels; default band1, band2, ...");
  v.optional("um", b.um, numbers(2, above(0)), "lower and upper wavelength; without it the band is grey");
  v.optional("samples", b.samples, between(1, 10000), "spectral intervals in the band");
  v.optional("response", b.response, at_least(0), "spectral response, not normalised");
}

template <class V>
void keys(V& v, PlaceDescription& p) {
  v.optional("translate_m", p.translate_m, any(), "shift, applied last");
  v.optional("rotate_deg", p.rotate_deg, any(), "rotation about x, then y, then z, right-handed");
  v.optional("scale", p.scale, above(0), "size factor, applied first; density is unchanged");
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

struct PhaseTableDescription {
  std::vector<double> angle_deg, value;
  std::filesystem::path file;  // or this
};
template <class V>
void keys(V& v, PhaseFunction& p) {
  v.default_form("type", "isotropic");

  v.form("type", "rayleigh");
  v.makes(p, [] { return PhaseFunction(RayleighPhase()); });

  double g = 0;
  v.form("type", "henyey_greenstein");
  v.required("g", g, between(-1, 1), "mean cosine");
  v.makes(p, [g] { return PhaseFunction(HenyeyGreensteinPhase(g)); });

  double g1 = 0, g2 = 0, weight = 1;
  v.form("type", "double_henyey_greenstein");
  v.required("g1", g1, between(-1, 1), "mean cosine of the first lobe");
  v.required("g2", g2, between(-1, 1), "mean cosine of the second lobe");
  v.required("weight", weight, between(0, 1), "share of the first lobe");
  v.makes(p, [g1, g2, weight] { return PhaseFunction(DoubleHenyeyGreensteinPhase(g1, g2, weight)); });

  PhaseTableDescription table;
  v.form("type", "table");
  v.exactly_one({"angle_deg", "file"});
  v.optional("angle_deg", table.angle_deg, numbers(2, between(0, 180)), "scattering angles from 0 (forward) to 180");
  v.optional("value", table.value, numbers(2, at_least(0), false), "phase function there, in any unit");
  v.optional("file", table.file, any(), "table with the header angle_deg,value");
  v.phase_table(table, p);
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
  v.optional("phase", m.phase, any(), "where scattered light goes");
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
  v.optional("source", c.given_radiance, at_least(0), "in place of Planck: emission = absorption * source");
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

}  // namespace obscura::detail
