#include "scene/file/scene_words.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <limits>

namespace obscura::detail {
namespace {

std::string lower(std::string_view text) {
  std::string result(text);
  for (char& c : result) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return result;
}

// Optimal string alignment distance.
double edits(const std::string& a, const std::string& b) {
  std::vector<std::vector<std::size_t>> d(a.size() + 1, std::vector<std::size_t>(b.size() + 1));
  for (std::size_t i = 0; i <= a.size(); ++i) d[i][0] = i;
  for (std::size_t j = 0; j <= b.size(); ++j) d[0][j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replace = d[i - 1][j - 1] + (a[i - 1] == b[j - 1] ? 0u : 1u);
      d[i][j] = std::min({d[i - 1][j] + 1, d[i][j - 1] + 1, replace});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1]) {
        d[i][j] = std::min(d[i][j], d[i - 2][j - 2] + 1);
      }
    }
  }
  return static_cast<double>(d[a.size()][b.size()]);
}

// "fov" of "fov_deg": the name without what follows its first underscore.
std::string_view stem(std::string_view word) { return word.substr(0, word.find('_')); }

double distance(const std::string& word, const std::string& candidate) {
  if (candidate.rfind(word + "_", 0) == 0) return 0.1;  // its unit is missing
  if (word.size() > 2 && stem(word) == stem(candidate) && word.find('_') != std::string::npos &&
      candidate.find('_') != std::string::npos) {
    return std::min(0.5, edits(word, candidate));  // another unit
  }
  if (word.rfind(candidate + "_", 0) == 0) return 0.6;  // a unit too many
  return edits(word, candidate);
}

}  // namespace

WordMatch nearest_word(std::string_view word, const std::vector<std::string>& candidates) {
  WordMatch nearest;
  double best = std::numeric_limits<double>::infinity();
  const std::string wanted = lower(word.substr(0, 64));
  for (const std::string& candidate : candidates) {
    const double d = distance(wanted, lower(candidate));
    if (d < best) {
      best = d;
      nearest = {candidate, d <= std::max(1.0, static_cast<double>(wanted.size()) * 0.4)};
    }
  }
  return nearest;
}

std::string suggest(std::string_view word, const std::vector<std::string>& candidates) {
  const WordMatch nearest = nearest_word(word, candidates);
  if (nearest.word.empty()) return "nothing is allowed here";
  if (nearest.close) return fmt::format("did you mean \"{}\"?", nearest.word);
  return fmt::format("the nearest is \"{}\"; allowed: {}", nearest.word, fmt::join(candidates, ", "));
}

}  // namespace obscura::detail
