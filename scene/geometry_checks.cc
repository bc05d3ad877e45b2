#include "scene/geometry_checks.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "kernels/bsdf/bsdf.h"

namespace skywave {
namespace {

// Fourth powers of lengths (squares of areas) are floats: beyond these sizes of a scene they
// overflow or lose their digits, in kernels and in Embree.
constexpr float kEndOfWorld = 1e9f;
constexpr float kSmallestWorld = 1e-6f;

bool Finite(const glm::vec3& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

void CheckMesh(const Mesh& mesh, std::size_t materials, const std::string& path) {
  const auto fail = [&](const std::string& reason) {
    throw InputError(InputPosition::File(path), fmt::format("mesh '{}': {}", mesh.name, reason));
  };
  const auto check_count = [&](std::size_t count, const char* what) {
    if (count != 0 && count != mesh.positions.size()) {
      fail(fmt::format("{} {} for {} positions", count, what, mesh.positions.size()));
    }
  };
  if (mesh.material >= materials) fail("its material does not exist");
  check_count(mesh.normals.size(), "normals");
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    const glm::vec3& p = mesh.positions[i];
    if (!Finite(p) || glm::length(p) > kEndOfWorld) {
      fail(fmt::format("vertex {} is at ({}, {}, {}); the world ends at {:g}", i, p.x, p.y, p.z,
                       kEndOfWorld));
    }
  }
  check_count(mesh.uvs.size(), "uvs");
  check_count(mesh.second_uvs.size(), "second uvs");
  check_count(mesh.colors.size(), "colours");
  check_count(mesh.alphas.size(), "alphas");
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    for (int corner = 0; corner < 3; ++corner) {
      if (mesh.triangles[i][corner] >= mesh.positions.size()) {
        fail(fmt::format("triangle {} names vertex {} of {}", i, mesh.triangles[i][corner],
                         mesh.positions.size()));
      }
    }
  }
}

void CheckMaterial(const Scene& scene, std::size_t index, const std::string& path) {
  const Material& material = scene.materials[index];
  const auto fail = [&](const std::string& reason) {
    throw InputError(InputPosition::File(path),
                     fmt::format("material '{}': {}", material.name, reason));
  };
  ForEachTexture(material, [&](std::uint32_t texture) {
    if (texture >= scene.textures.size() || scene.textures[texture].image >= scene.images.size()) {
      fail("its texture does not exist");
    }
  });
  if (const auto& mixture = material.mixture) {
    if (mixture->first >= index || mixture->second >= index) fail("it is mixed of later materials");
  }
  if (Bsdfs()[std::size_t(material.bsdf)].tables.measured &&
      (material.measured >= scene.measured.size() ||
       scene.measured[material.measured].rgb.size() != kMeasuredFloats)) {
    fail("its measured BRDF does not exist");
  }
}

void CheckSize(const Bounds& bounds, const std::string& path) {
  const glm::vec3 sides = bounds.high - bounds.low;
  const float size = std::max({sides.x, sides.y, sides.z});
  if (size == 0 || size >= kSmallestWorld) return;  // no ray meets a point
  throw InputError(
      InputPosition::File(path),
      fmt::format("the scene is {} wide, too little for the digits of floats: scale it, "
                  "for example to a width of 1 (the least is {:g})",
                  size, kSmallestWorld));
}

}  // namespace

void CheckMeshes(const Scene& scene, const std::string& path) {
  std::size_t triangles = 0;
  const auto check = [&](const std::vector<Mesh>& meshes) {
    for (const Mesh& mesh : meshes) {
      CheckMesh(mesh, scene.materials.size(), path);
      triangles += mesh.triangles.size();
    }
  };
  check(scene.meshes);
  for (const Object& object : scene.objects) check(object.meshes);
  for (const Bounds& box : InstanceBounds(scene)) {
    if (Finite(box.low) && Finite(box.high) && glm::length(box.low) <= kEndOfWorld &&
        glm::length(box.high) <= kEndOfWorld) {
      continue;
    }
    throw InputError(InputPosition::File(path),
                     fmt::format("an instance reaches from ({}, {}, {}) to ({}, {}, {}); the world "
                                 "ends at {:g}",
                                 box.low.x, box.low.y, box.low.z, box.high.x, box.high.y,
                                 box.high.z, kEndOfWorld));
  }
  if (triangles == 0 && scene.environments.empty()) {
    throw InputError(InputPosition::File(path), "there is no triangle to render");
  }
  if (triangles != 0) CheckSize(SceneBounds(scene, path), path);
  if (scene.materials.size() > kMaterialMask || triangles >= kMaxRecords) {
    throw InputError(InputPosition::File(path),
                     fmt::format("{} materials and {} triangles are more than a scene can hold",
                                 scene.materials.size(), triangles));
  }
}

void CheckMaterials(const Scene& scene, const std::string& path) {
  for (std::size_t i = 0; i < scene.materials.size(); ++i) CheckMaterial(scene, i, path);
}

}  // namespace skywave
