// Reads the numbers in a glTF file's buffers. Nothing from tinygltf is trusted: every range is
// checked against the bytes that exist.
#pragma once

#include <tiny_gltf.h>

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace skywave {

// Elements of an accessor without a buffer view, at most: nothing in the file bounds them.
inline constexpr std::size_t kMostGltfZeros = std::size_t{1} << 22;

// Throws InputError(path).
[[noreturn]] void FailGltf(const std::string& path, const std::string& reason);

// Returns the bytes of a buffer view. Throws InputError(path) if it extends beyond its buffer.
std::string_view GltfBytes(const tinygltf::Model& model, int buffer_view, const std::string& path);

// Returns all components of all elements of an accessor, sparse or not, as floats, with normalized
// integers scaled to [0, 1] or [-1, 1]. Throws InputError(path) unless the accessor has
// `components` components per element, lies within its buffer views and holds finite numbers.
std::vector<float> ReadGltfNumbers(const tinygltf::Model& model, int accessor, int components,
                                   const std::string& path);

// Returns scalars of an unsigned integer type. Sparse ones hold at most 16777215.
std::vector<std::uint32_t> ReadGltfIndices(const tinygltf::Model& model, int accessor,
                                           const std::string& path);

}  // namespace skywave
