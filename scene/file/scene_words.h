// Finds the word that somebody meant.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace obscura::detail {

struct WordMatch {
  std::string word;    ///< empty where there are no candidates
  bool close = false;  ///< near enough to ask "did you mean"
};

/// The candidate that is most likely meant: a missing unit suffix or another case counts as nearly equal,
/// else the fewest edits (insertions, deletions, replacements, swaps of neighbours). Ties: the first.
WordMatch nearest_word(std::string_view word, const std::vector<std::string>& candidates);

/// `did you mean "fov_deg"?`, or the nearest and all valid words where none is close.
std::string suggest(std::string_view word, const std::vector<std::string>& candidates);

}  // namespace obscura::detail
