#include "photon/methods/method.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

namespace obscura {

std::span<const MethodType* const> methods() noexcept {
  static constexpr std::array<const MethodType*, 4> list{&kPhotonMap, &kFinalGather, &kPathTracer, &kOrdinates};
  return list;
}

std::size_t index_of(const MethodType& type) noexcept {
  return static_cast<std::size_t>(std::ranges::find(methods(), &type) - methods().begin());
}

std::vector<std::string> method_words() {
  std::vector<std::string> words;
  for (const MethodType* type : methods()) {
    if (std::ranges::find(words, type->word) == words.end()) words.emplace_back(type->word);
  }
  return words;
}

Estimator make_estimator(const World& world, const Method& method, const EstimatorSettings& settings,
                         const Progress& progress) {
  if (auto refusal = unfit(world, method, settings)) throw *refusal;
  return method.type->estimator(world, method, settings, method.type->solve(world, method, settings, progress));
}

std::string text(const Method& method) {
  std::string text(method.type->name);
  if (method.type->photons) text += fmt::format(", {} photons", method.photons);
  if (method.type->samples) text += fmt::format(", {} samples", method.samples);
  if (method.type->cells && method.cells > 0) text += fmt::format(", {} cells", method.cells);
  return text;
}

}  // namespace obscura
