#include "scene/file/scene_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "photon/methods/method.h"
#include "scene/file/scene_words.h"

namespace obscura::detail {
namespace {

std::string element(const char* list, std::size_t index) { return pointer_to(pointer_to("", list), index); }

/// Refuses names that are given twice, and fills in word1, word2, ... where none is given.
template <class T>
void check_names(Findings& findings, std::vector<T>& things, const char* list, const std::string& word) {
  std::map<std::string, std::size_t> first;
  for (std::size_t i = 0; i < things.size(); ++i) {
    if (things[i].name.empty()) continue;
    const auto [it, is_new] = first.emplace(things[i].name, i);
    if (is_new) continue;
    findings.problem(pointer_to(element(list, i), "name"),
                     fmt::format("the name \"{}\" is given twice, first at {}", things[i].name,
                                 pointer_to(element(list, it->second), "name")),
                     "give each a name of its own");
  }
  for (std::size_t i = 0; i < things.size(); ++i) {
    std::size_t number = i + 1;
    while (things[i].name.empty()) {
      const std::string name = word + std::to_string(number++);
      if (first.emplace(name, i).second) things[i].name = name;
    }
  }
}

/// Makes a direction a unit vector. Any length but 0 is accepted.
void check_direction(Findings& findings, const std::string& pointer, Vec3d& direction) {
  if (!findings.good(pointer)) return;
  const double length = direction.length();
  if (length > 0 && std::isfinite(length)) {
    direction /= length;
  } else {
    findings.problem(pointer, "the direction has no length", "give a vector such as [0, 0, 1]");
  }
}

void check_bands(Findings& findings, std::vector<BandDescription>& bands) {
  check_names(findings, bands, "bands", "band");
  for (std::size_t i = 0; i < bands.size(); ++i) {
    const BandDescription& band = bands[i];
    const std::string pointer = element("bands", i);
    if (band.name == "name" || band.name.find('.') != std::string::npos || band.name.size() > 100) {
      findings.problem(pointer_to(pointer, "name"),
                       fmt::format("\"{:.120}\" cannot name a band: it names channels and report entries", band.name),
                       "give a short name without a full stop, other than \"name\"");
    }
    if (findings.bad(pointer_to(pointer, "um"))) continue;
    if (band.grey()) {
      if (band.samples != 1) {
        findings.problem(pointer_to(pointer, "samples"), "a grey band has no wavelengths to divide",
                         "give \"um\" or leave \"samples\" out");
      }
      if (!(band.response == Spectrum::constant(1))) {
        findings.problem(pointer_to(pointer, "response"), "a grey band has no wavelengths to respond to",
                         "give \"um\" or leave \"response\" out");
      }
    } else if (!(band.response.max((*band.um)[0], (*band.um)[1]) > 0)) {
      findings.problem(pointer_to(pointer, "response"), "the response is 0 in the whole band",
                       "give a response that is above 0 somewhere in the band");
    }
  }
}

/// A grey band has no wavelengths: it takes given radiances, but no temperatures and no spectral tables.
void check_grey(Findings& findings, const Description& scene) {
  const BandDescription* grey = nullptr;
  bool all_grey = true;
  for (std::size_t i = 0; i < scene.bands.size(); ++i) {
    const bool is_grey = scene.bands[i].grey() && !findings.bad(pointer_to(element("bands", i), "um"));
    if (is_grey && !grey) grey = &scene.bands[i];
    all_grey = all_grey && is_grey;
  }
  const bool any_grey = grey != nullptr;

  const auto refuse_kelvin = [&](const std::string& pointer, const char* instead) {
    findings.problem(pointer, fmt::format("a temperature says nothing in the grey band \"{}\"", grey->name),
                     fmt::format("give \"{}\" instead, or give the band \"um\"", instead));
  };
  // A temperature beside a radiance: each has to have bands that use it.
  const auto check_pair = [&](const std::string& K, const std::string& pointer, bool has_K, bool has_radiance) {
    if (any_grey && has_K && (all_grey || !has_radiance)) {
      refuse_kelvin(K, "radiance");
    } else if (!any_grey && has_K && has_radiance) {
      findings.problem(pointer_to(pointer, "radiance"), "\"K\" and \"radiance\" are both given",
                       "give one; both only where the scene also holds grey bands, which take the radiance");
    }
  };
  // @param needed  one of the two has to be given
  const auto check_either = [&](const std::string& pointer, bool has_K, bool has_radiance, bool needed) {
    if (findings.bad(pointer_to(pointer, "K")) || findings.bad(pointer_to(pointer, "radiance"))) return;
    check_pair(pointer_to(pointer, "K"), pointer, has_K, has_radiance);
    if (needed && !has_K && !has_radiance) {
      findings.problem(pointer_to(pointer, any_grey ? "radiance" : "K"), "neither \"K\" nor \"radiance\" is given",
                       any_grey ? "give \"radiance\"" : "give one of them");
    }
  };

  for (std::size_t i = 0; i < scene.hot_spheres.size(); ++i) {
    const std::string pointer = element("sources", i);
    check_either(pointer, scene.hot_spheres[i].K.has_value(), scene.hot_spheres[i].radiance.has_value(), true);
  }
  if (scene.sky) {
    check_either("/environment/sky", scene.sky->K.has_value(), scene.sky->radiance.has_value(), false);
  }
  if (scene.atmosphere) {
    check_either("/environment/atmosphere", scene.atmosphere->K.has_value(), scene.atmosphere->radiance.has_value(),
                 false);
  }
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    const ObjectDescription& object = scene.objects[i];
    const std::string pointer = element("objects", i);
    check_either(pointer, object.K.has_value(), object.radiance.has_value(), false);
    if (findings.bad(pointer_to(pointer, "radiance"))) continue;
    // A temperature of a group or of single faces counts as one of the object.
    for (const auto& [name, group] : object.groups) {
      const std::string K = pointer_to(pointer_to(pointer_to(pointer, "groups"), name), "K");
      if (group.K) check_pair(K, pointer, true, object.radiance.has_value());
    }
    if (!object.temperature.empty()) {
      check_pair(pointer_to(pointer, "temperature"), pointer, true, object.radiance.has_value());
    }
  }
  if (!any_grey) return;

