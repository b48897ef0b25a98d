#include "scene/world/reduce.h"

#include <algorithm>

#include "scene/world/build_world.h"

namespace obscura {
namespace {

/// Everything in the scene that depends on the wavelength and is no source.
std::vector<const Spectrum*> optics_of(const Description& scene) {
  std::vector<const Spectrum*> spectra;
  for (const CloudDescription& cloud : scene.clouds) {
    for (const MediumDescription& medium : cloud.media) {
      spectra.push_back(&medium.extinction);
      spectra.push_back(&medium.albedo);
    }
  }
  for (const auto& [name, material] : scene.materials) spectra.push_back(&material.emissivity);
  if (scene.atmosphere) spectra.push_back(&scene.atmosphere->extinction_per_m);
  return spectra;
}

bool grey_in(const BandDescription& description, const std::vector<const Spectrum*>& spectra) {
  BandDescription one = description;
  one.samples = 1;
  const Band whole = make_band(one), band = make_band(description);
  return std::all_of(spectra.begin(), spectra.end(), [&](const Spectrum* spectrum) {
    const double value = whole.optics(0, *spectrum);
    for (int j = 0; j < band.interval_count(); ++j) {
      if (band.optics(j, *spectrum) != value) return false;
    }
    return true;
  });
}

}  // namespace

WorldContents reduced(const WorldContents& whole, const Cuts& cuts) {
  WorldContents contents = whole;
  std::erase_if(contents.clouds, [&](const Cloud& cloud) {
    return std::find(cuts.clouds.begin(), cuts.clouds.end(), cloud.name) != cuts.clouds.end();
  });
  for (Cloud& cloud : contents.clouds) {
    if (cuts.emission || cuts.absorption) {
      cloud.temperature = {};
      cloud.source.clear();
      cloud.emission.clear();
    }
    if (!cuts.absorption) continue;
    for (Medium& medium : cloud.media) {
      for (std::size_t i = 0; i < medium.extinction.size(); ++i) {
        medium.extinction[i] *= medium.albedo[i];
        medium.albedo[i] = 1;
      }
    }
  }
  if (cuts.surfaces) contents.objects.clear();
  if (cuts.spheres) {
    contents.sources.clear();
    contents.particles.clear();
  }
  if (cuts.specular) {
    for (Material& material : contents.materials) material.specular = 0;
  }
  if (cuts.sun) contents.sun.reset();
  if (cuts.moon) contents.moon.reset();
  if (cuts.sky) contents.sky.clear();
  if (cuts.atmosphere) contents.atmosphere.reset();
  return contents;
}

Description with_fewest_intervals(const Description& scene) {
  Description fewest = scene;
  const auto forced = scene.render.effects.find("spectral sampling");
  if (forced != scene.render.effects.end() && forced->second) return fewest;
  const bool all = forced != scene.render.effects.end();
  const std::vector<const Spectrum*> spectra = optics_of(scene);
  for (BandDescription& band : fewest.bands) {
    if (band.samples > 1 && (all || grey_in(band, spectra))) band.samples = 1;
  }
  return fewest;
}

}  // namespace obscura
