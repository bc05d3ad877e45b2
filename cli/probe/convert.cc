// Implements skywave probe convert: a map in another projection or size.
#include <fmt/format.h>

#include <array>
#include <charconv>
#include <filesystem>

#include "base/error.h"
#include "base/files.h"
#include "cli/print.h"
#include "cli/probe/commands.h"
#include "lights/maps/cube_files.h"
#include "lights/maps/projections.h"
#include "lights/maps/resample.h"

namespace skywave {
namespace {

struct ConvertFlags {
  MapFlags map;
  std::string output, size;
  Projection to = Projection::kLatLong;
  bool faces_in = false, faces_out = false;
};

// Reads "512", the height of a lat-long map or square (edge of a cube's face), or "640x480".
void ReadSize(const std::string& text, Projection to, int& width, int& height) {
  const char* end = text.data() + text.size();
  auto parsed = std::from_chars(text.data(), end, width);
  bool good = parsed.ec == std::errc() && width > 0;
  if (good && parsed.ptr == end) {
    const int side = width;
    DefaultSize(to, to == Projection::kLatLong ? side : 2 * side, width, height);
    if (width == height) width = height = side;
  } else {
    good = good && *parsed.ptr == 'x';
    if (good) parsed = std::from_chars(parsed.ptr + 1, end, height);
    good = good && parsed.ec == std::errc() && parsed.ptr == end;
  }
  if (!good) throw InputError({}, "--size '" + text + "' is neither N nor WxH", kExitUsage);
  const ReadLimits limits;
  if (width < 1 || height < 1 || width > limits.max_width || height > limits.max_height ||
      std::size_t(width) * height > limits.max_pixels) {
    throw InputError({}, fmt::format("--size {} is out of range", text), kExitUsage);
  }
}

// Checks the files that are written, which may be six, against those that are read.
void CheckFiles(const ConvertFlags& flags) {
  const auto names = [](const std::string& path, bool faces) {
    if (!faces) return std::vector<std::string>{path};
    const auto six = CubeFacePaths(path);
    return std::vector<std::string>(six.begin(), six.end());
  };
  CheckOutputs(names(flags.output, flags.faces_out), names(flags.map.path, flags.faces_in));
}

int ConvertMain(ConvertFlags& flags) {
  CheckFiles(flags);
  ProbeMap file;
  if (flags.faces_in) {
    file = {.image = ReadCubeFaces(flags.map.path, flags.map.limits),
            .projection = Projection::kCubeStrip,
            .assumed = true};
    file.bad = RepairRadiance(file.image);
  } else {
    file = ReadProbe(flags.map);
  }
  int width = 0, height = 0;
  if (flags.size.empty()) {
    DefaultSize(flags.to, LatLongHeight(file.projection, file.image.width, file.image.height),
                width, height);
    if (file.projection == flags.to) width = file.image.width, height = file.image.height;
  } else {
    ReadSize(flags.size, flags.to, width, height);
  }
  const Image result = Resample(file.image, file.projection, flags.to, width, height);
  if (flags.faces_out) {
    WriteCubeFaces(flags.output, result);
  } else {
    WriteImage(flags.output, result);
  }
  const auto before = SphereIntegral(file.image, file.projection);
  const auto after = SphereIntegral(result, flags.to);
  Print(stdout,
        "{} {} x {} to {} {} x {}; integral {:.7g} {:.7g} {:.7g}, was {:.7g} {:.7g} {:.7g}\n",
        ToString(file.projection), file.image.width, file.image.height, ToString(flags.to), width,
        height, after[0], after[1], after[2], before[0], before[1], before[2]);
  return 0;
}

#define FIELD SKYWAVE_FIELD
std::vector<OptionOf<ConvertFlags>> ConvertOptions() {
  constexpr OptionMaker<ConvertFlags> option = {};
  OptionOf<ConvertFlags> to = {
      {.name = "to",
       .help = "projection that is written; cube-faces: six files, OUTPUT-right.exr, -left, -up, "
               "-down, -front, -back",
       .required = true,
       .values = Choices<Projection>() + "|cube-faces",
       .value_name = Choices<Projection>() + "|cube-faces"},
      {},
      {}};
  to.set = [values = to.values](ConvertFlags& f, const std::vector<std::string>& texts) {
    f.faces_out = texts.front() == "cube-faces";
    const auto projection = f.faces_out ? Projection::kCubeStrip : Parse<Projection>(texts.front());
    if (!projection) return NotAValue(texts.front(), values);
    f.to = *projection;
    return std::string();
  };
  to.get = [](const ConvertFlags&) { return std::vector<std::string>(); };
  // clang-format off
  return {
    option({.name = "output", .help = "EXR, HDR or PFM", .positional = true, .required = true}, FIELD(output), Texts("FILE")),
    to,
    option({.name = "from-faces", .help = "MAP names six files as --to cube-faces writes them"}, FIELD(faces_in), Switches()),
    option({.name = "size", .help = "WxH, or N: height of a lat-long, side of a square or of a cube's face", .default_text = "keeps the resolution"}, FIELD(size), Texts("WxH|N")),
  };
  // clang-format on
}
#undef FIELD

}  // namespace

Command ProbeConvertCommand() {
  const auto flags = std::make_shared<ConvertFlags>();
  Command command = {.name = "convert",
                     .summary = "A map in another projection or size",
                     .footer =
                         "Examples:\n"
                         "  skywave probe convert probe.hdr sky.exr --to latlong --size 1024x512\n"
                         "  skywave probe convert sky.exr cube.exr --to cube-faces --size 512\n"
                         "  skywave probe convert cube.exr back.exr --from-faces --to latlong",
                     .run = [flags](const GivenOptions&) { return ConvertMain(*flags); }};
  AddMapOptions(command, std::shared_ptr<MapFlags>(flags, &flags->map));
  const auto options = ConvertOptions();
  AddOptions(command, options, flags);
  return command;
}

}  // namespace skywave
