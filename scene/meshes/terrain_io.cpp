#include "scene/meshes/terrain_io.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <optional>

#include "octree/base/error.h"
#include "scene/meshes/line_reader_io.h"

namespace obscura {
namespace {

using detail::LineReader;

constexpr std::uint32_t kNoVertex = std::numeric_limits<std::uint32_t>::max();

struct GridHeader {
  std::size_t columns = 0, rows = 0;
  double west = 0, south = 0;  // centre of the south-western cell
  double dx = 0, dy = 0;
  std::optional<double> no_data;
};

// Reads the header. @returns the first line of heights
GridHeader read_header(LineReader& reader, std::string_view& line) {
  GridHeader header;
  std::optional<double> columns, rows, corner_x, corner_y, center_x, center_y, dx, dy;
  bool more = false;
  while ((more = reader.next_filled(line))) {
    std::string_view rest = line;
    const std::string key = detail::lower_case(detail::next_word(rest));
    double value = 0;
    if (detail::to_number(key, value)) break;
    std::optional<double>* place = key == "ncols"                     ? &columns
                                   : key == "nrows"                   ? &rows
                                   : key == "xllcorner"               ? &corner_x
                                   : key == "yllcorner"               ? &corner_y
                                   : key == "xllcenter"               ? &center_x
                                   : key == "yllcenter"               ? &center_y
                                   : key == "cellsize" || key == "dx" ? &dx
                                   : key == "dy"                      ? &dy
                                   : key == "nodata_value"            ? &header.no_data
                                                                      : nullptr;
    if (!place)
      reader.fail(fmt::format("\"{:.40}\" is no key of an ESRI ASCII grid", line),
                  "its header has ncols, nrows, xllcorner, yllcorner, cellsize and NODATA_value");
    if (!detail::to_number(detail::next_word(rest), value) || !detail::without_blanks(rest).empty()) {
      reader.fail(fmt::format("{} is not followed by one number", key), "a line is like ncols 100");
    }
    *place = value;
  }
  const auto need = [&](bool good, const char* problem) {
    if (!good)
      reader.fail(fmt::format("the header before this line {}", problem),
                  "it has to hold ncols, nrows, xllcorner, yllcorner and cellsize");
  };
  const auto size = [&](const std::optional<double>& n, const char* problem) {
    need(n && *n >= 2 && *n == std::floor(*n) && *n <= 4e9, problem);
    return static_cast<std::size_t>(*n);
  };
  header.columns = size(columns, "has no ncols of at least 2");
  header.rows = size(rows, "has no nrows of at least 2");
  need(header.columns < kNoVertex / header.rows, "announces more than 4,294,967,295 cells");
  need(dx && *dx > 0 && std::isfinite(*dx) && (!dy || (*dy > 0 && std::isfinite(*dy))), "has no cellsize above 0");
  header.dx = *dx;
  header.dy = dy.value_or(*dx);
  need((corner_x || center_x) && std::isfinite((corner_x ? corner_x : center_x).value()),
       "has no xllcorner or xllcenter");
  need((corner_y || center_y) && std::isfinite((corner_y ? corner_y : center_y).value()),
       "has no yllcorner or yllcenter");
  header.west = center_x ? *center_x : *corner_x + 0.5 * header.dx;
  header.south = center_y ? *center_y : *corner_y + 0.5 * header.dy;
  if (!more) reader.fail("the file ends here: there are no heights", "it is cut off: copy or export it anew");
  return header;
}

/// Vertices of one row: kNoVertex where there is no height.
void read_row(LineReader& reader, std::string_view& line, const GridHeader& header, std::size_t row, MeshFile& out,
              std::vector<std::uint32_t>& vertices) {
  for (std::size_t column = 0; column < header.columns; ++column) {
    std::string_view word = detail::next_word(line);
    while (word.empty()) {
      if (!reader.next_filled(line)) {
        reader.fail(fmt::format("the file ends in row {} of {}", row + 1, header.rows),
                    "it is cut off: copy or export it anew");
      }
      word = detail::next_word(line);
    }
    double height = 0;
    if (!detail::to_number(word, height))
      reader.fail(fmt::format("\"{:.40}\" is no height", word), "heights are numbers with a decimal point");
    const bool absent =
        header.no_data && (height == *header.no_data || (std::isnan(height) && std::isnan(*header.no_data)));
    vertices[column] = absent ? kNoVertex : static_cast<std::uint32_t>(out.mesh.vertices.size());
    if (absent) continue;
    if (!std::isfinite(height))
      reader.fail(fmt::format("the height {:g} is not finite", height), "give a NODATA_value where there is no height");
    out.mesh.vertices.emplace_back(header.west + static_cast<double>(column) * header.dx,
                                   header.south + static_cast<double>(header.rows - 1 - row) * header.dy, height);
    out.vertex_numbers.push_back(static_cast<std::uint32_t>(row * header.columns + column));
  }
}

/// Triangles of the squares between two rows.
void join_rows(const std::vector<std::uint32_t>& north, const std::vector<std::uint32_t>& south,
               std::uint32_t first_face, MeshFile& out) {
  const auto add = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c, std::size_t square) {
    if (a == kNoVertex || b == kNoVertex || c == kNoVertex) return false;
    out.mesh.faces.push_back({a, b, c});
    out.face_numbers.push_back(first_face + static_cast<std::uint32_t>(square));
    return true;
  };
  for (std::size_t i = 0; i + 1 < north.size(); ++i) {
    const std::uint32_t nw = north[i], ne = north[i + 1], sw = south[i], se = south[i + 1];
    const bool lower = add(sw, se, ne, i), upper = add(sw, ne, nw, i);
    // One corner has no height: the triangle of the other three.
    if (!lower && !upper && !add(sw, se, nw, i)) add(se, ne, nw, i);
  }
}

}  // namespace

MeshFile read_terrain(const std::filesystem::path& file) {
  LineReader reader(file);
  std::string_view line;
  const GridHeader header = read_header(reader, line);
  MeshFile out;
  out.slot_names.resize(1);
  out.vertex_count = std::uint64_t{header.columns} * header.rows;
  out.face_count = std::uint64_t{header.columns - 1} * (header.rows - 1);
  std::vector<std::uint32_t> north(header.columns), south(header.columns);
  for (std::size_t row = 0; row < header.rows; ++row) {
    std::swap(north, south);
    read_row(reader, line, header, row, out, south);
    if (row > 0) join_rows(north, south, static_cast<std::uint32_t>((row - 1) * (header.columns - 1)), out);
  }
  if (!detail::without_blanks(line).empty() || reader.next_filled(line)) {
    reader.fail("there are more heights than the header announces", "correct ncols and nrows or export the grid anew");
  }
  if (out.mesh.faces.empty()) {
    throw InputError(file.string(), "it has no three heights side by side", "check its NODATA_value");
  }
  return out;
}

}  // namespace obscura
