// The numbers in a glTF file's buffers. Nothing that tinygltf hands over is believed: every range
// is checked against the bytes that are there.
#pragma once

#include <tiny_gltf.h>

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace skywave {

// The bytes of a buffer view. Throws InputError(path) if it leaves its buffer.
std::string_view GltfBytes(const tinygltf::Model& model, int buffer_view, const std::string& path);

// All components of all elements of an accessor as floats, integers that are normalized scaled to
// [0, 1] or [-1, 1]. Throws InputError(path) unless it has `components` a element, lies within its
// buffer view, is not sparse, and its numbers are finite.
std::vector<float> ReadGltfNumbers(const tinygltf::Model& model, int accessor, int components,
                                   const std::string& path);

// Scalars of unsigned integers.
std::vector<std::uint32_t> ReadGltfIndices(const tinygltf::Model& model, int accessor,
                                           const std::string& path);

}  // namespace skywave
