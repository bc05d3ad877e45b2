#include "tests/fuzz/readers.h"

#include <xxhash.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>

#include "base/error.h"
#include "base/gzip.h"
#include "bench/measure/baseline.h"
#include "bench/measure/bench_export.h"
#include "bench/measure/json_input.h"
#include "image/formats.h"
#include "image/image.h"
#include "job/batch/plan.h"
#include "job/batch/report.h"
#include "job/film_file.h"
#include "scene/gltf/reader.h"
#include "scene/materials/merl.h"
#include "scene/materials/spectrum.h"
#include "scene/obj/mtl.h"
#include "scene/obj/reader.h"
#include "scene/pbrt/lens_file.h"
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
void Lens(std::string_view bytes) {
  LensDesign design;
  design.interfaces = ParsePbrtLens(std::string(bytes), Path(".dat"));
  design.film_diagonal = 0.035;
  FocusLens(design, 2);
  if (design.interfaces.size() < 8) LensSystem lens(design);
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

// A TGA is known by its name.
void Tga(std::string_view bytes) { DecodeTexture(Path(".tga"), bytes, Encoding::kSrgb, kLimits); }

// Only built-in scenes can be found.
void Job(std::string_view bytes) { ParseBatchPlan(Path(".toml"), std::string(bytes)); }

// A picture with the layers that it has, of which the denoiser reads some.
void Layers(std::string_view bytes) {
  const std::string path = Path(".exr");
  const std::vector<std::string> names = ExrLayerNames(path, bytes, kLimits);
  const LayeredImage read = DecodeExr(path, bytes, kLimits, names);
  for (const NamedChannel& layer : read.layers) {
    if (3 * layer.values.size() != read.image.rgb.size()) throw std::logic_error("a torn layer");
  }
}

// A file of the format has 35 MB, so the input is its header and the first numbers, which are
// repeated up to that length.
void Merl(std::string_view bytes) {
  constexpr std::size_t kHeader = 12, kBytes = kHeader + sizeof(double) * kMeasuredFloats;
  const std::string path = Path(".binary");
  std::string file(bytes);
  if (bytes.size() >= kHeader + sizeof(double)) {
    const std::size_t numbers = (bytes.size() - kHeader) / sizeof(double) * sizeof(double);
    file.reserve(kBytes);
    while (file.size() < kBytes) {
      file.resize(file.size() - (file.size() - kHeader) % sizeof(double));
      file.append(bytes.substr(kHeader, std::min(numbers, kBytes - file.size())));
    }
    file.resize(kBytes);
  }
  const MeasuredBrdf brdf = ParseMerl(file, path);
  if (!std::isfinite(brdf.alpha) || !(brdf.specular_share > 0 && brdf.specular_share < 1)) {
    throw std::logic_error("no lobe was fitted");
  }
}

// The input is a file; or its manifest, a zero and its sums, around which a file is made with the
// right length and checksum.
void FilmParts(std::string_view bytes) {
  const std::string path = Path(".film");
  const std::size_t zero = bytes.find('\0');
  if (bytes.starts_with("SKYWFILM") || zero == bytes.npos) return void(ParseFilm(bytes, path));
  std::string file = "SKYWFILM";
  const auto append = [&](std::uint64_t number) {
    file.append(reinterpret_cast<const char*>(&number), sizeof number);
  };
  append(zero);
  file.append(bytes.substr(0, zero)).append(bytes.substr(zero + 1));
  append(XXH64(file.data(), file.size(), 0));
  ParseFilm(file, path);
}

// What `skywave bench` reads of its own JSON. Each schema is refused by the readers of the others.
void Bench(std::string_view bytes) {
  const std::string path = Path(".json");
  const nlohmann::json json = ParseJson(bytes, path);
  const auto attempt = [](const auto& read) {
    try {
      read();
    } catch (const InputError&) {
    }
  };
  attempt([&] { SummaryOf(json, path); });
  attempt([&] { BaselineOf(json, path); });
  attempt([&] {
    const BenchRecord record = RecordOf(json, path);
    for (const ExportFormat format : ValuesOf<ExportFormat>()) Export(record, format).dump();
  });
}
void Report(std::string_view bytes) { ResultsInJson(std::string(bytes)); }

constexpr FuzzedReader kReaders[] = {
    {"pbrt", Pbrt},      {"lens", Lens},   {"spd", Spd},       {"ply", Ply},     {"gzip", Gzip},
    {"obj", Obj},        {"mtl", Mtl},     {"gltf", Gltf},     {"hdr", Picture}, {"pfm", Picture},
    {"exr", Picture},    {"png", Picture}, {"jpeg", Picture},  {"tga", Tga},     {"bmp", Picture},
    {"gif", Picture},    {"qoi", Picture}, {"layers", Layers}, {"merl", Merl},   {"job", Job},
    {"film", FilmParts}, {"bench", Bench}, {"report", Report},
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
