#include "edits.h"

#include <algorithm>

#include "scene/file/scene_json.h"
#include "scene/file/scene_words.h"

namespace obscura::cli {

std::vector<SceneEdit> set_edits(const std::vector<std::string>& texts, std::vector<Problem>& problems) {
  std::vector<SceneEdit> edits;
  for (const std::string& text : texts) {
    const auto equals = text.find('=');
    if (equals == std::string::npos) {
      problems.push_back({"--set " + text, "there is no \"=\"", "give /json/pointer=value"});
    } else {
      edits.push_back({text.substr(0, equals), text.substr(equals + 1), "--set"});
    }
  }
  return edits;
}

std::vector<SceneEdit> effect_edits(const std::vector<std::string>& texts, std::vector<Problem>& problems) {
  std::vector<SceneEdit> edits;
  for (const std::string& text : texts) {
    const auto equals = text.find('=');
    const std::string name = text.substr(0, equals), word = equals == std::string::npos ? "" : text.substr(equals + 1);
    const std::vector<std::string>& known = effect_names();
    if (word != "on" && word != "off") {
      problems.push_back(
          {"--effect " + text, "it does not end in =on or =off", "give NAME=on or NAME=off, e.g. \"atmosphere=off\""});
    } else if (std::find(known.begin(), known.end(), name) == known.end()) {
      problems.push_back({"--effect " + text, "there is no effect \"" + name + "\"", detail::suggest(name, known)});
    } else {
      edits.push_back({detail::pointer_to("/render/effects", name), word == "on" ? "true" : "false", "--effect"});
    }
  }
  return edits;
}

std::vector<std::filesystem::path> input_files(const std::string& scene_file, const std::optional<Description>& scene) {
  std::vector<std::filesystem::path> inputs = {scene_file};
  if (!scene) return inputs;
  for (const CloudDescription& cloud : scene->clouds) {
    if (cloud.grid && !cloud.grid->file.empty()) inputs.push_back(cloud.grid->file);
  }
  for (const ObjectDescription& object : scene->objects) {
    if (!object.mesh.empty()) inputs.push_back(object.mesh);
  }
  return inputs;
}

CLI::Option* add_effect_option(CLI::App& app, std::vector<std::string>& texts) {
  return app.add_option("--effect", texts, "Force an effect on or off, e.g. atmosphere=on; may be repeated")
      ->type_name("NAME=on|off")
      ->type_size(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll)
      ->allow_extra_args(false);
}

}  // namespace obscura::cli
