// A glTF file that a test puts together: JSON, and a buffer inside it.
#pragma once

#include <cstring>
#include <nlohmann/json.hpp>
#include <string>
#include <type_traits>
#include <vector>

namespace skywave {

struct GltfDocument {
  nlohmann::json json = {{"asset", {{"version", "2.0"}}}, {"scene", 0}};
  std::string bytes;

  // Returns the number of a new accessor of `type`, such as "VEC3", to these numbers.
  template <class Number>
  int Add(const std::vector<Number>& numbers, const std::string& type, bool normalized = false) {
    const std::size_t components = type == "SCALAR" ? 1
                                   : type == "MAT4" ? 16
                                                    : std::size_t(type.back() - '0');
    json["accessors"].push_back({{"bufferView", AddView(numbers)},
                                 {"componentType", ComponentType<Number>()},
                                 {"normalized", normalized},
                                 {"count", numbers.size() / components},
                                 {"type", type}});
    return int(json["accessors"].size()) - 1;
  }

  // Returns the number of a new buffer view of these numbers.
  template <class Number>
  int AddView(const std::vector<Number>& numbers) {
    bytes.resize((bytes.size() + 3) / 4 * 4, '\0');
    const std::size_t offset = bytes.size(), length = numbers.size() * sizeof(Number);
    bytes.resize(offset + length);
    std::memcpy(bytes.data() + offset, numbers.data(), length);
    json["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", offset}, {"byteLength", length}});
    return int(json["bufferViews"].size()) - 1;
  }

  // Adds a channel of animation `animation`, which is made if it is the next one.
  void Animate(std::size_t animation, int node, const std::string& property, int times, int values,
               const std::string& interpolation = "LINEAR") {
    nlohmann::json& target = json["animations"][animation];
    const std::size_t sampler = target["samplers"].size();
    target["samplers"].push_back(
        {{"input", times}, {"output", values}, {"interpolation", interpolation}});
    target["channels"].push_back(
        {{"sampler", sampler}, {"target", {{"node", node}, {"path", property}}}});
  }

  std::string text() const {
    nlohmann::json whole = json;
    whole["buffers"] = {{{"byteLength", bytes.size()},
                         {"uri", "data:application/octet-stream;base64," + Base64(bytes)}}};
    return whole.dump();
  }

 private:
  template <class Number>
  static int ComponentType() {
    if (std::is_same_v<Number, float>) return 5126;
    constexpr int kSigned = std::is_signed_v<Number> ? 0 : 1;
    return (sizeof(Number) == 1 ? 5120 : sizeof(Number) == 2 ? 5122 : 5124) + kSigned;
  }

  static std::string Base64(const std::string& from) {
    const char* const digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    for (std::size_t i = 0; i < from.size(); i += 3) {
      std::uint32_t word = 0;
      for (std::size_t k = 0; k < 3; ++k) {
        word = word << 8 | (i + k < from.size() ? std::uint8_t(from[i + k]) : 0u);
      }
      for (std::size_t k = 0; k < 4; ++k) {
        text += i + k > from.size() ? '=' : digits[word >> (18 - 6 * k) & 63];
      }
    }
    return text;
  }
};

// One triangle (0,0,0), (1,0,0), (0,1,0) in node 1, a child of node 0; node 2 has a camera,
// "front", and node 3 another one, "side", both looking along -z. Materials: "paint" of the
// triangle, "steel". Nothing is animated.
inline GltfDocument TriangleDocument() {
  GltfDocument document;
  const int positions = document.Add<float>({0, 0, 0, 1, 0, 0, 0, 1, 0}, "VEC3");
  nlohmann::json& json = document.json;
  json["scenes"] = {{{"nodes", {0, 2, 3, 4}}}};
  json["nodes"] = {{{"children", {1}}, {"translation", {5, 0, 0}}},
                   {{"mesh", 0}},
                   {{"camera", 0}, {"name", "front"}, {"translation", {5.25, 0.25, 4}}},
                   {{"camera", 1}, {"name", "side"}, {"translation", {4, 1, 3}}},
                   {{"mesh", 1}, {"scale", {0, 0, 0}}}};  // seen by nobody, and of steel
  json["meshes"] = {
      {{"primitives", {{{"attributes", {{"POSITION", positions}}}, {"material", 0}}}}},
      {{"primitives", {{{"attributes", {{"POSITION", positions}}}, {"material", 1}}}}}};
  json["materials"] = {
      {{"name", "paint"}, {"pbrMetallicRoughness", {{"baseColorFactor", {0.5, 0.25, 1, 1}}}}},
      {{"name", "steel"}, {"pbrMetallicRoughness", {{"metallicFactor", 1}}}}};
  json["cameras"] = {{{"type", "perspective"}, {"perspective", {{"yfov", 1.0}, {"znear", 0.1}}}},
                     {{"type", "perspective"}, {"perspective", {{"yfov", 0.5}, {"znear", 0.1}}}}};
  return document;
}

// The same with the animations "slide", 1 s in which node 0 moves by -5 along x, and "turn", 2 s in
// which node 1 turns about z by a right angle; the variant "worn", in which the triangle is of
// steel; and the scene "other", which has node 1 alone.
inline GltfDocument MovingTriangle() {
  GltfDocument document = TriangleDocument();
  const float half = 0.70710678f;
  document.Animate(0, 0, "translation", document.Add<float>({0, 1}, "SCALAR"),
                   document.Add<float>({5, 0, 0, 0, 0, 0}, "VEC3"));
  document.Animate(1, 1, "rotation", document.Add<float>({0, 2}, "SCALAR"),
                   document.Add<float>({0, 0, 0, 1, 0, 0, half, half}, "VEC4"));
  document.json["animations"][0]["name"] = "slide";
  document.json["animations"][1]["name"] = "turn";
  document.json["extensions"]["KHR_materials_variants"]["variants"] = {{{"name", "worn"}}};
  nlohmann::json& primitive = document.json["meshes"][0]["primitives"][0];
  primitive["extensions"]["KHR_materials_variants"]["mappings"] = {
      {{"material", 1}, {"variants", {0}}}};
  document.json["scenes"].push_back({{"name", "other"}, {"nodes", {1}}});
  return document;
}

}  // namespace skywave
