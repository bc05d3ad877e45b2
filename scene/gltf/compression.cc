#include "scene/gltf/compression.h"

#include <draco/compression/decode.h>
#include <fmt/format.h>
#include <meshoptimizer.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <memory>
#include <new>
#include <optional>
#include <stdexcept>
#include <string_view>
#include <utility>

namespace skywave {
namespace {

using nlohmann::json;

constexpr const char* kDraco = "KHR_draco_mesh_compression";
// The second one adds a filter, and a version of the codec of attributes.
constexpr const char* kMeshopt[] = {"EXT_meshopt_compression", "KHR_meshopt_compression"};
constexpr std::size_t kMostViewBytes = std::size_t{1} << 31;  // of a view, decompressed
constexpr int kUnsignedInt = 5125, kFloat = 5126;

// Why something cannot be decoded.
class Undecodable : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

// Returns the object of an extension, or null.
const json* FindExtension(const json& of, const char* name) {
  if (!of.is_object() || !of.contains("extensions")) return nullptr;
  const json& extensions = of["extensions"];
  return extensions.is_object() && extensions.contains(name) ? &extensions[name] : nullptr;
}

std::size_t Size(const json& of, const char* name, std::size_t otherwise) {
  return of.contains(name) ? of.at(name).get<std::size_t>() : otherwise;
}

// Returns bytes of a buffer, which `range` names as a buffer view does.
std::string_view BytesOf(const GltfSource& source, const json& range) {
  const std::size_t buffer = range.at("buffer").get<std::size_t>();
  const std::size_t offset = Size(range, "byteOffset", 0), length = Size(range, "byteLength", 0);
  if (buffer >= source.buffers.size())
    throw Undecodable(fmt::format("there is no buffer {}", buffer));
  const std::string& bytes = source.buffers[buffer];
  if (offset > bytes.size() || length > bytes.size() - offset) {
    throw Undecodable(fmt::format("its data extend beyond buffer {}", buffer));
  }
  return std::string_view(bytes).substr(offset, length);
}

// The filter COLOR (KHR_meshopt_compression, Appendix B, filter 4): luma, two signed differences of
// colours and alpha have K bits, where the highest bit of alpha says K, and become normalized
// integers.
template <class Integer>
void DecodeColors(std::string& bytes) {
  constexpr int kMost = std::numeric_limits<Integer>::max();
  const auto signed_of = [](int bits) { return bits > kMost / 2 ? bits - kMost - 1 : bits; };
  Integer c[4];
  for (std::size_t at = 0; at + sizeof c <= bytes.size(); at += sizeof c) {
    std::memcpy(c, bytes.data() + at, sizeof c);
    const int most = std::max((1 << std::bit_width(c[3])) - 1, 1);
    const int y = c[0], orange = signed_of(c[1]), green = signed_of(c[2]);
    const int alpha = c[3] & (most >> 1);
    const int colors[] = {y + orange - green, y + green, y - orange - green,
                          alpha << 1 | (alpha & 1)};
    for (int i = 0; i < 4; ++i) {
      const float scaled = float(colors[i]) * (float(kMost) / float(most));
      c[i] = Integer(std::clamp(std::lround(scaled), 0l, long{kMost}));
    }
    std::memcpy(bytes.data() + at, c, sizeof c);
  }
}

std::string DecodeMeshopt(std::string_view bytes, const json& extension) {
  const std::size_t stride = extension.at("byteStride").get<std::size_t>();
  const std::size_t count = extension.at("count").get<std::size_t>();
  const std::string mode = extension.at("mode").get<std::string>();
  const std::string filter = extension.value("filter", "NONE");
  const bool vertices = mode == "ATTRIBUTES";
  const bool fits =
      vertices ? stride % 4 == 0 && stride > 0 && stride <= 256 : stride == 2 || stride == 4;
  if (!fits) throw Undecodable(fmt::format("it has elements of {} bytes", stride));
  if (count > kMostViewBytes / stride) throw Undecodable("it has too many elements");
  if (mode == "TRIANGLES" && count % 3 != 0) throw Undecodable("it has no whole triangles");
  std::string out(count * stride, '\0');
  const auto* const from = reinterpret_cast<const unsigned char*>(bytes.data());
  int failed = 1;
  if (vertices) {
    failed = meshopt_decodeVertexBuffer(out.data(), count, stride, from, bytes.size());
  } else if (mode == "TRIANGLES") {
    failed = meshopt_decodeIndexBuffer(out.data(), count, stride, from, bytes.size());
  } else if (mode == "INDICES") {
    failed = meshopt_decodeIndexSequence(out.data(), count, stride, from, bytes.size());
  } else {
    throw Undecodable(fmt::format("there is no mode {}", mode));
  }
  if (failed != 0 && MESHOPTIMIZER_VERSION < 230 && vertices && bytes.starts_with('\xa1')) {
    throw Undecodable("it has version 1 of the codec, which needs libmeshoptimizer 0.23");
  }
  if (failed != 0) throw Undecodable("it is broken");
  if (filter == "OCTAHEDRAL" && (stride == 4 || stride == 8)) {
    meshopt_decodeFilterOct(out.data(), count, stride);
  } else if (filter == "QUATERNION" && stride == 8) {
    meshopt_decodeFilterQuat(out.data(), count, stride);
  } else if (filter == "EXPONENTIAL") {
    meshopt_decodeFilterExp(out.data(), count, stride);
  } else if (filter == "COLOR" && stride == 4) {
    DecodeColors<std::uint8_t>(out);
  } else if (filter == "COLOR" && stride == 8) {
    DecodeColors<std::uint16_t>(out);
  } else if (filter != "NONE") {
    throw Undecodable(fmt::format("there is no filter {} of {} bytes", filter, stride));
  }
  return out;
}

std::unique_ptr<draco::Mesh> DecodeDraco(std::string_view bytes) {
  draco::DecoderBuffer buffer;
  buffer.Init(bytes.data(), bytes.size());
  draco::Decoder decoder;
  auto mesh = decoder.DecodeMeshFromBuffer(&buffer);
  if (!mesh.ok()) throw Undecodable(mesh.status().error_msg_string());
  return std::move(mesh).value();
}

// Writes numbers to a new view of the last buffer and returns its index.
template <class Number>
std::size_t AddView(GltfSource& source, const std::vector<Number>& numbers) {
  std::string& bytes = source.buffers.back();
  const std::size_t offset = bytes.size(), length = numbers.size() * sizeof(Number);
  bytes.resize(offset + length);
  if (length > 0) std::memcpy(bytes.data() + offset, numbers.data(), length);
  json& views = source.json["bufferViews"];
  views.push_back(
      {{"buffer", source.buffers.size() - 1}, {"byteOffset", offset}, {"byteLength", length}});
  return views.size() - 1;
}

// Returns the components of an attribute of all points, as floats; integers as they are, unless the
// accessor says that they are normalized.
std::vector<float> NumbersOf(const draco::Mesh& mesh, int id, int components) {
  const draco::PointAttribute* const attribute = mesh.GetAttributeByUniqueId(std::uint32_t(id));
  if (attribute == nullptr) throw Undecodable(fmt::format("it has no attribute {}", id));
  if (attribute->num_components() != components) {
    throw Undecodable(
        fmt::format("its attribute {} has {} components", id, int(attribute->num_components())));
  }
  std::vector<float> numbers(std::size_t(mesh.num_points()) * std::size_t(components));
  for (std::uint32_t i = 0; i < mesh.num_points(); ++i) {
    const draco::AttributeValueIndex value = attribute->mapped_index(draco::PointIndex(i));
    float* const to = numbers.data() + std::size_t(i) * std::size_t(components);
    if (!attribute->ConvertValue(value, std::int8_t(components), to)) {
      throw Undecodable(fmt::format("its attribute {} is broken", id));
    }
  }
  return numbers;
}

int ComponentsOf(const std::string& type) {
  if (type == "SCALAR") return 1;
  if (type.size() == 4 && type.starts_with("VEC") && type[3] >= '2' && type[3] <= '4') {
    return type[3] - '0';
  }
  throw Undecodable(fmt::format("an attribute is of the type {}", type.substr(0, 20)));
}

// Gives an accessor the numbers of a view.
void SetNumbers(json& accessor, std::size_t view, int component_type, std::size_t count) {
  accessor["bufferView"] = view;
  accessor["byteOffset"] = 0;
  accessor["componentType"] = component_type;
  accessor["count"] = count;
  accessor.erase("normalized"), accessor.erase("sparse");
}

void DecodePrimitive(GltfSource& source, const json& extension, json& primitive) {
  json& views = source.json.at("bufferViews");
  const auto mesh =
      DecodeDraco(BytesOf(source, views.at(extension.at("bufferView").get<std::size_t>())));
  json& accessors = source.json.at("accessors");
  source.buffers.emplace_back();
  for (const auto& [name, id] : extension.at("attributes").items()) {
    json& accessor = accessors.at(primitive.at("attributes").at(name).get<std::size_t>());
    const int components = ComponentsOf(accessor.at("type").get<std::string>());
    const std::vector<float> numbers = NumbersOf(*mesh, id.get<int>(), components);
    SetNumbers(accessor, AddView(source, numbers), kFloat, mesh->num_points());
  }
  std::vector<std::uint32_t> indices;
  for (std::uint32_t f = 0; f < mesh->num_faces(); ++f) {
    for (const draco::PointIndex& corner : mesh->face(draco::FaceIndex(f))) {
      indices.push_back(corner.value());
    }
  }
  if (!primitive.contains("indices")) {
    accessors.push_back({{"type", "SCALAR"}});
    primitive["indices"] = accessors.size() - 1;
  }
  SetNumbers(accessors.at(primitive.at("indices").get<std::size_t>()), AddView(source, indices),
             kUnsignedInt, indices.size());
  primitive["mode"] = 4;  // strips are triangles now
}

// Calls decode() and returns why it fails, or nothing.
template <class Decode>
std::optional<std::string> ProblemOf(const Decode& decode) {
  try {
    decode();
    return std::nullopt;
  } catch (const Undecodable& error) {
    return error.what();
  } catch (const json::exception& error) {
    return error.what();
  } catch (const std::bad_alloc&) {
    return "it needs more memory than there is";
  } catch (const std::length_error&) {
    return "it needs more memory than there is";
  }
}

}  // namespace

void DecodeMeshoptViews(GltfSource& source, const std::string& path, Warnings& warnings) {
  if (!source.json.contains("bufferViews")) return;
  std::size_t index = 0;
  for (json& view : source.json["bufferViews"]) {
    const char* const name = kMeshopt[FindExtension(view, kMeshopt[1]) != nullptr];
    const json* const extension = FindExtension(view, name);
    const auto problem = ProblemOf([&] {
      if (extension == nullptr) return;
      std::string bytes = DecodeMeshopt(BytesOf(source, *extension), *extension);
      view["buffer"] = source.buffers.size();
      view["byteOffset"] = 0, view["byteLength"] = bytes.size();
      source.buffers.push_back(std::move(bytes));
    });
    if (problem) {
      AddWarning(warnings, InputPosition::File(path),
                 fmt::format("buffer view {} cannot be decompressed ({}): {}: it is as if it were "
                             "not there",
                             index, name, *problem));
    }
    ++index;
  }
}

void DecodeDracoPrimitives(GltfSource& source, const std::string& path, Warnings& warnings) {
  if (!source.json.contains("meshes")) return;
  std::size_t index = 0;
  for (json& mesh : source.json["meshes"]) {
    if (!mesh.is_object() || !mesh.contains("primitives")) continue;
    json kept = json::array();
    for (json& primitive : mesh["primitives"]) {
      const json* const extension = FindExtension(primitive, kDraco);
      const auto problem = ProblemOf([&] {
        if (extension != nullptr) DecodePrimitive(source, json(*extension), primitive);
      });
      if (!problem) {
        kept.push_back(primitive);
        continue;
      }
      AddWarning(warnings, InputPosition::File(path),
                 fmt::format("mesh {} '{}': a primitive cannot be decompressed ({}): {}: left out",
                             index, mesh.value("name", ""), kDraco, *problem));
    }
    mesh["primitives"] = std::move(kept);
    ++index;
  }
}

}  // namespace skywave
