// The file readers as fuzzers use them: bytes in, what they mean or an InputError out.
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

// Returns pbrt, spd, ply, gzip, obj, mtl, gltf, hdr, pfm, exr, png, jpeg, tga, bmp, gif, qoi,
// layers (of an EXR), merl, job (of skywave batch), film, bench (its JSON), report (of skywave
// batch, in JSON).
std::span<const FuzzedReader> FuzzedReaders();

// Passes the bytes to the reader. Other exceptions than InputError are bugs and propagate.
void FuzzOnce(const FuzzedReader& reader, std::string_view bytes);

}  // namespace skywave
