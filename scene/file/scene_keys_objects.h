// The keys of surfaces and their materials, and of hot spheres and particles. scene_keys.h says how they are read.
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "scene/file/scene_json.h"
#include "scene/file/scene_limits.h"

namespace obscura::detail {

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
void keys(V& v, HotSphereDescription& s) {
  v.optional("name", s.name, any(), "for messages");
  v.required("position_m", s.position_m, any(), "centre");
  v.required("radius_m", s.radius_m, above(0), "radius");
  v.optional("K", s.K, at_least(0), "temperature; not in a grey band");
  v.optional("radiance", s.radiance, at_least(0), "in place of K");
}

struct ParticlesDescription {
  std::filesystem::path file;
};
template <class V>
void keys(V& v, ParticlesDescription& p) {
  v.required("file", p.file, any(), "table with the header s,x_m,y_m,z_m,radius_m,K");
}

}  // namespace obscura::detail