  if (!scene.particles.empty()) {
    findings.problem("/particles", "particles radiate by their K, which says nothing in a grey band",
                     "give hot spheres with \"radiance\" in \"sources\" instead, or give the band \"um\"");
  }
  for (std::size_t i = 0; i < scene.clouds.size(); ++i) {
    const CloudDescription& cloud = scene.clouds[i];
    if (!cloud.temperature || (cloud.given_radiance && !all_grey)) continue;
    const std::string pointer = pointer_to(element("clouds", i), "temperature");
    refuse_kelvin(cloud.temperature->grid.empty() ? pointer_to(pointer, "K") : pointer, "source");
  }
  for (const std::string& pointer : findings.spectral_tables) {
    if (pointer.rfind("/bands/", 0) == 0) continue;
    findings.problem(pointer, fmt::format("the grey band \"{}\" has no wavelength to look a table up at", grey->name),
                     "give a number, or give the band \"um\"");
  }
}

/// Shapes and puffs have grids of known names. The grids of a file are checked when it is opened.
void check_grids(Findings& findings, const CloudDescription& cloud, const std::string& pointer) {
  std::vector<std::string> grids = {"density"};
  if (cloud.puffs) grids.emplace_back("temperature");
  if (!cloud.puffs && (!cloud.grid || cloud.grid->kind == GridKind::file)) return;
  const auto check = [&](const std::string& at, const std::string& name) {
    if (std::find(grids.begin(), grids.end(), name) != grids.end()) return;
    findings.problem(
        at, fmt::format("{} no grid \"{}\"", cloud.puffs ? "puffs have" : "a shape has", name),
        cloud.puffs ? "they have density and temperature" : "it has density alone; a temperature can be {\"K\": 300}");
  };
  for (std::size_t i = 0; i < cloud.media.size(); ++i) {
    check(pointer_to(pointer_to(pointer_to(pointer, "media"), i), "density"), cloud.media[i].density);
  }
  if (cloud.temperature && !cloud.temperature->grid.empty()) {
    check(pointer_to(pointer_to(pointer, "temperature"), "grid"), cloud.temperature->grid);
  }
}

void check_clouds(Findings& findings, Description& scene) {
  check_names(findings, scene.clouds, "clouds", "cloud");
  for (std::size_t i = 0; i < scene.clouds.size(); ++i) {
    const CloudDescription& cloud = scene.clouds[i];
    const std::string pointer = element("clouds", i);
    check_grids(findings, cloud, pointer);
    if (cloud.grid && cloud.grid->kind != GridKind::file && cloud.grid->voxel_m > 0) {
      const GridDescription& grid = *cloud.grid;
      const double size =
          grid.kind == GridKind::sphere ? 2 * grid.radius_m : std::max({grid.size_m.x, grid.size_m.y, grid.size_m.z});
      if (size / grid.voxel_m > 1e6) {
        findings.problem(pointer_to(pointer_to(pointer, "grid"), "voxel_m"),
                         fmt::format("{:g} m are {:.3g} voxels", size, size / grid.voxel_m),
                         "give larger voxels: at most a million along an axis");
      }
    }
    if (cloud.temperature && cloud.given_radiance &&
        std::none_of(scene.bands.begin(), scene.bands.end(), [](const auto& b) { return b.grey(); })) {
      findings.warn(fmt::format("cloud \"{}\" has a source, which replaces Planck's law: its temperature is not used",
                                cloud.name));
    }
    if (cloud.temperature || cloud.given_radiance || !(cloud.emission == Spectrum::constant(0))) continue;
    for (const BandDescription& band : scene.bands) {
      if (band.um && (*band.um)[1] > kThermal_um) {
        findings.warn(
            fmt::format("cloud \"{}\" has no temperature: it does not emit in band \"{}\"", cloud.name, band.name));
      }
    }
  }
}

void check_objects(Findings& findings, Description& scene) {
  check_names(findings, scene.objects, "objects", "object");
  std::vector<std::string> names;
  for (const auto& [name, ignored] : scene.materials) names.push_back(name);
  const bool unread = scene.materials.empty() && findings.bad("/materials");
  const auto check_material = [&](const std::string& pointer, const std::string& name) {
    if (scene.materials.count(name) || unread) return;
    findings.problem(
        pointer, fmt::format("there is no material \"{}\"", name),
        names.empty() ? "describe it in \"materials\", or leave it out: emissivity 1" : suggest(name, names));
  };
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    const ObjectDescription& object = scene.objects[i];
    const std::string pointer = element("objects", i);
    if (!object.material.empty()) check_material(pointer_to(pointer, "material"), object.material);
    for (const auto& [name, group] : object.groups) {
      if (!group.material) continue;
      check_material(pointer_to(pointer_to(pointer_to(pointer, "groups"), name), "material"), *group.material);
    }
  }
}

