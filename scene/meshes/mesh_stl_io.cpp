// STL, text and binary. Normals are not read: the winding says where the front is.
#include <fmt/format.h>

#include <array>
#include <bit>
#include <cstring>

#include "octree/base/error.h"
#include "scene/meshes/line_reader_io.h"
#include "scene/meshes/mesh_formats.h"

namespace obscura::detail {
namespace {

constexpr std::size_t kHeader = 84;
constexpr std::size_t kFacet = 50;

void add_facet(MeshBuilder& builder) {
  const auto last = static_cast<std::uint32_t>(builder.vertex_count());
  builder.polygon(std::array<std::uint32_t, 3>{last - 3, last - 2, last - 1});
}

std::uint32_t little_endian(const unsigned char* bytes) {
  return std::uint32_t{bytes[0]} | std::uint32_t{bytes[1]} << 8 | std::uint32_t{bytes[2]} << 16 |
         std::uint32_t{bytes[3]} << 24;
}

MeshFile read_binary(const std::filesystem::path& file, LineReader& reader, std::uint64_t count) {
  MeshBuilder builder(file);
  std::array<unsigned char, kHeader> header;
  reader.read(header.data(), header.size());
  std::array<unsigned char, kFacet> facet;
  for (std::uint64_t i = 0; i < count; ++i) {
    if (reader.read(facet.data(), facet.size()) < facet.size()) {
      throw InputError(file.string(), fmt::format("it ends at facet {} of {}", i, count),
                       "it is cut off: copy or export it anew");
    }
    for (std::size_t v = 0; v < 3; ++v) {
      Vec3d position(0);
      for (std::size_t k = 0; k < 3; ++k) {
        position[static_cast<int>(k)] = std::bit_cast<float>(little_endian(facet.data() + 12 + 12 * v + 4 * k));
      }
      if (const char* bad = bad_coordinate(position); *bad) {
        throw InputError(file.string(), fmt::format("facet {}: {} is not finite", i, bad),
                         "export the mesh anew without NaN and infinity");
      }
      builder.vertex(position);
    }
    add_facet(builder);
  }
  return builder.finish();
}

MeshFile read_text_stl(const std::filesystem::path& file, LineReader& reader) {
  MeshBuilder builder(file);
  std::string_view line;
  const auto expect = [&](std::initializer_list<const char*> words) {
    for (const char* word : words) {
      const std::string_view found = next_word(line);
      if (lower_case(found) != word) {
        reader.fail(fmt::format("\"{}\" is expected, found \"{:.40}\"", word, found), "export the mesh anew");
      }
    }
  };
  const auto next = [&] {
    if (!reader.next_filled(line))
      reader.fail("the file ends inside of a solid", "it is cut off: copy or export it anew");
  };
  while (reader.next_filled(line)) {
    expect({"solid"});
    const std::string name(without_blanks(line));
    builder.names(name.empty() ? std::vector<std::string>{} : std::vector<std::string>{name});
    for (next(); lower_case(line.substr(0, 8)) != "endsolid"; next()) {
      expect({"facet", "normal"});
      next();
      expect({"outer", "loop"});
      for (int v = 0; v < 3; ++v) {
        next();
        expect({"vertex"});
        Vec3d position(0);
        for (int k = 0; k < 3; ++k) {
          const std::string_view word = next_word(line);
          if (!to_number(word, position[k])) {
            reader.fail(
                word.empty() ? "a vertex has three coordinates" : fmt::format("\"{:.40}\" is no coordinate", word),
                "a line is like vertex 1 2 3");
          }
        }
        if (const char* bad = bad_coordinate(position); *bad) {
          reader.fail(fmt::format("{} is not finite", bad), "export the mesh anew without NaN and infinity");
        }
        builder.vertex(position);
      }
      next();
      expect({"endloop"});
      next();
      expect({"endfacet"});
      add_facet(builder);
    }
  }
  return builder.finish();
}

}  // namespace

MeshFile read_stl(const std::filesystem::path& file) {
  // A binary file may begin with "solid" too: its length decides.
  std::array<unsigned char, kHeader> header{};
  const std::size_t bytes = LineReader(file).read(header.data(), header.size());
  const std::uint64_t size = std::filesystem::file_size(file);
  const std::uint64_t count = little_endian(header.data() + 80);
  const bool fits = bytes == kHeader && size == kHeader + kFacet * count;
  LineReader reader(file);
  const std::string begin(reinterpret_cast<const char*>(header.data()), bytes);
  if (!fits && lower_case(without_blanks(begin).substr(0, 5)) == "solid") return read_text_stl(file, reader);
  if (bytes < kHeader) {
    throw InputError(file.string(),
                     "it is neither a text that begins with \"solid\" nor long enough for a binary STL file",
                     "export the mesh anew");
  }
  if (size < kHeader + kFacet * count) {
    throw InputError(file.string(),
                     fmt::format("it announces {} facets, but has room for {}", count, (size - kHeader) / kFacet),
                     "it is cut off: copy or export it anew");
  }
  return read_binary(file, reader, count);
}

}  // namespace obscura::detail
