#include "scene/gltf/buffers.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "base/error.h"

namespace skywave {
namespace {

// Describes the elements of an accessor in place.
struct Elements {
  const char* first;
  std::size_t count, stride, component_bytes;
  int type;
  bool normalized;
};

Elements FindElements(const tinygltf::Model& model, int index, int components,
                      const std::string& path) {
  if (index < 0 || std::size_t(index) >= model.accessors.size()) {
    FailGltf(path, fmt::format("there is no accessor {}", index));
  }
  const tinygltf::Accessor& accessor = model.accessors[std::size_t(index)];
  const auto fail = [&](const std::string& reason) {
    FailGltf(path, fmt::format("accessor {} {}", index, reason));
  };
  if (accessor.sparse.isSparse) fail("is sparse, which is not supported");
  if (tinygltf::GetNumComponentsInType(std::uint32_t(accessor.type)) != components) {
    fail(fmt::format("has not {} components", components));
  }
  const int bytes = tinygltf::GetComponentSizeInBytes(std::uint32_t(accessor.componentType));
  if (bytes < 1 || accessor.componentType == TINYGLTF_COMPONENT_TYPE_DOUBLE) {
    fail("has an unknown component type");
  }
  const std::string_view view = GltfBytes(model, accessor.bufferView, path);
  const std::size_t element = std::size_t(bytes) * std::size_t(components);
  const std::size_t given = model.bufferViews[std::size_t(accessor.bufferView)].byteStride;
  const std::size_t stride = given == 0 ? element : given;
  if (stride < element) fail("has elements that overlap");
  if (accessor.byteOffset > view.size() || accessor.count == 0 ||
      view.size() - accessor.byteOffset < element ||
      (view.size() - accessor.byteOffset - element) / stride < accessor.count - 1) {
    fail(fmt::format("has {} elements, which its buffer view does not hold", accessor.count));
  }
  return {.first = view.data() + accessor.byteOffset,
          .count = accessor.count,
          .stride = stride,
          .component_bytes = std::size_t(bytes),
          .type = accessor.componentType,
          .normalized = accessor.normalized};
}

template <class Number>
double Read(const char* from, bool normalized) {
  Number value;
  std::memcpy(&value, from, sizeof value);
  if (!normalized || !std::numeric_limits<Number>::is_integer) return double(value);
  return std::max(double(value) / double(std::numeric_limits<Number>::max()), -1.0);
}

double ReadComponent(const Elements& e, const char* from) {
  switch (e.type) {
    case TINYGLTF_COMPONENT_TYPE_BYTE:
      return Read<std::int8_t>(from, e.normalized);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
      return Read<std::uint8_t>(from, e.normalized);
    case TINYGLTF_COMPONENT_TYPE_SHORT:
      return Read<std::int16_t>(from, e.normalized);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
      return Read<std::uint16_t>(from, e.normalized);
    case TINYGLTF_COMPONENT_TYPE_INT:
      return Read<std::int32_t>(from, e.normalized);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
      return Read<std::uint32_t>(from, e.normalized);
    default:
      return Read<float>(from, false);
  }
}

}  // namespace

void FailGltf(const std::string& path, const std::string& reason) {
  throw InputError(InputPosition::File(path), reason);
}

std::string_view GltfBytes(const tinygltf::Model& model, int buffer_view, const std::string& path) {
  if (buffer_view < 0 || std::size_t(buffer_view) >= model.bufferViews.size()) {
    FailGltf(path, fmt::format("there is no buffer view {}", buffer_view));
  }
  const tinygltf::BufferView& view = model.bufferViews[std::size_t(buffer_view)];
  if (view.buffer < 0 || std::size_t(view.buffer) >= model.buffers.size()) {
    FailGltf(path, fmt::format("buffer view {} is of no buffer", buffer_view));
  }
  const std::vector<unsigned char>& data = model.buffers[std::size_t(view.buffer)].data;
  if (view.byteOffset > data.size() || view.byteLength > data.size() - view.byteOffset) {
    FailGltf(path, fmt::format("buffer view {} ends behind its buffer of {} bytes", buffer_view,
                               data.size()));
  }
  return {reinterpret_cast<const char*>(data.data()) + view.byteOffset, view.byteLength};
}

std::vector<float> ReadGltfNumbers(const tinygltf::Model& model, int accessor, int components,
                                   const std::string& path) {
  const Elements e = FindElements(model, accessor, components, path);
  std::vector<float> numbers;
  numbers.reserve(e.count * std::size_t(components));
  for (std::size_t i = 0; i < e.count; ++i) {
    for (std::size_t c = 0; c < std::size_t(components); ++c) {
      const char* const from = e.first + i * e.stride + c * e.component_bytes;
      const auto number = float(ReadComponent(e, from));
      if (!std::isfinite(number)) {
        FailGltf(path, fmt::format("accessor {}: element {} is not finite", accessor, i));
      }
      numbers.push_back(number);
    }
  }
  return numbers;
}

std::vector<std::uint32_t> ReadGltfIndices(const tinygltf::Model& model, int accessor,
                                           const std::string& path) {
  const Elements e = FindElements(model, accessor, 1, path);
  if (e.type != TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE &&
      e.type != TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT &&
      e.type != TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT) {
    FailGltf(path, fmt::format("accessor {} has indices that are no unsigned integers", accessor));
  }
  std::vector<std::uint32_t> indices(e.count);
  for (std::size_t i = 0; i < e.count; ++i) {
    indices[i] = std::uint32_t(ReadComponent(e, e.first + i * e.stride));
  }
  return indices;
}

}  // namespace skywave
