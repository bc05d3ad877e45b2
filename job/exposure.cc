#include "job/exposure.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <optional>

#include "base/error.h"

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
  const Codec<ExposureChoice> choice = {
      .values = "auto or stops in [-100, 100]",
      .metavar = "auto|STOPS",
      .parse = [stops =
                    Floats(-100, 100)](const std::string& text) -> std::optional<ExposureChoice> {
        if (text == "auto") return ExposureChoice{.automatic = true};
        const std::optional<float> number = stops.parse(text);
        if (!number) return std::nullopt;
        return ExposureChoice{.stops = *number};
      },
      .print =
          [](const ExposureChoice& c) {
            return c.automatic ? "auto" : fmt::format("{}", c.stops);
          }};
  // clang-format off
  return {
    option({.name = "exposure", .help = "[stops], added to the camera's; auto: by the picture itself", .example = "--exposure 1.5", .default_text = "auto for a map of `env`, else 0"}, FIELD(exposure), choice),
    option({.name = "shutter", .help = "exposure time of a camera for which radiance is luminance in cd/m^2", .example = "--shutter 1/60 --f-number 8", .needs = "f-number"}, FIELD(photo.shutter_seconds), seconds),
    option({.name = "f-number", .help = "f-number of its lens", .example = "--shutter 1/60 --f-number 8", .needs = "shutter"}, FIELD(photo.f_number), Unless(0.0f, Floats(0.1, 1000))),
    option({.name = "iso", .help = "speed of its sensor", .example = "--shutter 1/60 --f-number 8 --iso 200", .needs = "shutter"}, FIELD(photo.iso), Floats(0.1, 1e8)),
    option({.name = "tone", .help = "tone curve of the PNG", .example = "--tone filmic"}, FIELD(curve), NamesOfEnum<ToneCurve>()),
  };
  // clang-format on
}
#undef FIELD

ExposureRequest ResolveExposure(ExposureRequest request, const JobRequest& job) {
  const bool has_map = job.environment.has_map();
  if (request.photo.shutter_seconds > 0) {
    if (request.exposure && request.exposure->automatic) {
      throw OptionError("exposure", "auto", "is what `shutter` decides; give stops, or neither");
    }
  } else if (!request.exposure && has_map) {
    request.exposure = ExposureChoice{.automatic = true};
  }
  return request;
}

bool IsAutomatic(const ExposureRequest& resolved) {
  return resolved.exposure && resolved.exposure->automatic;
}

AovSet MeteredLayers() {
  static const AovSet layers = ParseAovs("coverage").value();
  return layers;
}

ToneMapping Tone(const ExposureRequest& resolved, const Image& image,
                 std::span<const NamedChannel> layers) {
  const ExposureChoice choice = resolved.exposure.value_or(ExposureChoice());
  ToneMapping tone = {.exposure_stops = choice.stops, .curve = resolved.curve};
  if (choice.automatic) {
    const auto coverage =
        std::find_if(layers.begin(), layers.end(),
                     [](const NamedChannel& channel) { return channel.name == "coverage.V"; });
    tone.exposure_stops = AutomaticExposureStops(
        image, coverage != layers.end() ? coverage->values : std::span<const float>());
  }
  if (resolved.photo.shutter_seconds > 0) tone.exposure_stops += ExposureStops(resolved.photo);
  return tone;
}

}  // namespace skywave
