// glTF 1.0 and 2.0, text and binary, by assimp: the only file that includes it.
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <fmt/format.h>

#include <algorithm>
#include <assimp/Importer.hpp>

#include "octree/base/error.h"
#include "scene/meshes/mesh_formats.h"

namespace obscura::detail {
namespace {

class NodeWalk {
 public:
  NodeWalk(const aiScene& scene, const std::filesystem::path& file) : scene_(scene), file_(file), builder_(file) {}

  void walk(const aiNode& node, const aiMatrix4x4t<double>& parent) {
    const aiMatrix4x4t<double> to_world = parent * aiMatrix4x4t<double>(node.mTransformation);
    for (unsigned i = 0; i < node.mNumMeshes; ++i) add(*scene_.mMeshes[node.mMeshes[i]], node, to_world);
    for (unsigned i = 0; i < node.mNumChildren; ++i) walk(*node.mChildren[i], to_world);
  }
  MeshFile finish() { return builder_.finish(); }

 private:
  void add(const aiMesh& mesh, const aiNode& node, const aiMatrix4x4t<double>& to_world) {
    const auto first = static_cast<std::uint32_t>(builder_.vertex_count());
    for (unsigned v = 0; v < mesh.mNumVertices; ++v) {
      const aiVector3t<double> p =
          to_world * aiVector3t<double>(mesh.mVertices[v].x, mesh.mVertices[v].y, mesh.mVertices[v].z);
      const Vec3d position(p.x, p.y, p.z);
      if (const char* bad = bad_coordinate(position); *bad) {
        throw InputError(file_.string(),
                         fmt::format("{} of vertex {} of mesh \"{}\" is not finite", bad, v, mesh.mName.C_Str()),
                         "export the mesh anew without NaN and infinity");
      }
      builder_.vertex(position);
    }
    std::vector<std::string> names;
    const auto add_name = [&names](const std::string& name) {
      if (!name.empty() && std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
    };
    add_name(mesh.mName.C_Str());
    add_name(node.mName.C_Str());
    if (mesh.mMaterialIndex < scene_.mNumMaterials) add_name(scene_.mMaterials[mesh.mMaterialIndex]->GetName().C_Str());
    builder_.names(names);
    // A mirrored node turns its triangles inside out.
    const bool mirrored = to_world.Determinant() < 0;
    for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
      const aiFace& face = mesh.mFaces[f];
      if (face.mNumIndices < 3) continue;  // a point or a line
      corners_.clear();
      for (unsigned k = 0; k < face.mNumIndices; ++k) {
        if (face.mIndices[k] >= mesh.mNumVertices) {
          throw InputError(file_.string(),
                           fmt::format("face {} of mesh \"{}\" names vertex {} of {}", f, mesh.mName.C_Str(),
                                       face.mIndices[k], mesh.mNumVertices),
                           "export the mesh anew");
        }
        corners_.push_back(first + face.mIndices[k]);
      }
      if (mirrored) std::reverse(corners_.begin(), corners_.end());
      builder_.polygon(corners_);
    }
  }

  const aiScene& scene_;
  const std::filesystem::path& file_;
  MeshBuilder builder_;
  std::vector<std::uint32_t> corners_;
};

}  // namespace

MeshFile read_gltf(const std::filesystem::path& file) {
  const char* const remedy = "export it anew as glTF 2.0, or as OBJ or PLY";
  Assimp::Importer importer;
  const aiScene* scene = nullptr;
  std::string why;
  try {
    scene = importer.ReadFile(file.string(), 0);
    if (!scene) why = importer.GetErrorString();
  } catch (const std::exception& error) {
    why = error.what();
  }
  if (!scene) throw InputError(file.string(), "it cannot be read as glTF: " + why, remedy);
  if (!scene->mRootNode || scene->mNumMeshes == 0) {
    throw InputError(file.string(), "it holds no mesh", remedy);
  }
  NodeWalk walk(*scene, file);
  walk.walk(*scene->mRootNode, {});
  return walk.finish();
}

}  // namespace obscura::detail
