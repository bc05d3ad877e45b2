#include "lights/maps/cube_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "base/error.h"
#include "base/files.h"

namespace skywave {
namespace {

constexpr const char* kFaceNames[6] = {"right", "left", "up", "down", "front", "back"};

std::string FacePath(const std::string& path, int face) {
  const std::filesystem::path whole(path);
  const std::string name =
      fmt::format("{}-{}{}", whole.stem().string(), kFaceNames[face], whole.extension().string());
  return (whole.parent_path() / name).string();
}

}  // namespace

Image ReadCubeFaces(const std::string& path, const ReadLimits& limits) {
  Image strip;
  for (int f = 0; f < 6; ++f) {
    const Image face = ReadImage(FacePath(path, f), limits);
    if (f == 0) strip = Image(6 * face.height, face.height);
    if (face.width != strip.height || face.height != strip.height) {
      throw InputError(InputPosition::File(FacePath(path, f)),
                       fmt::format("{} x {} pixels; all six faces must be squares of one size",
                                   face.width, face.height));
    }
    for (int y = 0; y < face.height; ++y) {
      std::copy_n(face.Pixel(0, y), 3 * face.width, strip.Pixel(f * face.width, y));
    }
  }
  return strip;
}

void WriteCubeFaces(const std::string& path, const Image& strip) {
  const int side = strip.height;
  for (int f = 0; f < 6; ++f) CheckWritable(FacePath(path, f));
  for (int f = 0; f < 6; ++f) {
    Image face(side, side);
    for (int y = 0; y < side; ++y) {
      std::copy_n(strip.Pixel(f * side, y), 3 * side, face.Pixel(0, y));
    }
    WriteImage(FacePath(path, f), face);
  }
}

}  // namespace skywave