void check_sensor(Findings& findings, SensorDescription& s) {
  const bool placed = findings.good("/sensor/position_m") && findings.good("/sensor/look_at_m");
  const Vec3d view = s.look_at_m - s.position_m;
  const double distance = view.length();
  if (placed && !(distance > 0)) {
    findings.problem("/sensor/look_at_m", "the sensor looks at its own position", "give a point that it looks at");
  }
  if (findings.good("/sensor/up") && !(s.up.length() > 0)) {
    findings.problem("/sensor/up", "the direction has no length", "give a vector such as [0, 0, 1]");
  } else if (placed && distance > 0 && !findings.bad("/sensor/up")) {
    const double sine = view.cross(s.up).length() / (distance * s.up.length());
    if (!(sine > 1e-9)) {
      findings.problem("/sensor/up", "up is parallel to the view", "give an up such as [0, 1, 0] or [1, 0, 0]");
    }
  }
  switch (s.projection) {
    case Projection::perspective:
      if (s.fov_deg >= 180) {
        findings.problem("/sensor/fov_deg", fmt::format("a perspective camera cannot see {:g} degrees", s.fov_deg),
                         "give less than 180, or \"projection\": \"fisheye\"");
      }
      break;
    case Projection::orthographic:
      if (!findings.good("/sensor/width_m")) {
        findings.problem("/sensor/width_m", "\"width_m\" is missing: an orthographic camera needs it",
                         "give the picture's width");
      }
      if (findings.good("/sensor/fov_deg")) findings.warn("/sensor/fov_deg: an orthographic camera does not use it");
      break;
    case Projection::fisheye:
      break;
  }
  if (s.projection != Projection::orthographic && findings.good("/sensor/width_m")) {
    findings.warn("/sensor/width_m: only an orthographic camera uses it");
  }
}

