// A scene in a glTF file, which tests change and read.
#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>
#include <string>

#include "base/error.h"
#include "scene/geometry.h"
#include "scene/gltf/reader.h"
#include "tests/support/temporary_folder.h"

namespace skywave {

using nlohmann::json;

// The buffer of a triangle with normals and coordinates: positions, normals, uvs, indices.
inline std::string Buffer() {
  const float numbers[] = {0, 0, 0, 2, 0, 0, 0, 2, 0, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1};
  const std::uint16_t indices[] = {0, 1, 2, 0};
  std::string bytes(sizeof numbers + sizeof indices, '\0');
  std::memcpy(bytes.data(), numbers, sizeof numbers);
  std::memcpy(bytes.data() + sizeof numbers, indices, sizeof indices);
  return bytes;
}

inline json View(int offset, int length) {
  return {{"buffer", 0}, {"byteOffset", offset}, {"byteLength", length}};
}

inline json Document() {
  return {{"asset", {{"version", "2.0"}}},
          {"scene", 0},
          {"scenes", {{{"nodes", {0}}}}},
          {"nodes",
           {{{"children", {1, 2}}, {"translation", {1, 0, 0}}},
            {{"mesh", 0}, {"scale", {2, 2, 2}}},
            {{"mesh", 0}, {"rotation", {0, 0, 0.7071067811865476, 0.7071067811865476}}}}},
          {"meshes",
           {{{"name", "triangle"},
             {"primitives",
              {{{"attributes", {{"POSITION", 0}, {"NORMAL", 1}, {"TEXCOORD_0", 2}}},
                {"indices", 3},
                {"material", 0}}}}}}},
          {"materials",
           {{{"name", "paint"},
             {"pbrMetallicRoughness",
              {{"baseColorFactor", {0.5, 0.25, 1, 1}},
               {"metallicFactor", 0.25},
               {"roughnessFactor", 0.5}}}}}},
          {"accessors",
           {{{"bufferView", 0}, {"componentType", 5126}, {"count", 3}, {"type", "VEC3"}},
            {{"bufferView", 1}, {"componentType", 5126}, {"count", 3}, {"type", "VEC3"}},
            {{"bufferView", 2}, {"componentType", 5126}, {"count", 3}, {"type", "VEC2"}},
            {{"bufferView", 3}, {"componentType", 5123}, {"count", 3}, {"type", "SCALAR"}}}},
          {"bufferViews", {View(0, 36), View(36, 36), View(72, 24), View(96, 6)}},
          {"buffers", {{{"uri", "a.bin"}, {"byteLength", 104}}}}};
}

// Returns the same as one binary file.
inline std::string Glb(json document, std::string bytes) {
  document["buffers"][0].erase("uri");
  document["buffers"][0]["byteLength"] = bytes.size();
  std::string text = document.dump();
  text.resize((text.size() + 3) / 4 * 4, ' ');
  bytes.resize((bytes.size() + 3) / 4 * 4, '\0');
  std::string file = "glTF";
  const auto add = [&](std::size_t number) {
    for (int i = 0; i < 4; ++i) file.push_back(char(number >> 8 * i));
  };
  add(2), add(12 + 8 + text.size() + 8 + bytes.size());
  add(text.size()), file += "JSON" + text;
  add(bytes.size()), file += std::string("BIN\0", 4) + bytes;
  return file;
}

class Gltf : public testing::Test {
 protected:
  Gltf() { folder_.Write("a.bin", Buffer()); }
  Scene Read(const json& document) { return ReadGltf(folder_.Write("a.gltf", document.dump())); }
  // Returns the reader's message, or "" if it accepts the file. Accepted files also become
  // geometry.
  std::string ErrorOfFile(const std::string& path) {
    try {
      const Scene scene = ReadGltf(path);
      if (!scene.meshes.empty()) Geometry(scene, path, 1);
      return "";
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find(path), std::string::npos) << error.what();
      EXPECT_EQ(error.exit_code(), kExitBadInput) << error.what();
      return error.what();
    }
  }
  std::string ErrorOf(const json& document) {
    return ErrorOfFile(folder_.Write("a.gltf", document.dump()));
  }
  TemporaryFolder folder_;
};

// Returns the material of the first mesh.
inline const Material& Body(const Scene& scene) {
  return scene.materials.at(scene.meshes.at(0).material);
}

inline void ExpectNear(const glm::vec3& a, const glm::vec3& b) {
  EXPECT_LT(glm::length(a - b), 1e-5) << a.x << " " << a.y << " " << a.z;
}

}  // namespace skywave
