#include "bench/measure/reference_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>

#include "base/error.h"

namespace skywave {
namespace {

constexpr char kMse[] = "referenceMse", kRelativeMse[] = "referenceRelativeMse";

std::string Text(const Metadata& metadata, std::string_view name) {
  for (const auto& [key, value] : metadata) {
    if (key == name) return value;
  }
  return {};
}

// Returns the number at the start of `text`, if there is one and it is not negative.
std::optional<double> Number(const std::string& text) {
  double value = 0;
  const auto read = std::from_chars(text.data(), text.data() + text.size(), value);
  if (read.ec != std::errc() || !(value >= 0) || !std::isfinite(value)) return std::nullopt;
  return value;
}

}  // namespace

void WriteReference(const std::string& path, const ReferenceFile& file, Metadata provenance) {
  provenance.emplace_back("samples", fmt::format("{}", file.samples_per_pixel));
  provenance.emplace_back("sceneHash", file.scene_hash);
  if (file.reference.mse) provenance.emplace_back(kMse, fmt::format("{}", *file.reference.mse));
  if (file.reference.relative_mse) {
    provenance.emplace_back(kRelativeMse, fmt::format("{}", *file.reference.relative_mse));
  }
  WriteExr(path, file.reference.image, provenance);
}

ReferenceFile ReadReference(const std::string& path, int width, int height,
                            const ReadLimits& limits) {
  ReferenceFile file;
  file.reference.image = ReadDataWindow(path, {}, limits).image;
  const Image& image = file.reference.image;
  if (image.width != width || image.height != height) {
    throw InputError(
        InputPosition::File(path),
        fmt::format("is {} x {} pixels, but {} x {} are rendered: give --size {}x{}", image.width,
                    image.height, width, height, image.width, image.height));
  }
  if (!std::all_of(image.rgb.begin(), image.rgb.end(), [](float v) { return std::isfinite(v); })) {
    throw InputError(InputPosition::File(path),
                     "has pixels that are not numbers, so no error can be measured against it");
  }
  if (std::filesystem::path(path).extension() != ".exr") return file;
  const Metadata metadata = ReadExrMetadata(path, limits);
  file.reference.mse = Number(Text(metadata, kMse));
  file.reference.relative_mse = Number(Text(metadata, kRelativeMse));
  file.samples_per_pixel =
      std::uint32_t(std::min(Number(Text(metadata, "samples")).value_or(0), 4e9));
  file.scene_hash = Text(metadata, "sceneHash");
  return file;
}

}  // namespace skywave
