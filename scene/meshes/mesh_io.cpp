#include "scene/meshes/mesh_io.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "octree/base/error.h"
#include "scene/file/scene_table_io.h"
#include "scene/meshes/line_reader_io.h"
#include "scene/meshes/mesh_formats.h"

namespace obscura {
namespace detail {

constexpr std::size_t kMostSlots = std::size_t{1} << 16;

const char* bad_coordinate(const Vec3d& position) noexcept {
  if (!std::isfinite(position.x)) return "x";
  if (!std::isfinite(position.y)) return "y";
  if (!std::isfinite(position.z)) return "z";
  return "";
}

void MeshBuilder::vertex(const Vec3d& position) {
  if (out_.mesh.vertices.size() >= std::numeric_limits<std::uint32_t>::max() - 1) {
    throw InputError(path_.string(), "it has more than 4,294,967,294 vertices", "divide it into several files");
  }
  out_.mesh.vertices.push_back(position);
}

void MeshBuilder::names(const std::vector<std::string>& names) {
  const auto [slot, is_new] = slots_.try_emplace(names, static_cast<std::uint16_t>(slots_.size()));
  slot_ = slot->second;
  if (!is_new) return;
  if (slots_.size() > kMostSlots) {
    throw InputError(path_.string(), fmt::format("it has more than {} groups and materials", kMostSlots),
                     "join some of them");
  }
  out_.slot_names.push_back(names);
}

void MeshBuilder::polygon(std::span<const std::uint32_t> corners) {
  Mesh& mesh = out_.mesh;
  if (slots_.empty()) names({});
  const std::size_t before = mesh.faces.size();
  if (corners.size() == 3) {
    mesh.faces.push_back({corners[0], corners[1], corners[2]});
  } else {
    // Before the first polygon that is no triangle, each triangle has the number of its face.
    if (out_.face_numbers.empty()) {
      for (std::size_t i = 0; i < before; ++i) out_.face_numbers.push_back(static_cast<std::uint32_t>(i));
    }
    triangulate(mesh.vertices, corners, mesh.faces);
  }
  if (mesh.faces.size() - before > 1 || !out_.face_numbers.empty()) {
    out_.face_numbers.resize(mesh.faces.size(), static_cast<std::uint32_t>(polygons_));
  }
  // Nearly all files have one slot: then there is no list of them.
  if (slot_ != 0 && mesh.slots.empty()) mesh.slots.resize(before, 0);
  if (slot_ != 0 || !mesh.slots.empty()) mesh.slots.resize(mesh.faces.size(), slot_);
  ++polygons_;
}

void MeshBuilder::polygon_K(float K) { out_.mesh.face_K.resize(out_.mesh.faces.size(), K); }

MeshFile MeshBuilder::finish() {
  if (out_.mesh.faces.empty()) {
    throw InputError(path_.string(), "it holds no face",
                     "give a mesh of triangles or polygons; lines and points are not surfaces");
  }
  out_.face_count = polygons_;
  out_.vertex_count = out_.mesh.vertices.size();
  return std::move(out_);
}

}  // namespace detail

using detail::LineReader;

MeshFile read_mesh(const std::filesystem::path& file) {
  if (const std::string why = detail::why_unreadable(file); !why.empty()) {
    throw InputError(file.string(), why, "check the name and the permissions");
  }
  std::error_code error;
  if (std::filesystem::file_size(file, error) == 0 && !error) {
    throw InputError(file.string(), "the file is empty", "export or copy it anew");
  }
  const std::string extension = detail::lower_extension(file);
  if (extension == ".obj") return detail::read_obj(file);
  if (extension == ".ply") return detail::read_ply(file);
  if (extension == ".stl") return detail::read_stl(file);
  if (extension == ".gltf" || extension == ".glb") return detail::read_gltf(file);
  throw InputError(file.string(), "the kind of mesh is not known by its extension",
                   "give .obj, .ply, .stl, .gltf or .glb");
}

void read_temperatures(const std::filesystem::path& table, MeshFile& mesh) {
  LineReader reader(table);
  std::string_view line;
  const auto next = [&] {
    while (reader.next_filled(line)) {
      if (line[0] != '#') return true;
    }
    return false;
  };
  if (!next())
    throw InputError(table.string(), "it holds no numbers", "a header line face,K or vertex,K, then a line for each");
  const auto fields = [&](std::string_view& first, std::string_view& second) {
    const std::size_t comma = line.find(',');
    if (comma == std::string_view::npos || line.find(',', comma + 1) != std::string_view::npos) return false;
    first = detail::without_blanks(line.substr(0, comma));
    second = detail::without_blanks(line.substr(comma + 1));
    return true;
  };
  std::string_view kind, K;
  if (!fields(kind, K) || (kind != "face" && kind != "vertex") || K != "K") {
    reader.fail(fmt::format("the header is \"{:.40}\"", line), "the first line has to be face,K or vertex,K");
  }
  const std::string what(kind);
  const bool faces = what == "face";
  const std::uint64_t count = faces ? mesh.face_count : mesh.vertex_count;
  std::vector<float> values(count, std::numeric_limits<float>::quiet_NaN());
  while (next()) {
    std::string_view first, second;
    std::int64_t index = 0;
    double kelvin = 0;
    if (!fields(first, second) || !detail::to_number(first, index) || !detail::to_number(second, kelvin)) {
      reader.fail(fmt::format("\"{:.40}\" is not a number of a {} and its kelvin", line, what),
                  "a line is like 12,300");
    }
    if (!(kelvin >= 0) || !std::isfinite(kelvin))
      reader.fail(fmt::format("{:g} is no temperature", kelvin), "give kelvin of at least 0");
    if (index < 0 || static_cast<std::uint64_t>(index) >= count) {
      reader.fail(fmt::format("there is no {} {}: the mesh has {}", what, index, count),
                  fmt::format("give numbers from 0 to {}, in the order of the mesh file", count - 1));
    }
    float& value = values[static_cast<std::size_t>(index)];
    if (!std::isnan(value)) reader.fail(fmt::format("{} {} is given twice", what, index), "keep one of the lines");
    value = static_cast<float>(kelvin);
  }

  const std::vector<std::uint32_t>& numbers = faces ? mesh.face_numbers : mesh.vertex_numbers;
  mesh.mesh.face_K.clear();
  mesh.mesh.vertex_K.clear();
  std::vector<float>& kelvins = faces ? mesh.mesh.face_K : mesh.mesh.vertex_K;
  if (numbers.empty()) {
    kelvins = std::move(values);
  } else {
    for (const std::uint32_t number : numbers) kelvins.push_back(values[number]);
  }
}

}  // namespace obscura
