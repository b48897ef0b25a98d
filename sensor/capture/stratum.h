// Parts of a pixel.
#pragma once

namespace obscura {

/// A rectangle within a pixel, in pixels from its top left corner.
struct Stratum {
  double x_min, y_min, width, height;

  double area() const noexcept { return width * height; }
};

/// Cells of equal area that tile the unit square, as near to squares as `count` allows: rows of
/// equally many cells, or of one more (7 is rows of 2, 3 and 2). One jittered place in each makes an
/// unbiased stratified sample of any size.
Stratum stratum(int index, int count) noexcept;

}  // namespace obscura
