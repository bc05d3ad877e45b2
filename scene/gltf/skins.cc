#include "scene/gltf/skins.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "scene/gltf/buffers.h"

namespace skywave {
namespace {

constexpr std::size_t kJointsOfSet = 4;

// The joints and weights of all vertices, four of each: one set of attributes.
struct JointSet {
  std::vector<float> joints, weights;
};

std::vector<JointSet> ReadJointSets(const tinygltf::Model& model,
                                    const tinygltf::Primitive& primitive, std::size_t vertices,
                                    const std::string& path) {
  std::vector<JointSet> sets;
  for (;;) {
    const auto joints = primitive.attributes.find(fmt::format("JOINTS_{}", sets.size()));
    const auto weights = primitive.attributes.find(fmt::format("WEIGHTS_{}", sets.size()));
    const auto end = primitive.attributes.end();
    if (joints == end || weights == end) return sets;
    sets.push_back({ReadGltfNumbers(model, joints->second, int(kJointsOfSet), path),
                    ReadGltfNumbers(model, weights->second, int(kJointsOfSet), path)});
    for (const std::vector<float>& numbers : {sets.back().joints, sets.back().weights}) {
      if (numbers.size() != vertices * kJointsOfSet) {
        FailGltf(path, fmt::format("the joints of a primitive have {} elements for {} vertices",
                                   numbers.size() / kJointsOfSet, vertices));
      }
    }
  }
}

// Returns the mean of the joints of a vertex, and the sum of their weights.
glm::dmat4 BlendJoints(const GltfSkin& skin, const std::vector<JointSet>& sets, std::size_t vertex,
                       const std::string& path, double& sum) {
  glm::dmat4 blended(0);
  sum = 0;
  for (const JointSet& set : sets) {
    for (std::size_t i = vertex * kJointsOfSet; i < (vertex + 1) * kJointsOfSet; ++i) {
      const double weight = std::max(double(set.weights[i]), 0.0);
      if (weight == 0) continue;
      const auto joint = std::size_t(std::max(set.joints[i], 0.0f));
      if (joint >= skin.joints.size()) {
        FailGltf(path, fmt::format("vertex {} follows joint {} of {}", vertex, joint,
                                   skin.joints.size()));
      }
      blended += weight * skin.joints[joint];
      sum += weight;
    }
  }
  if (sum == 0) return skin.joints.front();
  return blended / sum;
}

// Returns the matrix of normals up to a positive factor, or a negative one where `m` mirrors. It
// exists for singular matrices as well.
glm::dmat3 CofactorsOf(const glm::dmat3& m) {
  return {glm::cross(m[1], m[2]), glm::cross(m[2], m[0]), glm::cross(m[0], m[1])};
}

}  // namespace

GltfSkin MakeGltfSkin(const tinygltf::Model& model, int index,
                      const std::vector<glm::dmat4>& worlds, const std::string& path) {
  if (std::size_t(index) >= model.skins.size()) {
    FailGltf(path, fmt::format("there is no skin {}", index));
  }
  const tinygltf::Skin& from = model.skins[std::size_t(index)];
  if (from.joints.empty()) FailGltf(path, fmt::format("skin {} has no joints", index));
  std::vector<float> binds;
  if (from.inverseBindMatrices >= 0) {
    binds = ReadGltfNumbers(model, from.inverseBindMatrices, 16, path);
    if (binds.size() < 16 * from.joints.size()) {
      FailGltf(path, fmt::format("skin {} has {} matrices for {} joints", index, binds.size() / 16,
                                 from.joints.size()));
    }
  }
  GltfSkin skin;
  for (std::size_t j = 0; j < from.joints.size(); ++j) {
    const int node = from.joints[j];
    if (node < 0 || std::size_t(node) >= worlds.size()) {
      FailGltf(path, fmt::format("skin {} has node {} for a joint", index, node));
    }
    glm::dmat4 bind(1);
    for (int i = 0; !binds.empty() && i < 16; ++i) {
      bind[i / 4][i % 4] = double(binds[16 * j + std::size_t(i)]);
    }
    skin.joints.push_back(worlds[std::size_t(node)] * bind);
  }
  return skin;
}

void SkinGltfMesh(const tinygltf::Model& model, const tinygltf::Primitive& primitive,
                  const GltfSkin& skin, const std::string& path, Mesh& mesh, Warnings& warnings) {
  const std::size_t vertices = mesh.positions.size();
  const std::vector<JointSet> sets = ReadJointSets(model, primitive, vertices, path);
  constexpr double kRounding = 0.01;  // weights of eight bits add up no better
  bool normalised = false;
  std::vector<bool> mirrors(vertices);
  for (std::size_t i = 0; i < vertices; ++i) {
    double sum = 1;
    const glm::dmat4 blended = BlendJoints(skin, sets, i, path, sum);
    normalised = normalised || std::abs(sum - 1) > kRounding;
    const glm::dmat3 linear(blended), cofactors = CofactorsOf(linear);
    mirrors[i] = glm::dot(linear[0], cofactors[0]) < 0;
    const glm::dmat3 of_normals = mirrors[i] ? -cofactors : cofactors;
    mesh.positions[i] = glm::vec3(blended * glm::dvec4(glm::dvec3(mesh.positions[i]), 1));
    const glm::vec3& p = mesh.positions[i];
    if (!std::isfinite(p.x + p.y + p.z)) {
      FailGltf(path, fmt::format("a skin moves vertex {} beyond all numbers", i));
    }
    if (!mesh.normals.empty()) {
      const glm::dvec3 normal = of_normals * glm::dvec3(mesh.normals[i]);
      if (glm::length(normal) > 0) mesh.normals[i] = glm::vec3(glm::normalize(normal));
    }
    if (!mesh.tangents.empty()) {
      glm::vec4& tangent = mesh.tangents[i];
      const glm::dvec3 along = linear * glm::dvec3(tangent);
      if (glm::length(along) > 0) tangent = glm::vec4(glm::normalize(along), tangent.w);
      if (mirrors[i]) tangent.w = -tangent.w;
    }
  }
  for (glm::uvec3& corners : mesh.triangles) {
    if (mirrors[corners.x]) std::swap(corners.y, corners.z);
  }
  if (normalised) {
    AddWarning(warnings, InputPosition::File(path),
               fmt::format("mesh '{}': the weights of its joints do not add up to 1: normalised",
                           mesh.name));
  }
}

}  // namespace skywave
