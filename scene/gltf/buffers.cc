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

// Returns the elements in a buffer view as an accessor has them: `count` elements of `components`
// numbers, the first one `offset` bytes after the beginning of the view. `name` is for errors.
Elements ElementsOf(const tinygltf::Model& model, int buffer_view, std::size_t offset,
                    std::size_t count, int components, int component_type, const std::string& name,
                    const std::string& path) {
  const auto fail = [&](const std::string& reason) { FailGltf(path, name + " " + reason); };
  const int bytes = tinygltf::GetComponentSizeInBytes(std::uint32_t(component_type));
  if (bytes < 1 || component_type == TINYGLTF_COMPONENT_TYPE_DOUBLE) {
    fail("has an unknown component type");
  }
  const std::string_view view = GltfBytes(model, buffer_view, path);
  const std::size_t element = std::size_t(bytes) * std::size_t(components);
  const std::size_t given = model.bufferViews[std::size_t(buffer_view)].byteStride;
  const std::size_t stride = given == 0 ? element : given;
  if (stride < element) fail("has elements that overlap");
  if (offset > view.size() || count == 0 || view.size() - offset < element ||
      (view.size() - offset - element) / stride < count - 1) {
    fail(fmt::format("has {} elements, which its buffer view does not hold", count));
  }
  return {.first = view.data() + offset,
          .count = count,
          .stride = stride,
          .component_bytes = std::size_t(bytes),
          .type = component_type,
          .normalized = false};
}

std::string AccessorName(int index) { return fmt::format("accessor {}", index); }

const tinygltf::Accessor& FindAccessor(const tinygltf::Model& model, int index, int components,
                                       const std::string& path) {
  if (index < 0 || std::size_t(index) >= model.accessors.size()) {
    FailGltf(path, fmt::format("there is no accessor {}", index));
  }
  const tinygltf::Accessor& accessor = model.accessors[std::size_t(index)];
  if (tinygltf::GetNumComponentsInType(std::uint32_t(accessor.type)) != components) {
    FailGltf(path, fmt::format("{} has not {} components", AccessorName(index), components));
  }
  return accessor;
}

Elements ElementsOfAccessor(const tinygltf::Model& model, int index, int components,
                            const std::string& path) {
  const tinygltf::Accessor& accessor = FindAccessor(model, index, components, path);
  Elements elements = ElementsOf(model, accessor.bufferView, accessor.byteOffset, accessor.count,
                                 components, accessor.componentType, AccessorName(index), path);
  elements.normalized = accessor.normalized;
  return elements;
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

std::uint32_t ReadIndex(const Elements& e, std::size_t i) {
  return std::uint32_t(ReadComponent(e, e.first + i * e.stride));
}

// Writes `elements` into those of `numbers` that `place` gives for each.
template <class Place>
void ReadInto(const Elements& elements, int components, const Place& place, int accessor,
              const std::string& path, std::vector<float>& numbers) {
  for (std::size_t i = 0; i < elements.count; ++i) {
    for (std::size_t c = 0; c < std::size_t(components); ++c) {
      const char* const from = elements.first + i * elements.stride + c * elements.component_bytes;
      const auto number = float(ReadComponent(elements, from));
      if (!std::isfinite(number)) {
        FailGltf(path, fmt::format("accessor {}: element {} is not finite", accessor, place(i)));
      }
      numbers[place(i) * std::size_t(components) + c] = number;
    }
  }
}

bool IsIndexType(int type) {
  return type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE ||
         type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT ||
         type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT;
}

// Replaces the elements of `numbers` that a sparse accessor lists.
void ReadSparse(const tinygltf::Model& model, int index, int components, const std::string& path,
                std::vector<float>& numbers) {
  const tinygltf::Accessor& accessor = model.accessors[std::size_t(index)];
  const auto& sparse = accessor.sparse;
  const std::string name = AccessorName(index);
  // The type of these depends on the version of tinygltf.
  const auto first_place = std::int64_t(sparse.indices.byteOffset),
             first_value = std::int64_t(sparse.values.byteOffset);
  if (sparse.count < 1 || std::size_t(sparse.count) > accessor.count || first_place < 0 ||
      first_value < 0 || !IsIndexType(sparse.indices.componentType)) {
    FailGltf(path, name + " is sparse in a way that makes no sense");
  }
  const Elements places =
      ElementsOf(model, sparse.indices.bufferView, std::size_t(first_place),
                 std::size_t(sparse.count), 1, sparse.indices.componentType, name, path);
  Elements values =
      ElementsOf(model, sparse.values.bufferView, std::size_t(first_value),
                 std::size_t(sparse.count), components, accessor.componentType, name, path);
  values.normalized = accessor.normalized;
  for (std::size_t i = 0; i < places.count; ++i) {
    if (ReadIndex(places, i) >= accessor.count) {
      FailGltf(path, fmt::format("{} replaces element {} of {}", name, ReadIndex(places, i),
                                 accessor.count));
    }
  }
  const auto place = [&](std::size_t i) { return std::size_t(ReadIndex(places, i)); };
  ReadInto(values, components, place, index, path, numbers);
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
    FailGltf(path, fmt::format("buffer view {} extends beyond its buffer of {} bytes", buffer_view,
                               data.size()));
  }
  return {reinterpret_cast<const char*>(data.data()) + view.byteOffset, view.byteLength};
}

std::vector<float> ReadGltfNumbers(const tinygltf::Model& model, int accessor, int components,
                                   const std::string& path) {
  const tinygltf::Accessor& from = FindAccessor(model, accessor, components, path);
  const bool sparse = from.sparse.isSparse;
  std::vector<float> numbers;
  if (from.bufferView < 0) {  // all elements are zero but those that a sparse one replaces
    if (from.count > kMostGltfZeros) {
      FailGltf(path, fmt::format("accessor {} has {} elements without a buffer view, and {} are "
                                 "the most that are read",
                                 accessor, from.count, kMostGltfZeros));
    }
    numbers.resize(from.count * std::size_t(components));
  } else {
    const Elements elements = ElementsOfAccessor(model, accessor, components, path);
    numbers.resize(elements.count * std::size_t(components));
    ReadInto(
        elements, components, [](std::size_t i) { return i; }, accessor, path, numbers);
  }
  if (sparse) ReadSparse(model, accessor, components, path, numbers);
  return numbers;
}

std::vector<std::uint32_t> ReadGltfIndices(const tinygltf::Model& model, int accessor,
                                           const std::string& path) {
  const tinygltf::Accessor& from = FindAccessor(model, accessor, 1, path);
  if (!IsIndexType(from.componentType)) {
    FailGltf(path, fmt::format("accessor {} has indices that are no unsigned integers", accessor));
  }
  if (from.bufferView < 0 || from.sparse.isSparse) {
    const std::vector<float> numbers = ReadGltfNumbers(model, accessor, 1, path);
    // Floats hold integers exactly up to here; a mesh of more vertices has a buffer view as a rule.
    constexpr float kLargestExact = 16777216;
    std::vector<std::uint32_t> indices;
    for (const float number : numbers) {
      if (number >= kLargestExact) {
        FailGltf(path, fmt::format("accessor {} has sparse indices above 16777215, which are not "
                                   "supported",
                                   accessor));
      }
      indices.push_back(std::uint32_t(number));
    }
    return indices;
  }
  const Elements e = ElementsOfAccessor(model, accessor, 1, path);
  std::vector<std::uint32_t> indices(e.count);
  for (std::size_t i = 0; i < e.count; ++i) indices[i] = ReadIndex(e, i);
  return indices;
}

}  // namespace skywave
