#include "scene/gltf/meshes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/error.h"
#include "scene/gltf/buffers.h"
#include "scene/shapes/mesh.h"
#include "scene/shapes/points.h"

namespace skywave {
namespace {

// Returns the corners of triangles for the primitive's mode. In a strip, every other triangle has
// its winding reversed.
std::vector<glm::uvec3> Connect(const std::vector<std::uint32_t>& indices, int mode) {
  std::vector<glm::uvec3> triangles;
  const std::size_t n = indices.size();
  if (mode == TINYGLTF_MODE_TRIANGLE_STRIP) {
    for (std::size_t i = 2; i < n; ++i) {
      const std::size_t turned = i % 2;
      triangles.emplace_back(indices[i - 2], indices[i - 1 + turned], indices[i - turned]);
    }
  } else if (mode == TINYGLTF_MODE_TRIANGLE_FAN) {
    for (std::size_t i = 2; i < n; ++i) {
      triangles.emplace_back(indices[0], indices[i - 1], indices[i]);
    }
  } else {
    for (std::size_t i = 2; i < n; i += 3) {
      triangles.emplace_back(indices[i - 2], indices[i - 1], indices[i]);
    }
  }
  return triangles;
}

// Returns an attribute of every vertex, or nothing if the primitive lacks it.
std::vector<float> Attribute(const tinygltf::Model& model, const tinygltf::Primitive& primitive,
                             const std::string& name, int components, std::size_t vertices,
                             const std::string& path) {
  const auto found = primitive.attributes.find(name);
  if (found == primitive.attributes.end()) return {};
  std::vector<float> numbers = ReadGltfNumbers(model, found->second, components, path);
  if (vertices != 0 && numbers.size() != vertices * std::size_t(components)) {
    FailGltf(path, fmt::format("{} of a primitive has {} elements for {} vertices", name,
                               numbers.size() / std::size_t(components), vertices));
  }
  return numbers;
}

std::vector<glm::vec3> Vectors(const std::vector<float>& numbers) {
  std::vector<glm::vec3> vectors;
  for (std::size_t i = 0; i + 2 < numbers.size(); i += 3) {
    vectors.emplace_back(numbers[i], numbers[i + 1], numbers[i + 2]);
  }
  return vectors;
}

std::string NameOfUvSet(int set) { return fmt::format("TEXCOORD_{}", set); }

std::vector<glm::vec2> TextureCoordinates(const tinygltf::Model& model,
                                          const tinygltf::Primitive& primitive, int set,
                                          std::size_t vertices, const std::string& path) {
  const std::vector<float> numbers =
      Attribute(model, primitive, NameOfUvSet(set), 2, vertices, path);
  std::vector<glm::vec2> uvs;
  for (std::size_t i = 0; i + 1 < numbers.size(); i += 2) {
    uvs.emplace_back(numbers[i], numbers[i + 1]);
  }
  return uvs;
}

// Reads COLOR_0, linear RGB or RGBA, clamped to [0, 1]. Its alpha counts where the material's does.
void ReadVertexColors(const tinygltf::Model& model, const tinygltf::Primitive& primitive,
                      bool opaque, const std::string& path, Mesh& mesh) {
  const auto found = primitive.attributes.find("COLOR_0");
  if (found == primitive.attributes.end()) return;
  const int accessor = found->second;
  const bool has_alpha = accessor >= 0 && std::size_t(accessor) < model.accessors.size() &&
                         model.accessors[std::size_t(accessor)].type == TINYGLTF_TYPE_VEC4;
  const std::size_t channels = has_alpha ? 4 : 3;
  const std::vector<float> numbers =
      Attribute(model, primitive, "COLOR_0", int(channels), mesh.positions.size(), path);
  bool veiled = false;
  for (std::size_t i = 0; i + channels <= numbers.size(); i += channels) {
    const glm::vec3 color(numbers[i], numbers[i + 1], numbers[i + 2]);
    mesh.colors.push_back(glm::clamp(color, 0.0f, 1.0f));
    if (opaque || !has_alpha) continue;
    mesh.alphas.push_back(std::clamp(numbers[i + 3], 0.0f, 1.0f));
    veiled = veiled || mesh.alphas.back() < 1;
  }
  if (!veiled) mesh.alphas.clear();
}

// Adds the displacements of morph targets, each times its weight, to the elements of an attribute.
// `stride` is the number of components of an element; a displacement has three.
void Morph(const tinygltf::Model& model, const tinygltf::Primitive& primitive,
           const std::string& name, std::size_t stride, const std::vector<double>& weights,
           const std::string& path, std::vector<float>& numbers) {
  const std::size_t targets = std::min(weights.size(), primitive.targets.size());
  for (std::size_t t = 0; t < targets; ++t) {
    const auto found = primitive.targets[t].find(name);
    if (weights[t] == 0 || found == primitive.targets[t].end() || numbers.empty()) continue;
    const std::vector<float> moves = ReadGltfNumbers(model, found->second, 3, path);
    if (moves.size() / 3 != numbers.size() / stride) {
      FailGltf(path, fmt::format("{} of morph target {} has {} elements for {} vertices", name, t,
                                 moves.size() / 3, numbers.size() / stride));
    }
    for (std::size_t i = 0; i < moves.size(); ++i) {
      float& number = numbers[i / 3 * stride + i % 3];
      number = float(number + weights[t] * moves[i]);
      if (!std::isfinite(number)) {
        FailGltf(path, fmt::format("morph target {} moves vertex {} beyond all numbers", t, i / 3));
      }
    }
  }
}

// Returns the points or lines of a primitive whose mode has no triangles.
PointsAndLines Strokes(const std::vector<std::uint32_t>& indices, int mode) {
  if (mode == TINYGLTF_MODE_POINTS) return {.points = indices, .lines = {}};
  PointsAndLines parts;
  const std::size_t step = mode == TINYGLTF_MODE_LINE ? 2 : 1;
  for (std::size_t i = 1; i < indices.size(); i += step) {
    parts.lines.emplace_back(indices[i - 1], indices[i]);
  }
  if (mode == TINYGLTF_MODE_LINE_LOOP && indices.size() > 2) {
    parts.lines.emplace_back(indices.back(), indices.front());
  }
  return parts;
}

int ModeOf(const tinygltf::Primitive& primitive) {
  return primitive.mode < 0 ? TINYGLTF_MODE_TRIANGLES : primitive.mode;
}
bool HasTriangles(int mode) {
  return mode >= TINYGLTF_MODE_TRIANGLES && mode <= TINYGLTF_MODE_TRIANGLE_FAN;
}

Mesh MakeMesh(const tinygltf::Model& model, const tinygltf::Primitive& primitive,
              const std::string& name, const std::vector<double>& weights, const GltfSkin* skin,
              const ReadOptions& options, GltfMaterials& materials, const std::string& path,
              Warnings& warnings) {
  const int mode = ModeOf(primitive);
  const GltfMaterial& material = materials.Of(primitive);
  Mesh mesh;
  mesh.name = name;
  mesh.material = material.row;
  std::vector<float> positions = Attribute(model, primitive, "POSITION", 3, 0, path);
  Morph(model, primitive, "POSITION", 3, weights, path, positions);
  mesh.positions = Vectors(positions);
  const std::size_t vertices = mesh.positions.size();
  std::vector<float> normals = Attribute(model, primitive, "NORMAL", 3, vertices, path);
  Morph(model, primitive, "NORMAL", 3, weights, path, normals);
  mesh.normals = Vectors(normals);
  const auto& sets = material.uv_sets;
  mesh.uvs = TextureCoordinates(model, primitive, sets.empty() ? 0 : sets[0], vertices, path);
  if (sets.size() > 1) {
    mesh.second_uvs = TextureCoordinates(model, primitive, sets[1], vertices, path);
  }
  for (const int set : sets) {
    if (primitive.attributes.contains(NameOfUvSet(set))) continue;
    AddWarningOf(warnings, InputPosition::File(path), "mesh", name,
                 fmt::format("textures use {}, which it lacks: they are looked up at (0, 0)",
                             NameOfUvSet(set)));
  }
  if (material.uses_tangents) {
    std::vector<float> t = Attribute(model, primitive, "TANGENT", 4, vertices, path);
    Morph(model, primitive, "TANGENT", 4, weights, path, t);
    for (std::size_t i = 0; i + 3 < t.size(); i += 4) {
      mesh.tangents.emplace_back(t[i], t[i + 1], t[i + 2], t[i + 3]);
    }
  }
  if (material.grained && mesh.tangents.empty() && mesh.uvs.empty()) {
    AddWarningOf(warnings, InputPosition::File(path), "mesh", name,
                 "no tangents and no texture coordinates: its anisotropy is along +y");
  }
  ReadVertexColors(model, primitive, material.opaque, path, mesh);

  std::vector<std::uint32_t> indices(vertices);
  std::iota(indices.begin(), indices.end(), 0u);
  if (primitive.indices >= 0) indices = ReadGltfIndices(model, primitive.indices, path);
  for (const std::uint32_t index : indices) {
    if (index >= vertices) {
      FailGltf(path, fmt::format("a primitive names vertex {} of {}", index, vertices));
    }
  }
  if (HasTriangles(mode)) mesh.triangles = Connect(indices, mode);
  if (skin != nullptr) SkinGltfMesh(model, primitive, *skin, path, mesh, warnings);
  if (!HasTriangles(mode)) {
    return MakePoints(mesh, Strokes(indices, mode), *options.point_size, options.max_triangles,
                      path);
  }
  if (!mesh.normals.empty()) NormalizeNormals(mesh);
  return mesh;
}

}  // namespace

std::string WhyLeftOut(const tinygltf::Model& model, int mesh, const tinygltf::Primitive& primitive,
                       const ReadOptions& options) {
  const int mode = ModeOf(primitive);
  const std::string& name = model.meshes[std::size_t(mesh)].name;
  if (mode > TINYGLTF_MODE_TRIANGLE_FAN) {
    return fmt::format(
        "mesh {} '{}' has a primitive of the mode {}, which is none of glTF's: left out", mesh,
        name, mode);
  }
  if (!HasTriangles(mode) && !options.point_size) {
    return "points and lines are left out: `point-size` shows them as spheres and tubes";
  }
  if (!primitive.attributes.contains("POSITION")) {
    return fmt::format("mesh {} '{}' has a primitive without positions: left out", mesh, name);
  }
  return {};
}

std::vector<Mesh> MakeGltfMeshes(const tinygltf::Model& model, int mesh,
                                 const std::vector<double>& weights, const GltfSkin* skin,
                                 const ReadOptions& options, GltfMaterials& materials,
                                 const std::string& path, Warnings& warnings) {
  if (std::size_t(mesh) >= model.meshes.size())
    FailGltf(path, fmt::format("there is no mesh {}", mesh));
  const tinygltf::Mesh& from = model.meshes[std::size_t(mesh)];
  const std::string name = from.name.empty() ? fmt::format("mesh {}", mesh) : from.name;
  std::vector<Mesh> meshes;
  for (const tinygltf::Primitive& primitive : from.primitives) {
    const std::string why = WhyLeftOut(model, mesh, primitive, options);
    if (!why.empty()) {
      AddWarning(warnings, InputPosition::File(path), why);
      continue;
    }
    meshes.push_back(
        MakeMesh(model, primitive, name, weights, skin, options, materials, path, warnings));
  }
  return meshes;
}

}  // namespace skywave
