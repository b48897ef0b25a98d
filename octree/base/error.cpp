#include "octree/base/error.h"

#include <utility>

namespace obscura {
namespace {

std::string join(const std::vector<Problem>& problems) {
  std::string text;
  for (const Problem& problem : problems) {
    if (!text.empty()) text += '\n';
    text += problem.text();
  }
  return text;
}

}  // namespace

std::string Problem::text() const {
  std::string result = where.empty() ? problem : where + ": " + problem;
  if (!hint.empty()) result += " (" + hint + ")";
  return result;
}

InputError::InputError(std::vector<Problem> problems)
    : std::runtime_error(join(problems)), problems_(std::move(problems)) {}

InputError::InputError(std::string where, std::string problem, std::string hint)
    : InputError(std::vector<Problem>{{std::move(where), std::move(problem), std::move(hint)}}) {}

ResourceError::ResourceError(std::string where, std::string problem, std::string hint)
    : std::runtime_error(Problem{std::move(where), std::move(problem), std::move(hint)}.text()) {}

NumericalError::NumericalError(std::string where, std::string problem, std::string hint)
    : std::runtime_error(Problem{std::move(where), std::move(problem), std::move(hint)}.text()) {}

}  // namespace obscura
