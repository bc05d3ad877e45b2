// Implements skywave probe plot: pictures of a map, its lights, cells and strata.
#include <array>

#include "base/files.h"
#include "cli/print.h"
#include "cli/probe/commands.h"
#include "lights/probe/plot.h"

namespace skywave {
namespace {

struct PlotFlags {
  MapFlags map;
  LightRequest request;
  PlotRequest plot;
  std::string output, what = "map", view = "latlong", side = "front";
};

PlotView ViewOf(const PlotFlags& flags) {
  if (flags.view == "latlong") return PlotView::kLatLong;
  constexpr std::pair<const char*, PlotView> kSides[] = {
      {"front", PlotView::kFront}, {"back", PlotView::kBack}, {"left", PlotView::kLeft},
      {"right", PlotView::kRight}, {"up", PlotView::kUp},     {"down", PlotView::kDown}};
  for (const auto& [name, view] : kSides) {
    if (flags.side == name) return view;
  }
  return PlotView::kFront;
}

int PlotMain(PlotFlags& flags) {
  CheckOutputs(std::array{flags.output}, std::array{flags.map.path});
  const Image latlong = ReadProbeAsLatLong(flags.map);
  const SphereMap map = MakeSphereMap(latlong);
  ProbeLights lights;
  if (flags.what == "lights" || flags.what == "cells") {
    lights = MakeProbeLights(map, flags.request);
    flags.plot.lights = lights.set.lights;
    if (flags.what == "cells") flags.plot.cells = &lights.set.cell_of_texel;
  } else if (flags.what == "strata") {
    lights.strata = DivideMap(map, flags.request.strata.value_or(StrataRequest{}));
  }
  if (lights.strata) flags.plot.strata = &*lights.strata;
  flags.plot.view = ViewOf(flags);
  int width, height;
  const std::vector<std::uint8_t> rgb = PlotMap(map, flags.plot, width, height);
  WritePng(flags.output, width, height, rgb);
  Print(stdout, "wrote {}\n", flags.output);
  return 0;
}

#define FIELD SKYWAVE_FIELD
std::vector<OptionOf<PlotFlags>> PlotOptions() {
  constexpr OptionMaker<PlotFlags> option = {};
  const auto log_color =
      Codec<bool>{.values = "log|tone",
                  .metavar = "log|tone",
                  .parse = [](const std::string& text) -> std::optional<bool> {
                    if (text != "log" && text != "tone") return std::nullopt;
                    return text == "log";
                  },
                  .print = [](const bool& log) { return std::string(log ? "log" : "tone"); }};
  // clang-format off
  return {
    option({.name = "output", .help = "PNG file", .letter = 'o', .required = true}, FIELD(output), Texts("PNG")),
    option({.name = "what", .help = "the map, its lights, their cells as well, or its strata"}, FIELD(what), OneOf("map|lights|cells|strata")),
    option({.name = "view", .help = "the whole map, or the sphere from outside"}, FIELD(view), OneOf("latlong|sphere")),
    option({.name = "side", .help = "side from which the sphere is seen"}, FIELD(side), OneOf("front|back|left|right|up|down")),
    option({.name = "color", .help = "false colour of log luminance, or tone-mapped"}, FIELD(plot.log_color), log_color),
    option({.name = "exposure", .help = "exposure with --color tone [stops]"}, FIELD(plot.exposure_stops), Floats(-100, 100)),
    option({.name = "height", .help = "height of the picture [pixels]"}, FIELD(plot.height), Numbers(1, 8192)),
  };
  // clang-format on
}
#undef FIELD

}  // namespace

Command ProbePlotCommand() {
  const auto flags = std::make_shared<PlotFlags>();
  Command command = {
      .name = "plot",
      .summary = "PNG of a map, its lights, cells and strata",
      .footer =
          "Examples:\n"
          "  skywave probe plot sky.exr --what cells --method penrose -n 360 -o cells.png\n"
          "  skywave probe plot sky.exr --what strata --view sphere --side up -o strata.png",
      .run = [flags](const GivenOptions&) { return PlotMain(*flags); }};
  AddMapOptions(command, std::shared_ptr<MapFlags>(flags, &flags->map));
  AddLightOptions(command, std::shared_ptr<LightRequest>(flags, &flags->request));
  const auto options = PlotOptions();
  AddOptions(command, options, flags);
  return command;
}

}  // namespace skywave
