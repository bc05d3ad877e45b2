// The readers of files as fuzzers see them: bytes in, a scene or an InputError out.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

namespace skywave {

struct FuzzedReader {
  std::string_view name;  // also the folder of its corpus
  void (*read)(std::string_view bytes);
};

// pbrt, spd, ply, gzip, obj, mtl, gltf, hdr, pfm, exr, png, jpeg.
std::span<const FuzzedReader> FuzzedReaders();

// Hands the bytes to the reader. Anything but a result or an InputError is a bug: exceptions leave.
void FuzzOnce(const FuzzedReader& reader, std::string_view bytes);

}  // namespace skywave
