// Implements skywave probe assemble: photographs at several exposures become a picture of radiance.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/error.h"
#include "base/files.h"
#include "cli/print.h"
#include "cli/probe/commands.h"
#include "image/exif.h"
#include "job/options.h"
#include "lights/probe/exposures.h"

namespace skywave {
namespace {

struct AssembleFlags {
  std::vector<std::string> photographs, times;
  std::string output;
  bool align = true;
  std::optional<CropWindow> crop;
  ResponseMethod response = ResponseMethod::kDebevec;
  ReadLimits limits;
};

// Returns the number of "0.25", "1/4000" or "2"; nothing for other texts.
std::optional<double> ParseTime(const std::string& text) {
  const auto number = [](std::string_view part) -> std::optional<double> {
    double value = 0;
    const auto [end, error] = std::from_chars(part.data(), part.data() + part.size(), value);
    if (error != std::errc() || end != part.data() + part.size() || !(value > 0)) return {};
    return value;
  };
  const std::size_t slash = text.find('/');
  if (slash == std::string::npos) return number(text);
  const auto above = number(std::string_view(text).substr(0, slash));
  const auto below = number(std::string_view(text).substr(slash + 1));
  if (!above || !below) return std::nullopt;
  return *above / *below;
}

std::vector<double> GivenTimes(const AssembleFlags& flags) {
  std::vector<double> times;
  for (const std::string& text : flags.times) {
    const std::optional<double> time = ParseTime(text);
    if (!time) throw OptionError("times", text, "is no time such as 0.25 or 1/4000 [s]");
    times.push_back(*time);
  }
  if (times.size() != flags.photographs.size()) {
    throw OptionError(
        "times", "",
        fmt::format("{} times for {} photographs", times.size(), flags.photographs.size()));
  }
  return times;
}

// Returns times that the cameras have written, times sensitivity over the square of the f-number
// where every photograph has both.
std::vector<double> TimesOfCameras(const AssembleFlags& flags) {
  std::vector<CameraExposure> cameras;
  bool whole = true;
  for (const std::string& path : flags.photographs) {
    cameras.push_back(ReadCameraExposure(ReadFile(path)));
    if (!cameras.back().seconds) {
      throw InputError(InputPosition::File(path),
                       "has no exposure time of a camera (Exif): say --times T,T,...", kExitUsage);
    }
    whole = whole && cameras.back().f_number && cameras.back().iso;
  }
  std::vector<double> times;
  constexpr double kBaseIso = 100;
  for (const CameraExposure& camera : cameras) {
    const double gain = whole ? *camera.iso / kBaseIso / (*camera.f_number * *camera.f_number) : 1;
    times.push_back(*camera.seconds * gain);
  }
  return times;
}

Image Cropped(const Image& image, const CropWindow& window) {
  const auto within = [](int at, int size, int whole) {
    return at >= 0 && size > 0 && size <= whole && at <= whole - size;
  };
  if (!within(window.x, window.width, image.width) ||
      !within(window.y, window.height, image.height)) {
    throw OptionError("crop", Crops().print(window),
                      fmt::format("is not within {} x {}", image.width, image.height));
  }
  Image part(window.width, window.height);
  for (int y = 0; y < window.height; ++y) {
    std::copy_n(image.Pixel(window.x, window.y + y), std::size_t(3) * std::size_t(window.width),
                part.Pixel(0, y));
  }
  return part;
}

int AssembleMain(const AssembleFlags& flags) {
  CheckOutputs(std::array{flags.output}, flags.photographs);
  const std::vector<double> times = flags.times.empty() ? TimesOfCameras(flags) : GivenTimes(flags);
  std::vector<Exposure> exposures;
  for (std::size_t i = 0; i < flags.photographs.size(); ++i) {
    const std::string& path = flags.photographs[i];
    const bool coded = IsOfScreen(path);
    exposures.push_back({.name = path,
                         .image = coded ? ReadTexture(path, Encoding::kLinear, flags.limits)
                                        : ReadImage(path, flags.limits),
                         .coded = coded,
                         .exposure = times[i]});
  }
  AssembledExposures made = AssembleExposures(std::move(exposures), flags.align, flags.response);
  if (flags.crop) made.image = Cropped(made.image, *flags.crop);
  WriteImage(flags.output, made.image);
  for (std::size_t i = 0; i < times.size(); ++i) {
    Print(stdout, "{}  exposure {:.4g}  shift {} {}\n", flags.photographs[i], times[i],
          made.shift[i][0], made.shift[i][1]);
  }
  float least = std::numeric_limits<float>::infinity(), most = 0;
  for (const float value : made.image.rgb)
    least = std::min(least, value), most = std::max(most, value);
  Print(stdout, "wrote {}: {:.3g} to {:.3g}, {:.1f} decades\n", flags.output, least, most,
        std::log10(double(most) / least));
  if (made.white > 0) {
    Print(stderr,
          "note: {} values are white in the shortest exposure that shows them: their light "
          "is more than what is written\n",
          made.white);
  }
  if (made.black > 0) {
    Print(stderr,
          "note: {} values are black in the longest exposure that shows them: their light "
          "is less than what is written\n",
          made.black);
  }
  return 0;
}

#define FIELD SKYWAVE_FIELD
std::vector<OptionOf<AssembleFlags>> AssembleOptions() {
  constexpr OptionMaker<AssembleFlags> option = {};
  // clang-format off
  return {
    option({.name = "photographs", .help = "of one view at several exposures: JPEG or PNG of 8 bits, whose response is found, or EXR, HDR or PFM in proportion to the light", .scope = OptionScope::kInput, .metavar = "IMG ...", .positional = true, .required = true, .most_values = 1000}, FIELD(photographs), Texts("IMG")),
    option({.name = "times", .help = "exposures, as 1/4000 or 0.25 [s], in the order of the photographs", .scope = OptionScope::kInput, .default_text = "those that cameras write into JPEGs", .metavar = "T,T,...", .most_values = 1000, .delimiter = ','}, FIELD(times), Texts("T,T,...")),
    option({.name = "align", .help = "move photographs over each other; without: they stay, as from a tripod"}, FIELD(align), Switches()),
    option({.name = "crop", .help = "write this part alone, such as the square that a mirror ball fills", .default_text = "all"}, FIELD(crop), Crops()),
    option({.name = "response", .help = "what finds the response of the camera and the mean of exposures: least squares of logarithms (Debevec and Malik 1997), or the most likely light (Robertson et al. 2003)"}, FIELD(response), NamesOfEnum<ResponseMethod>()),
    option({.name = "output", .help = "EXR, HDR or PFM", .letter = 'o', .required = true}, FIELD(output), Texts("FILE")),
    option({.name = "trust-input", .help = "decode rare kinds of EXR in this process, not in a confined one"}, FIELD(limits.trust_input), Switches()),
  };
  // clang-format on
}
#undef FIELD

}  // namespace

Command ProbeAssembleCommand() {
  return CommandOf<AssembleFlags>(
      {.name = "assemble",
       .summary = "A picture of radiance from photographs at several exposures",
       .footer = "Examples:\n"
                 "  skywave probe assemble ball-*.jpg --crop 1200x1200+640+380 -o ball.exr\n"
                 "  skywave probe assemble a.png b.png c.png --times 1/250,1/15,1 -o view.exr\n"
                 "  skywave probe convert ball.exr sky.exr --projection mirror-ball --to latlong"},
      AssembleOptions(), AssembleMain);
}

}  // namespace skywave
