// A scene: what its file says, checked, with every default filled in. Plain values in the file's own
// units (its names carry them); nothing here is loaded but small tables.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "octree/base/math.h"
#include "octree/source/puffs.h"
#include "photon/map/kernel.h"
#include "photon/optics/directions.h"
#include "photon/optics/phase.h"
#include "photon/optics/spectrum.h"
#include "sensor/capture/camera.h"
#include "sensor/judge/image_error.h"
#include "sensor/picture/detector.h"

namespace obscura {

/// One band; without `um` it is grey: no wavelengths, any one unit, no Planck.
struct BandDescription {
  std::string name;
  std::optional<std::array<double, 2>> um;  ///< lower and upper edge, increasing
  int samples = 1;                          ///< spectral intervals in the band
  Spectrum response = Spectrum::constant(1);

  bool grey() const noexcept { return !um; }
};

/// p -> t + Rz Ry Rx (s p), right-handed; the scale leaves density unchanged.
struct PlaceDescription {
  Vec3d translate_m{0, 0, 0};
  Vec3d rotate_deg{0, 0, 0};
  double scale = 1;
};

enum class GridKind { file, sphere, box, gaussian };

/// A volume: a file (its kind is its extension), or a shape with one grid "density".
struct GridDescription {
  GridKind kind = GridKind::file;
  std::filesystem::path file;  ///< absolute or relative to the working folder, ready to open
  double radius_m = 0;         ///< sphere
  double sigma_m = 0;          ///< gaussian
  Vec3d size_m{0, 0, 0};       ///< box, gaussian
  double voxel_m = 0;          ///< all shapes
};

/// What one grid of a cloud does to light. Media of a cloud overlap and add up.
struct MediumDescription {
  std::string density = "density";              ///< grid name
  Spectrum extinction = Spectrum::constant(0);  ///< 1/m per unit of density
  Spectrum albedo = Spectrum::constant(0);
  PhaseFunction phase;
};

/// The kelvin of a cloud: value of the grid * scale + offset_K, or one number.
struct TemperatureDescription {
  std::string grid;  ///< empty: `K` everywhere
  double scale = 1;
  double offset_K = 0;
  double K = 0;
};

struct CloudDescription {
  std::string name;
  std::optional<GridDescription> grid;  ///< exactly one of grid and puffs
  std::optional<PuffSettings> puffs;
  std::vector<MediumDescription> media;  ///< one or more
  std::optional<TemperatureDescription> temperature;
  std::optional<Spectrum> given_radiance;     ///< in place of Planck's law (the key "source"); see Emitter
  Spectrum emission = Spectrum::constant(0);  ///< W/m3/sr per unit of density, added as it is
  PlaceDescription place;
  std::array<bool, 2> periodic{false, false};  ///< along x, y
  std::array<double, 2> period_m{0, 0};        ///< 0: not given, n * dx
};

enum class SurfaceKind { mesh, plane, box, sphere };

/// What a scene gives to a named part of a mesh file; what it leaves out is the object's.
struct GroupDescription {
  std::optional<std::string> material;
  std::optional<double> K;
};

/// A surface: a file of triangles, or a shape about the origin.
struct ObjectDescription {
  std::string name;
  SurfaceKind kind = SurfaceKind::mesh;
  std::filesystem::path mesh;                      ///< ready to open
  std::map<std::string, GroupDescription> groups;  ///< by a group's or a material's name in the file
  std::filesystem::path temperature;               ///< table of kelvin per face or vertex; empty: none
  std::array<double, 2> plane_m{0, 0};             ///< plane: its sides
  Vec3d box_m{0, 0, 0};                            ///< box: its edges
  double radius_m = 0;                             ///< sphere
  std::string material;                            ///< empty: black
  std::optional<double> K;
  std::optional<Spectrum> radiance;  ///< see Emitter; times emissivity
  bool double_sided = false;
  PlaceDescription place;

