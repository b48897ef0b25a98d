// Scenes that between them hold every key that can be given, and the folder of files that they name.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/support/scratch_folder.h"

namespace obscura::test {

using Json = nlohmann::ordered_json;

/// A folder with the files that the scenes name.
struct SceneFolder : ScratchFolder {
  explicit SceneFolder(const std::string& name) : ScratchFolder(name) {
    write("smoke.vdb", "not read here");
    write("table.csv", "um,value\n8,0.1\n12,0.2\n");
    write("phase.csv", "angle_deg,value\n0,0.0795775\n180,0.0795775\n");
    write("p.csv", "s,x_m,y_m,z_m,radius_m,K\n0,0,0,1,0.01,900\n1,0,0,2,0.01,800\n");
    write("truck.obj", "not read here");
    write("K.csv", "not read here");
    write("psf.pgm", "P2 3 3 255 0 10 0 10 60 10 0 20 0\n");
    write("cloud.f32", "not read here");
    write("raw.json", R"({"raw": "cloud.f32"})");
  }
};

inline Json parse(const char* text) { return Json::parse(text); }

/// Every key of bands with wavelengths.
inline Json full_scene() {
  return parse(R"({
    "obscura": 1, "$schema": "scene.schema.json", "name": "smoke", "time_s": 0,
    "bands": [{"name": "lwir", "um": [8, 12], "samples": 4,
               "response": {"um": [8, 10, 12], "value": [0, 1, 0]}}, {"name": "mwir", "um": [3, 5]}],
    "clouds": [
      {"name": "smoke", "grid": {"file": "smoke.vdb"}, "frames": {},
       "media": [{"density": "density", "extinction": 0.2, "albedo": {"file": "table.csv"},
                  "phase": {"type": "henyey_greenstein", "g": 0.7},
                  "coefficients": {}, "mie": {}, "radius": {}},
                 {"extinction": {"um": [8, 12], "value": [1, 2]}, "phase": {"type": "rayleigh"}},
                 {"extinction": 1, "phase": {"type": "isotropic"}},
                 {"extinction": 1, "phase": {"type": "double_henyey_greenstein", "g1": 0.8, "g2": -0.3, "weight": 0.9}},
                 {"extinction": 1, "phase": {"type": "table", "angle_deg": [0, 180], "value": [0.0795775, 0.0795775]}},
                 {"extinction": 1, "phase": {"type": "table", "file": "phase.csv"}}],
       "temperature": {"grid": "temperature", "scale": 1, "offset_K": 0},
       "emission": 0.0,
       "place": {"translate_m": [0, 0, 0], "rotate_deg": [0, 0, 90], "scale": 2}, "trajectory": [], "carried_by": null,
       "periodic": ["x", "y"], "period_m": [640, 740]},
      {"puffs": {"sources": [{"position_m": [0, 0, 0], "mass_g": 300, "burn_s": 30, "K": 600}],
                 "wind_m_s": [2, 0, 0], "turbulence": 0.3, "age_s": 20, "voxel_m": 0.25, "seed": 1},
       "media": [{"extinction": 1}], "temperature": {"K": 320}},
      {"grid": {"shape": "sphere", "radius_m": 1, "voxel_m": 0.02}, "media": [{"extinction": 1}], "source": 1.0},
      {"grid": {"shape": "box", "size_m": [1, 1, 1], "voxel_m": 0.1}, "media": [{"extinction": 1}], "source": 1.0},
      {"grid": {"shape": "gaussian", "sigma_m": 0.5, "size_m": [4, 4, 4], "voxel_m": 0.05},
       "media": [{"extinction": 1}], "source": 1.0}],
    "objects": [
      {"name": "truck", "mesh": "truck.obj", "material": "paint", "K": 310, "double_sided": false,
       "groups": {"wheel": {"material": "rubber", "K": 320}}, "temperature": {"file": "K.csv"},
       "place": {"translate_m": [1, 2, 3]}, "trajectory": [], "carried_by": null},
      {"shape": "plane", "size_m": [100, 50], "material": "paint", "double_sided": true},
      {"shape": "box", "size_m": [1, 2, 3], "radiance": 2},
      {"shape": "sphere", "radius_m": 0.5, "K": 300}],
    "materials": {"paint": {"emissivity": 0.9, "specular": 0.2, "roughness": 0.1, "permeable": 0.25,
                            "emissivity_by_angle": {"angle_deg": [0, 90], "factor": [1, 0.5]}},
                  "rubber": {}},
    "sources": [{"name": "flare", "position_m": [0, 0, 2], "radius_m": 0.1, "K": 2000},
                {"position_m": [0, 0, 3], "radius_m": 0.1, "radiance": 5}],
    "particles": {"file": "p.csv"},
    "environment": {"sky": {"radiance": 0.0, "elevation_deg": null, "file": null},
                    "sun": {"toward": [0, 0, 2], "irradiance": 1.0, "diameter_deg": 0.533},
                    "moon": {"zenith_deg": 60, "azimuth_deg": 90, "irradiance": 0.25},
                    "atmosphere": {"extinction_per_m": 1e-4, "K": 280}},
    "sensor": {"position_m": [0, -10, 1], "look_at_m": [0, 0, 1], "up": [0, 0, 1],
               "projection": "perspective", "fov_deg": 20, "resolution": [320, 240], "max_oversampling": 16,
               "antialiasing": {"polygons": 2, "polygons_strict": null, "materials": 2, "normal_deg": 5, "depth": 0.05,
                                "temperature_K": 1, "emissivity": 0.02, "shadow": 0.05, "transmission": 0.05,
                                "radiance": 0.05, "error": null},
               "specular_depth": 4, "scattering_depth": null,
               "detector": {"psf_sigma_px": 0, "psf_file": "psf.pgm", "nedt_K": 0.05, "nedt_at_K": 290, "ner": 0,
                            "integration_s": 0.01, "reference_integration_s": 0.02, "dead_share": 0.001,
                            "gain_nonuniformity": 0.01, "offset_nonuniformity": 0.02, "gain": 2, "offset": -1,
                            "bits": 14, "range": [0, 50], "seed": 3,
                            "bands": {"lwir": {"psf_sigma_px": 1, "nedt_K": 0.1, "ner": 0, "gain": 3, "offset": 1,
                                               "range": [0, 60]}}}},
    "probes": [{"name": "p", "position_m": [0, 0, 0]}],
    "flux": [{"name": "top", "center_m": [0, 0, 1], "normal": [0, 0, 1], "size_m": [2, 2]}],
    "beams": [{"position_m": [0, 0, 5], "toward": [0, 0, -1], "radius_m": 0, "power": 1}],
    "render": {"method": "photon", "photons": 1000000, "nearest": 64, "kernel": "epanechnikov",
               "photon_power_min": 0, "directions": "stratified", "final_gather": null, "samples": 64,
               "octree_tolerance": 0.001, "target_error": "20mK", "floor": 0.001, "time_limit_s": 60, "memory_MiB": null, "seed": 1,
               "effects": {"atmosphere": true, "multiple scattering": false}}
  })");
}

/// What the first cannot hold beside: sky by kelvin, sun by angles, an orthographic camera, air by radiance.
inline Json other_scene() {
  return parse(R"({
    "obscura": 1, "bands": [{"um": [8, 12]}],
    "environment": {"sky": {"K": 250}, "sun": {"zenith_deg": 30, "azimuth_deg": 135, "irradiance": 1},
                    "atmosphere": {"radiance": 2}},
    "sensor": {"position_m": [0, 0, 10], "look_at_m": [0, 0, 0], "up": [0, 1, 0],
               "projection": "orthographic", "width_m": 5, "resolution": [8, 8], "scattering_depth": 3},
    "render": {"photons": 1000, "nearest": 8, "kernel": "cone", "directions": "random", "seed": 7}
  })");
}

inline std::vector<Json> all_scenes() { return {full_scene(), other_scene()}; }

}  // namespace obscura::test
