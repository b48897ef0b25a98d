#include "sensor/capture/stratum.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace obscura {

Stratum stratum(int index, int count) noexcept {
  // Row r holds cells [r * count / rows, (r + 1) * count / rows): its height is its share of them.
  const int rows = std::max(1, static_cast<int>(std::lround(std::sqrt(static_cast<double>(count)))));
  const auto first_of = [&](int row) { return static_cast<int>(static_cast<std::int64_t>(row) * count / rows); };
  int row = static_cast<int>(static_cast<std::int64_t>(index) * rows / count);
  while (first_of(row + 1) <= index) ++row;
  while (first_of(row) > index) --row;

  const int first = first_of(row);
  const int cells = first_of(row + 1) - first;
  Stratum cell;
  cell.width = 1.0 / cells;
  cell.height = static_cast<double>(cells) / count;
  // There and back, so that successive cells touch.
  cell.x_min = (row % 2 ? first + cells - 1 - index : index - first) * cell.width;
  cell.y_min = static_cast<double>(first) / count;
  return cell;
}

}  // namespace obscura
