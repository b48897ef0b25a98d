// A small picture of 8-bit colours that previews are drawn on, with text.
#pragma once

#include <string_view>
#include <vector>

#include "sensor/picture/colours.h"

namespace obscura {

/// Red green blue, row by row from the top left. Drawing outside is cut off.
class Raster {
 public:
  Raster(int columns, int rows, Colour background = {0, 0, 0});

  int columns() const noexcept { return columns_; }
  int rows() const noexcept { return rows_; }
  const std::vector<std::uint8_t>& rgb() const noexcept { return rgb_; }
  /// @pre inside
  Colour at(int x, int y) const noexcept;

  void set(int x, int y, Colour colour) noexcept;
  void fill(int x, int y, int columns, int rows, Colour colour) noexcept;
  /// Copies another picture with its top left corner at (x, y).
  void paste(const Raster& other, int x, int y) noexcept;

  /// ASCII in letters of 5 x 7 dots of `dot` pixels each; (x, y) is the top left corner.
  void text(int x, int y, std::string_view text, Colour colour, int dot = 1) noexcept;
  static int text_width(std::string_view text, int dot = 1) noexcept {
    return text.empty() ? 0 : (6 * static_cast<int>(text.size()) - 1) * dot;
  }

 private:
  int columns_;
  int rows_;
  std::vector<std::uint8_t> rgb_;
};

}  // namespace obscura
