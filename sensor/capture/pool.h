// Neighbours that lend one another what each knows badly.
#pragma once

#include <algorithm>

namespace obscura::detail {

/// Mean over a place and its eight neighbours in a grid, the place itself four times, those beside it twice.
/// @param counts whether a place takes part; @param value of a place. @pre the place itself takes part
template <class Counts, class Value>
double pooled(int x, int y, int columns, int rows, const Counts& counts, const Value& value) {
  double sum = 0, weights = 0;
  for (int v = std::max(0, y - 1); v <= std::min(rows - 1, y + 1); ++v) {
    for (int u = std::max(0, x - 1); u <= std::min(columns - 1, x + 1); ++u) {
      if (!counts(u, v)) continue;
      const double weight = (u == x ? 2.0 : 1.0) * (v == y ? 2.0 : 1.0);
      sum += weight * value(u, v);
      weights += weight;
    }
  }
  return sum / weights;
}

}  // namespace obscura::detail
