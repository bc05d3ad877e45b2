#include "tests/fuzz/readers.h"

#include <string>

#include "base/error.h"
#include "base/gzip.h"
#include "batch/plan.h"
#include "image/image.h"
#include "scene/gltf/reader.h"
#include "scene/materials/spectrum.h"
#include "scene/obj/mtl.h"
#include "scene/obj/reader.h"
#include "scene/pbrt/reader.h"
#include "scene/shapes/ply.h"

namespace skywave {
namespace {

// The limits are small, so that a run finds more than slow inputs. The folder does not exist, so no
// file is included.
const ReadOptions kOptions = {.strict = false, .max_triangles = std::size_t{1} << 15};
constexpr ReadLimits kLimits = {
    .max_width = 1024, .max_height = 1024, .max_pixels = std::size_t{1} << 18};
constexpr std::string_view kPath = "/nowhere/fuzzed";

std::string Path(std::string_view ending) { return std::string(kPath) + std::string(ending); }

void Pbrt(std::string_view bytes) { ParsePbrt(std::string(bytes), Path(".pbrt"), kOptions); }
void Spd(std::string_view bytes) {
  const auto pairs = ParseSpectrumFile(std::string(bytes), Path(".spd"));
  RgbOfReflectance(pairs);
  RgbOfEmission(pairs);
}
void Ply(std::string_view bytes) { ParsePly(bytes, Path(".ply")); }
void Gzip(std::string_view bytes) { Gunzip(std::string(bytes), Path(".gz"), 1 << 20); }
void Obj(std::string_view bytes) { ParseObj(std::string(bytes), Path(".obj"), kOptions); }
void Mtl(std::string_view bytes) {
  Scene scene;
  TextureFiles textures{&scene};
  Warnings warnings;
  ParseMtl(std::string(bytes), Path(".mtl"), textures, warnings);
}
void Gltf(std::string_view bytes) {
  ParseGltf(std::string(bytes), Path(".gltf"), kOptions);
  ReadOptions animated = kOptions;
  animated.frame = 12;
  ParseGltf(std::string(bytes), Path(".gltf"), animated);
}
void Picture(std::string_view bytes) {
  DecodeTexture(std::string(kPath), bytes, Encoding::kSrgb, kLimits);
}

// Only built-in scenes can be found.
void Job(std::string_view bytes) { ParseBatchPlan(Path(".toml"), std::string(bytes)); }

constexpr FuzzedReader kReaders[] = {
    {"pbrt", Pbrt},   {"spd", Spd},      {"ply", Ply},     {"gzip", Gzip},   {"obj", Obj},
    {"mtl", Mtl},     {"gltf", Gltf},    {"hdr", Picture}, {"pfm", Picture}, {"exr", Picture},
    {"png", Picture}, {"jpeg", Picture}, {"job", Job},
};

}  // namespace

std::span<const FuzzedReader> FuzzedReaders() { return kReaders; }

void FuzzOnce(const FuzzedReader& reader, std::string_view bytes) {
  try {
    reader.read(bytes);
  } catch (const InputError&) {
  }
}

}  // namespace skywave
