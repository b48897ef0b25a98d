#include "scene/file/description.h"

#include <algorithm>
#include <cmath>

namespace obscura {

const std::vector<std::string>& effect_names() {
  static const std::vector<std::string> names = {"absorption",
                                                 "emission",
                                                 "single scattering",
                                                 "multiple scattering",
                                                 "surfaces",
                                                 "specular",
                                                 "sun",
                                                 "sky",
                                                 "atmosphere",
                                                 "time",
                                                 "spectral sampling",
                                                 "masking"};
  return names;
}

bool ObjectDescription::has_kelvin() const {
  return K || !temperature.empty() ||
         std::any_of(groups.begin(), groups.end(), [](const auto& group) { return group.second.K.has_value(); });
}

Emitter emitter(const Description& scene, const BandDescription& band, bool has_temperature,
                bool has_radiance) noexcept {
  const bool any_grey =
      std::any_of(scene.bands.begin(), scene.bands.end(), [](const BandDescription& b) { return b.grey(); });
  if (has_temperature && !band.grey() && (!has_radiance || any_grey)) return Emitter::planck;
  return has_radiance ? Emitter::radiance : Emitter::none;
}

void shrink_picture(Description& scene, int pixels) {
  const int largest = std::max(scene.sensor.resolution[0], scene.sensor.resolution[1]);
  if (largest <= pixels) return;
  for (int& side : scene.sensor.resolution) {
    side = std::max(1, static_cast<int>(std::lround(static_cast<double>(side) * pixels / largest)));
  }
}

}  // namespace obscura
