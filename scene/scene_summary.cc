#include "scene/scene_summary.h"

#include "kernels/bsdf/bsdf.h"

namespace skywave {

SceneSummary Summarize(const Scene& scene) {
  SceneSummary summary;
  summary.triangles_of_material.assign(scene.materials.size(), 0);
  const auto bytes = [](const auto& values) { return values.size() * sizeof values[0]; };
  const auto add = [&](const Mesh& mesh) {
    ++summary.meshes;
    summary.triangles += mesh.triangles.size();
    summary.vertices += mesh.positions.size();
    summary.meshes_with_normals += !mesh.normals.empty();
    summary.meshes_with_uvs += !mesh.uvs.empty();
    summary.mesh_bytes += bytes(mesh.positions) + bytes(mesh.normals) + bytes(mesh.uvs) +
                          bytes(mesh.second_uvs) + bytes(mesh.triangles);
    summary.triangles_of_material.at(mesh.material) += mesh.triangles.size();
  };
  for (const Mesh& mesh : scene.meshes) add(mesh);
  summary.triangles_seen = summary.triangles;
  std::vector<std::size_t> of_objects;
  for (const Object& object : scene.objects) {
    const std::size_t before = summary.triangles;
    for (const Mesh& mesh : object.meshes) add(mesh);
    of_objects.push_back(summary.triangles - before);
  }
  summary.objects = scene.objects.size(), summary.instances = scene.instances.size();
  for (const Instance& instance : scene.instances) {
    summary.triangles_seen += of_objects[instance.object];
  }
  if (summary.triangles > 0) summary.bounds = SceneBounds(scene, "");
  return summary;
}

std::string_view ToString(BsdfKind kind) { return Bsdfs()[std::size_t(kind)].name; }

}  // namespace skywave
