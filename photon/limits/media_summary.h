// What a World can do to light at most, as plain values, measured once. Bounds (bounds.h) follow from them; what is
// left out because of a bound is decided elsewhere.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "photon/methods/method.h"
#include "photon/world/world.h"

namespace obscura {

/// Points p with (p - through) . inward >= 0.
struct ViewSide {
  Vec3d through;
  Vec3d inward;  ///< unit vector
};

/// What a camera sees, as a sample of its rays and the space that holds them all.
struct CameraView {
  /// A sample of its rays, in groups of `together` that lie in one pixel.
  std::vector<Ray> rays;
  std::size_t together = 1;
  /// Their convex hull holds the origins of all rays.
  std::vector<Vec3d> origins;
  /// All points of all rays lie in each of these; empty: no direction is excluded.
  std::vector<ViewSide> sides;
};

/// One cloud at one interval; all are guaranteed for every line and point of the World.
struct CloudLimits {
  double depth = 0;             ///< largest optical depth of a line; infinite where the cloud is periodic
  double depth_in_box = 0;      ///< of what lies within its box, one period of a periodic cloud
  double scattering_depth = 0;  ///< largest depth by scattering alone
  double absorption_depth = 0;
  double albedo_max = 0;  ///< of scattering over extinction
  double albedo_min = 1;
  double phase_max = 0;           ///< of the phase functions, 1/sr; infinite for a delta
  double source_min = kInfinity;  ///< emission over absorption where it absorbs, W/m2/sr; infinite: it absorbs nowhere
  double source_max = 0;          ///< infinite where it emits without absorbing
  bool emits = false;
};

struct CloudSummary {
  std::string name;
  bool periodic = false;
  bool in_view = true;   ///< false: no camera ray meets its box
  bool empty = false;    ///< no voxel holds matter
  double warmest_K = 0;  ///< highest temperature of matter; 0 where it has none
  std::vector<CloudLimits> intervals;
};

/// All clouds together, and everything else, at one interval. Radiances W/m2/sr, depths of any line.
struct IntervalLimits {
  int band = 0;
  // clouds
  double depth = 0, scattering_depth = 0, absorption_depth = 0;
  double albedo_max = 0;
  double phase_max = 0;
  double source_max = 0;
  double source_min = kInfinity;
  bool emits = false;
  // light from elsewhere
  double sky = 0;
  double sun = 0;          ///< irradiance of sun and moon, W/m2
  double disc = 0;         ///< radiance of the brightest of their discs; infinite for a point
  double surface_max = 0;  ///< black body's, of all surfaces of objects
  double surface_min = kInfinity;
  double sphere_max = 0;  ///< hot spheres and particles
  double sphere_min = kInfinity;
  bool beams = false;         ///< beams or particles light something: they have no bound here
  double air_extinction = 0;  ///< 1/m
  double air = 0;             ///< radiance of endless air
  // what surfaces do
  double reflectance_max = 0;
  double brdf_max = 0;    ///< as if all were Lambertian, 1/sr
  double mirror_max = 0;  ///< largest mirror-like reflectance
  double floor = 0;       ///< no radiance anywhere is less
  // estimates, for what things cost
  double scattering_seen = 0;  ///< largest scattering depth of 256 chords: from below
  double mean_cosine = 0;      ///< of the most forward phase function
  double segments = 0;         ///< of a view's ray through the clouds, on average
  double lost = 0;             ///< share of light that clouds take from a view's ray, on average
  double surfaces_hit = 0;     ///< share of the view's rays that end on a surface
};

/// What the picture of a band shows, W/m2/sr.
struct BandScale {
  double floor = 0;  ///< no radiance anywhere is less
  /// Derivative of a black body's radiance at 250 K, W/m2/sr/K; 0 in a grey band.
  double per_kelvin = 0;
  /// Least mean of a group of the view's rays, by emission and direct light alone: of groups that clouds dim, of groups
  /// that meet surfaces, of all. Estimates; 0 where there are none such.
  double least_cloudy = 0, least_on_surfaces = 0, least = 0;
};

struct MediaSummary {
  std::vector<CloudSummary> clouds;
  std::vector<BandScale> bands;
  std::vector<IntervalLimits> intervals;  ///< with all clouds
  /// Largest distance between any two of the view's origins, clouds, objects and spheres; infinite in a periodic World.
  double reach_m = 0;
  bool periodic = false;
  /// The box of all clouds, objects and spheres, m, where there are some and no camera ray meets any.
  std::optional<Box3d> box_out_of_view;
  std::vector<const MethodType*> unfit;  ///< methods that cannot serve the World
  /// Of sun and moon, those that there are: an opaque rectangle keeps all its light from everything; a camera ray may
  /// see its disc.
  std::vector<bool> shaded, disc_in_view;

  /// With some clouds left out. @param kept one for each cloud
  IntervalLimits limits(int interval, const std::vector<bool>& kept) const;
};

/// Measures a World: reads all leaves once and follows the view's rays. Deterministic. Costs about as much as a few
/// thousand rays and one pass over the leaves.
MediaSummary summarize(const World& world, const CameraView& view);

/// Largest value of sum over channels of weight * value along any line, in world metres: guaranteed, by layers of
/// cells. In one layer of thickness h across an index axis, a ray that advances fastest along that axis has a length of
/// at most max |(+-1, +-1, +-1) M| h, so its depth is at most that times the sum over layers of the largest value in
/// each; the largest of the three axes holds for all rays. Also at most the box's diagonal times the largest value.
/// Within a factor of sqrt(3) times the ratio of the voxels' sides of the depth along an axis where the layers are
/// filled.
class LayerMaxima {
 public:
  LayerMaxima(const Octree& octree, const Affine& index_to_world);
  double largest_integral(const std::vector<double>& weights) const;

 private:
  std::array<std::vector<std::vector<float>>, 3> largest_;  // [axis][channel][layer]
  std::array<double, 3> length_;                            // of a ray in one layer, m, at most
  double diagonal_ = 0;                                     // of the domain, m
};

}  // namespace obscura
