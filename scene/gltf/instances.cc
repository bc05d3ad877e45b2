#include "scene/gltf/instances.h"

#include <fmt/format.h>

#include <algorithm>
#include <glm/gtc/quaternion.hpp>

#include "scene/gltf/buffers.h"
#include "scene/instances.h"

namespace skywave {
namespace {

constexpr const char* kExtension = "EXT_mesh_gpu_instancing";

// The numbers of one attribute of all instances, or none.
struct Column {
  std::vector<float> numbers;
  std::size_t components;
  std::size_t rows() const { return numbers.size() / components; }
};

Column ReadColumn(const tinygltf::Model& model, const tinygltf::Value& attributes,
                  const std::string& name, int components, const std::string& path) {
  Column column = {.numbers = {}, .components = std::size_t(components)};
  if (!attributes.Has(name)) return column;
  const tinygltf::Value& accessor = attributes.Get(name);
  if (!accessor.IsInt()) FailGltf(path, fmt::format("{}: {} is not an accessor", kExtension, name));
  column.numbers = ReadGltfNumbers(model, accessor.GetNumberAsInt(), components, path);
  if (column.rows() > kMaxInstances) {
    FailGltf(path, fmt::format("has more than {} instances", kMaxInstances));
  }
  return column;
}

}  // namespace

bool HasGltfInstances(const tinygltf::Node& node) { return node.extensions.count(kExtension) > 0; }

std::vector<glm::dmat4> GltfInstances(const tinygltf::Model& model, const tinygltf::Node& node,
                                      const std::string& path) {
  if (!HasGltfInstances(node)) return {glm::dmat4(1)};
  const tinygltf::Value& extension = node.extensions.at(kExtension);
  if (!extension.IsObject() || !extension.Has("attributes") ||
      !extension.Get("attributes").IsObject()) {
    FailGltf(path, fmt::format("{} has no attributes", kExtension));
  }
  const tinygltf::Value& attributes = extension.Get("attributes");
  const Column moves = ReadColumn(model, attributes, "TRANSLATION", 3, path),
               turns = ReadColumn(model, attributes, "ROTATION", 4, path),
               scales = ReadColumn(model, attributes, "SCALE", 3, path);
  const std::size_t rows = std::max({moves.rows(), turns.rows(), scales.rows()});
  for (const Column* const column : {&moves, &turns, &scales}) {
    if (column->rows() != 0 && column->rows() != rows) {
      FailGltf(path, fmt::format("{} has attributes of {} and of {} instances", kExtension,
                                 column->rows(), rows));
    }
  }
  std::vector<glm::dmat4> places(rows, glm::dmat4(1));
  for (std::size_t i = 0; i < rows; ++i) {
    glm::dmat4& place = places[i];
    if (turns.rows() != 0) {
      const float* const r = &turns.numbers[4 * i];
      const glm::dquat turn(r[3], r[0], r[1], r[2]);
      if (glm::length(turn) > 0) place = glm::mat4_cast(glm::normalize(turn));
    }
    for (int c = 0; c < 3; ++c) {
      const std::size_t at = 3 * i + std::size_t(c);
      if (scales.rows() != 0) place[c] *= scales.numbers[at];
      if (moves.rows() != 0) place[3][c] = moves.numbers[at];
    }
  }
  return places;
}

}  // namespace skywave
