#include "scene/file/scene_io.h"

#include "scene/file/scene_check.h"
#include "scene/file/scene_reader.h"
#include "scene/file/scene_table_io.h"

namespace obscura {
namespace {

// A problem at or below an edited place is the option's.
void name_options(std::vector<Problem>& problems, const std::vector<SceneEdit>& edits) {
  for (Problem& problem : problems) {
    for (const SceneEdit& edit : edits) {
      if (edit.option.empty()) continue;
      if (problem.where == edit.pointer || problem.where.rfind(edit.pointer + '/', 0) == 0) {
        problem.problem += ", from " + edit.option;
      }
    }
  }
}

}  // namespace

Description parse_scene(const std::string& text, const std::filesystem::path& base_folder,
                        const std::vector<SceneEdit>& edits, const std::string& name) {
  detail::Findings findings(base_folder);
  detail::Json document = detail::parse_json(text, name, findings.problems);
  for (const SceneEdit& edit : edits) {
    const std::string wrong = detail::set_value(document, edit.pointer, detail::value_from_text(edit.value));
    if (!wrong.empty()) {
      findings.problem(edit.pointer, wrong, "a pointer is like /render/photons or /bands/0/samples");
    }
  }
  Description scene;
  detail::read_description(findings, document, scene);
  if (document.is_object()) detail::check_description(findings, scene);
  name_options(findings.problems, edits);
  if (!findings.problems.empty()) throw InputError(std::move(findings.problems));
  scene.warnings = std::move(findings.warnings);
  scene.hash = detail::hash_of(document);
  return scene;
}

Description read_scene(const std::filesystem::path& file, const std::vector<SceneEdit>& edits) {
  return parse_scene(detail::read_text(file), file.parent_path(), edits, file.string());
}

}  // namespace obscura