  /// Whether the scene file gives it kelvin anywhere; a mesh file may hold its own.
  bool has_kelvin() const;
};

struct MaterialDescription {
  Spectrum emissivity = Spectrum::constant(1);
  std::vector<double> angle_deg, angle_factor;  ///< of the emissivity, from the normal; empty: none
  double specular = 0;
  double roughness = 0;
  double permeable = 0;
};

/// A hot sphere (an entry of the key "sources").
struct HotSphereDescription {
  std::string name;
  Vec3d position_m{0, 0, 0};
  double radius_m = 0;
  std::optional<double> K;
  std::optional<Spectrum> radiance;
};

/// One hot sphere of a table over time.
struct ParticleDescription {
  double s = 0;
  Vec3d position_m{0, 0, 0};
  double radius_m = 0;
  double K = 0;
};

struct SkyDescription {
  std::optional<double> K;
  std::optional<Spectrum> radiance;
};

struct SunDescription {
  Vec3d toward{0, 0, 1};                        ///< unit vector from the scene to the sun
  Spectrum irradiance = Spectrum::constant(1);  ///< normal to the beam
  double diameter_deg = 0.533;
};

/// Clear air; without K or radiance it has 288 K.
struct AtmosphereDescription {
  Spectrum extinction_per_m = Spectrum::constant(0);
  std::optional<double> K;
  std::optional<Spectrum> radiance;
};

/// When a pixel gets more rays than one. A criterion whose threshold nothing reaches is off.
struct AntialiasingDescription {
  int polygons = 2;                    ///< this many that differ; 0: every pixel gets max_oversampling rays
  std::optional<int> polygons_strict;  ///< this many, alike or not
  int materials = 2;
  double normal_deg = 5;
  double depth = 0.05;  ///< relative
  double temperature_K = 1;
  double emissivity = 0.02;
  double shadow = 0.05;
  double transmission = 0.05;
  double radiance = 0.05;       ///< relative
  std::optional<double> error;  ///< relative standard error that a pixel is to reach

  /// Whether pixels get different numbers of rays; false: each gets max_oversampling.
  bool adaptive() const noexcept { return polygons != 0 && polygons_strict != 0 && materials != 0; }
};

/// The camera, and what becomes of its rays.
struct SensorDescription : CameraSettings {
  bool operator==(const SensorDescription&) const = delete;  // would compare the camera alone

  int max_oversampling = 16;  ///< rays per pixel, at most
  AntialiasingDescription antialiasing;
  int specular_depth = 4;               ///< mirror reflections at most
  std::optional<int> scattering_depth;  ///< none: no limit
  DetectorSettings detector;
};

struct ProbeDescription {
  std::string name;
  Vec3d position_m{0, 0, 0};
};

struct FluxDescription {
  std::string name;
  Vec3d center_m{0, 0, 0};
  Vec3d normal{0, 0, 1};  ///< unit vector
  std::array<double, 2> size_m{0, 0};
};

struct BeamDescription {
  Vec3d position_m{0, 0, 0};
  Vec3d toward{0, 0, -1};  ///< unit vector, where the light goes
  double radius_m = 0;
  Spectrum power = Spectrum::constant(1);
};

struct RenderDescription {
  std::string method;               ///< a word of method_words(); empty: the plan chooses
  std::uint64_t photons = 1000000;  ///< emitted, per band
  int nearest = 64;
  Kernel kernel = Kernel::epanechnikov;
  double photon_power_min = 0;
  Directions directions = Directions::stratified;
  std::optional<int> final_gather;  ///< none: the plan decides
  int samples = 64;
  double octree_tolerance = 1e-3;
  std::optional<ErrorTarget> target_error;
  double floor = 0;                    ///< of grey bands: radiance below which nothing matters
  std::optional<double> time_limit_s;  ///< for the whole run
  std::uint64_t seed = 1;
  /// Effects that are on or off whatever the plan would decide, by name.
  std::map<std::string, bool> effects;
};

/// The effects that a plan decides about, in its order.
const std::vector<std::string>& effect_names();

/// A scene. Every value is inside its range; every named file was there when it was read.
struct Description {
  std::string name;
  double time_s = 0;
  std::vector<BandDescription> bands;
  std::vector<CloudDescription> clouds;
  std::vector<ObjectDescription> objects;
  std::map<std::string, MaterialDescription> materials;
  std::vector<HotSphereDescription> hot_spheres;
  std::vector<ParticleDescription> particles;  ///< all times, as in the file
  std::optional<SkyDescription> sky;
  std::optional<SunDescription> sun;
  std::optional<SunDescription> moon;
  std::optional<AtmosphereDescription> atmosphere;
  SensorDescription sensor;
  std::vector<ProbeDescription> probes;
  std::vector<FluxDescription> flux;
  std::vector<BeamDescription> beams;
  RenderDescription render;

  std::vector<std::string> warnings;  ///< what the user should know, one sentence each
  std::string hash;                   ///< 16 hexadecimal digits; the same for the same values, however written
};

/// What gives the radiance of something that may have a temperature and a given radiance. A grey band takes the given
/// radiance. So does any other band, unless there is a temperature too and the scene also holds grey bands: then the
/// given radiance is for the grey ones.
enum class Emitter { none, planck, radiance };
Emitter emitter(const Description& scene, const BandDescription& band, bool has_temperature,
                bool has_radiance) noexcept;

/// Makes a scene's picture fit for all methods: it becomes at most `pixels` wide and high, with the same
/// view and the same settings per pixel.
void shrink_picture(Description& scene, int pixels);

}  // namespace obscura