void check_detector(Findings& findings, const Description& scene) {
  const DetectorSettings& d = scene.sensor.detector;
  const auto at = [](const char* key) { return pointer_to("/sensor/detector", key); };
  bool noisy = false;
  std::vector<std::string> names;
  for (std::size_t i = 0; i < scene.bands.size(); ++i) {
    const BandDescription& band = scene.bands[i];
    names.push_back(band.name);
    const DetectorSettings own = d.of_band(band.name);
    noisy = noisy || own.noisy();
    if (!(own.nedt_K > 0) || !band.grey() || findings.bad(pointer_to(element("bands", i), "um"))) continue;
    const auto override = d.bands.find(band.name);
    const bool its_own = override != d.bands.end() && override->second.nedt_K;
    findings.problem(its_own ? pointer_to(pointer_to(at("bands"), band.name), "nedt_K") : at("nedt_K"),
                     fmt::format("a temperature says nothing in the grey band \"{}\"", band.name),
                     "give \"ner\" instead, or give the band \"um\"");
  }
  if (d.nedt_K > 0 && d.ner > 0) {
    findings.problem(at("ner"), "\"nedt_K\" and \"ner\" are both given", "give one of them");
  }
  for (const auto& [name, own] : d.bands) {
    const std::string pointer = pointer_to(at("bands"), name);
    if (std::find(names.begin(), names.end(), name) == names.end() && !findings.bad("/bands")) {
      findings.problem(pointer, fmt::format("there is no band \"{}\"", name), suggest(name, names));
    }
    if (own.nedt_K.value_or(0) > 0 && own.ner.value_or(0) > 0) {
      findings.problem(pointer_to(pointer, "ner"), "\"nedt_K\" and \"ner\" are both given", "give one of them");
    }
  }
  for (const auto& [one, other] :
       {std::pair{"integration_s", "reference_integration_s"}, std::pair{"reference_integration_s", "integration_s"}}) {
    if (!findings.good(at(one)) || findings.good(at(other)) || findings.bad(at(other))) continue;
    if (one == std::string("integration_s") ? !d.integration_s : !d.reference_integration_s) continue;
    findings.problem(at(other), fmt::format("\"{}\" is missing: \"{}\" is given", other, one),
                     "the noise falls with the root of integration_s / reference_integration_s");
  }
  if (d.integration_s && !noisy) {
    findings.warn(at("integration_s") + ": it changes the noise, and there is none");
  }
  if (d.bits == 0 && !(d.range == DetectorSettings{}.range)) {
    findings.warn(at("range") + ": it is the range of counts, and there are none without \"bits\"");
  }
}

}  // namespace

void check_target(Findings& findings, const Description& scene) {
  const std::optional<ErrorTarget>& target = scene.render.target_error;
  if (!target || target->unit != ErrorUnit::kelvin) return;
  const auto thermal = [](const BandDescription& band) { return band.um && (*band.um)[1] > kThermal_um; };
  if (std::ranges::any_of(scene.bands, thermal) || findings.bad("/bands")) return;
  findings.problem("/render/target_error", "no band has temperatures: none goes above 2.5 um",
                   "give the error as a fraction, such as 0.03");
}

void check_description(Findings& findings, Description& scene) {
  check_bands(findings, scene.bands);
  check_clouds(findings, scene);
  check_objects(findings, scene);
  check_names(findings, scene.hot_spheres, "sources", "source");
  check_names(findings, scene.probes, "probes", "probe");
  check_names(findings, scene.flux, "flux", "flux");
  check_grey(findings, scene);
  check_sensor(findings, scene.sensor);
  check_detector(findings, scene);
  check_target(findings, scene);
  if (scene.sun) check_direction(findings, "/environment/sun/toward", scene.sun->toward);
  if (scene.moon) check_direction(findings, "/environment/moon/toward", scene.moon->toward);
  for (std::size_t i = 0; i < scene.flux.size(); ++i) {
    check_direction(findings, pointer_to(element("flux", i), "normal"), scene.flux[i].normal);
  }
  for (std::size_t i = 0; i < scene.beams.size(); ++i) {
    check_direction(findings, pointer_to(element("beams", i), "toward"), scene.beams[i].toward);
  }
  if (scene.render.samples != RenderDescription{}.samples && scene.render.method == kPhotonMap.word &&
      scene.render.final_gather == 0) {
    findings.warn("/render/samples: method photon without final gather does not use it");
  }
  if (scene.render.final_gather == 1 && scene.sensor.scattering_depth) {
    findings.problem("/render/final_gather",
                     "photons of the map may have scattered scattering_depth times before the bounce",
                     "leave \"final_gather\" or \"scattering_depth\" out");
  }
}

}  // namespace obscura::detail
