#include "lights/maps/cube_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "base/error.h"
#include "base/files.h"

namespace skywave {

std::array<std::string, 6> CubeFacePaths(const std::string& path) {
  constexpr const char* kFaceNames[6] = {"right", "left", "up", "down", "front", "back"};
  const std::filesystem::path whole(path);
  std::array<std::string, 6> paths;
  for (std::size_t f = 0; f < paths.size(); ++f) {
    const std::string name =
        fmt::format("{}-{}{}", whole.stem().string(), kFaceNames[f], whole.extension().string());
    paths[f] = (whole.parent_path() / name).string();
  }
  return paths;
}

Image ReadCubeFaces(const std::string& path, const ReadLimits& limits) {
  const std::array<std::string, 6> paths = CubeFacePaths(path);
  Image strip;
  for (int f = 0; f < 6; ++f) {
    const Image face = ReadImage(paths[std::size_t(f)], limits);
    if (f == 0) strip = Image(6 * face.height, face.height);
    if (face.width != strip.height || face.height != strip.height) {
      throw InputError(InputPosition::File(paths[std::size_t(f)]),
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
  const std::array<std::string, 6> paths = CubeFacePaths(path);
  CheckAllWritable(paths);
  for (int f = 0; f < 6; ++f) {
    Image face(side, side);
    for (int y = 0; y < side; ++y) {
      std::copy_n(strip.Pixel(f * side, y), 3 * side, face.Pixel(0, y));
    }
    WriteImage(paths[std::size_t(f)], face);
  }
}

}  // namespace skywave
