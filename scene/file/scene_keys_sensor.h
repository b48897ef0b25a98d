// The keys of what is measured: the sensor and its detector, probes and flux rectangles. scene_keys.h says how they are
// read.
#pragma once

#include <filesystem>

#include "scene/file/scene_limits.h"

namespace obscura::detail {

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

}  // namespace obscura::detail
