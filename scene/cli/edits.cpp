#include "edits.h"

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

}  // namespace obscura::cli
