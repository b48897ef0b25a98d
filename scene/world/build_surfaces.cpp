#include "scene/world/build_surfaces.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>

#include "octree/base/error.h"
#include "scene/file/scene_json.h"
#include "scene/file/scene_table_io.h"
#include "scene/file/scene_words.h"
#include "scene/meshes/mesh_io.h"
#include "scene/meshes/mesh_shapes.h"
#include "scene/meshes/terrain_io.h"
#include "scene/world/per_interval.h"

namespace obscura {

using namespace detail;

namespace {

/// Every mesh is read once, whoever names it.
class MeshCache {
 public:
  std::shared_ptr<const MeshFile> get(const std::filesystem::path& mesh, const std::filesystem::path& temperature) {
    std::shared_ptr<const MeshFile>& entry = files_[{mesh, temperature}];
    if (entry) return entry;
    if (temperature.empty()) {
      const std::string extension = lower_extension(mesh);
      const bool terrain = extension == ".asc" || extension == ".asc.gz";
      entry = std::make_shared<const MeshFile>(terrain ? read_terrain(mesh) : read_mesh(mesh));
      return entry;
    }
    MeshFile warm = *get(mesh, {});
    read_temperatures(temperature, warm);
    return files_[{mesh, temperature}] = std::make_shared<const MeshFile>(std::move(warm));
  }

 private:
  std::map<std::pair<std::filesystem::path, std::filesystem::path>, std::shared_ptr<const MeshFile>> files_;
};

Material make_material(const std::vector<Band>& bands, const MaterialDescription& description) {
  return {optical(bands, description.emissivity),
          description.specular,
          description.roughness,
          description.permeable,
          description.angle_deg,
          description.angle_factor};
}

/// What the scene says of a slot; nothing where it does not name it.
const GroupDescription* group_of(const ObjectDescription& description, const std::vector<std::string>& names) {
  for (const std::string& name : names) {
    if (const auto group = description.groups.find(name); group != description.groups.end()) return &group->second;
  }
  return nullptr;
}

void require_groups(const ObjectDescription& description, const std::string& pointer, const MeshFile& file,
                    std::vector<Problem>& problems) {
  std::set<std::string> known;
  for (const std::vector<std::string>& names : file.slot_names) known.insert(names.begin(), names.end());
  for (const auto& [name, ignored] : description.groups) {
    if (known.count(name)) continue;
    problems.push_back({pointer_to(pointer_to(pointer, "groups"), name),
                        fmt::format("{} has no group or material \"{}\"", description.mesh.string(), name),
                        known.empty() ? "it names no part: leave \"groups\" out"
                                      : suggest(name, std::vector<std::string>(known.begin(), known.end()))});
  }
}

/// Per interval, what stands in for Planck's law; empty where nothing does.
std::vector<std::optional<double>> radiance_of(const Description& scene, const std::vector<Band>& bands,
                                               const ObjectDescription& description, const Object& object) {
  const bool has_kelvin =
      description.has_kelvin() || (object.mesh && (!object.mesh->face_K.empty() || !object.mesh->vertex_K.empty()));
  std::vector<std::optional<double>> radiance = per_interval(bands, [&](std::size_t b, int j) -> std::optional<double> {
    switch (emitter(scene, scene.bands[b], has_kelvin, description.radiance.has_value())) {
      case Emitter::planck:
        return std::nullopt;
      case Emitter::radiance:
        return bands[b].integrate(j, *description.radiance);
      case Emitter::none:
        break;
    }
    return 0.0;
  });
  const bool planck = std::all_of(radiance.begin(), radiance.end(), [](const auto& r) { return !r.has_value(); });
  if (planck) radiance.clear();
  return radiance;
}

}  // namespace

void build_surfaces(const Description& scene, WorldContents& contents) {
  if (scene.objects.empty()) return;
  std::map<std::string, int> material_index;
  contents.materials = {make_material(contents.bands, {})};
  for (const auto& [name, material] : scene.materials) {
    material_index[name] = static_cast<int>(contents.materials.size());
    contents.materials.push_back(make_material(contents.bands, material));
  }

  MeshCache cache;
  std::vector<Problem> problems;
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    const ObjectDescription& description = scene.objects[i];
    Object object;
    object.name = description.name;
    object.local_to_world =
        placement(description.place.translate_m, kDegree * description.place.rotate_deg, description.place.scale);
    object.double_sided = description.double_sided;
    const int material = description.material.empty() ? 0 : material_index.at(description.material);
    object.materials = {material};
    object.K = {description.K.value_or(0)};
    switch (description.kind) {
      case SurfaceKind::plane:
        object.mesh = std::make_shared<const Mesh>(plane_mesh(description.plane_m));
        break;
      case SurfaceKind::box:
        object.mesh = std::make_shared<const Mesh>(box_mesh(description.box_m));
        break;
      case SurfaceKind::sphere:
        object.radius = description.radius_m;
        break;
      case SurfaceKind::mesh: {
        std::shared_ptr<const MeshFile> file;
        try {
          file = cache.get(description.mesh, description.temperature);
        } catch (const InputError& error) {
          problems.insert(problems.end(), error.problems().begin(), error.problems().end());
          continue;
        }
        require_groups(description, pointer_to(pointer_to("", "objects"), i), *file, problems);
        object.mesh = std::shared_ptr<const Mesh>(file, &file->mesh);
        object.materials.clear();
        object.K.clear();
        for (const std::vector<std::string>& names : file->slot_names) {
          const GroupDescription* group = group_of(description, names);
          object.materials.push_back(group && group->material ? material_index.at(*group->material) : material);
          object.K.push_back(group && group->K ? *group->K : description.K.value_or(0));
        }
        break;
      }
    }
    object.radiance = radiance_of(scene, contents.bands, description, object);
    contents.objects.push_back(std::move(object));
  }
  if (!problems.empty()) throw InputError(std::move(problems));
}

}  // namespace obscura
