#include "job/exposure.h"

#include <fmt/format.h>

#include <charconv>
#include <optional>

namespace skywave {
namespace {

// Parses 1/125 or 0.008.
std::optional<float> ParseShutter(const std::string& text) {
  const std::size_t slash = text.find('/');
  float value = 0, divisor = 1;
  const auto number = [](std::string_view part, float& to) {
    const auto [stop, error] = std::from_chars(part.data(), part.data() + part.size(), to);
    return error == std::errc() && stop == part.data() + part.size() && to > 0;
  };
  const std::string_view whole = text;
  if (!number(whole.substr(0, slash), value)) return std::nullopt;
  if (slash != std::string::npos && !number(whole.substr(slash + 1), divisor)) return std::nullopt;
  const float seconds = value / divisor;
  return seconds >= 1e-9f && seconds <= 1e9f ? std::optional(seconds) : std::nullopt;
}

}  // namespace

#define FIELD SKYWAVE_FIELD
std::vector<OptionOf<ExposureRequest>> ExposureOptions() {
  const auto option = [](OptionInfo info, auto field, auto codec) {
    info.group = "Exposure of the PNG";
    info.scope = OptionScope::kPixels;
    return MakeOption<ExposureRequest>(info, field, codec);
  };
  const Codec<float> seconds = {
      .values = "seconds or 1/SECONDS, for example 1/125",
      .metavar = "SECONDS|1/N",
      .parse = ParseShutter,
      .print = [](const float& s) { return s > 0 ? fmt::format("{}", s) : std::string(); }};
  // clang-format off
  return {
    option({.name = "exposure", .help = "[stops], added to the camera's", .example = "--exposure 1.5"}, FIELD(tone.exposure_stops), Floats(-100, 100)),
    option({.name = "shutter", .help = "exposure time of a camera for which radiance is luminance in cd/m^2", .example = "--shutter 1/60 --f-number 8", .needs = "f-number"}, FIELD(photo.shutter_seconds), seconds),
    option({.name = "f-number", .help = "f-number of its lens", .example = "--shutter 1/60 --f-number 8", .needs = "shutter"}, FIELD(photo.f_number), Unless(0.0f, Floats(0.1, 1000))),
    option({.name = "iso", .help = "speed of its sensor", .example = "--shutter 1/60 --f-number 8 --iso 200", .needs = "shutter"}, FIELD(photo.iso), Floats(0.1, 1e8)),
    option({.name = "tone", .help = "tone curve of the PNG", .example = "--tone filmic"}, FIELD(tone.curve), NamesOfEnum<ToneCurve>()),
  };
  // clang-format on
}
#undef FIELD

ToneMapping Tone(const ExposureRequest& request) {
  ToneMapping tone = request.tone;
  if (request.photo.shutter_seconds > 0) tone.exposure_stops += ExposureStops(request.photo);
  return tone;
}

}  // namespace skywave
