// Implements skywave probe plot: pictures of a map, its lights, cells and strata.
#include <fmt/format.h>

#include "base/files.h"
#include "cli/flags.h"
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
  CheckWritable(flags.output);
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
  fmt::print("wrote {}\n", flags.output);
  return 0;
}

}  // namespace

void AddProbePlotCommand(CLI::App& probe, Run& run) {
  CLI::App* command = probe.add_subcommand("plot", "PNG of a map, its lights, cells and strata");
  const auto flags = std::make_shared<PlotFlags>();
  AddMapFlags(*command, flags->map);
  AddLightFlags(*command, flags->request);
  command->add_option("-o,--output", flags->output, "PNG file")->required();
  command->add_option("--what", flags->what, "map, lights, cells (with their lights) or strata")
      ->check(CLI::IsMember({"map", "lights", "cells", "strata"}))
      ->capture_default_str();
  command->add_option("--view", flags->view, "the whole map, or the sphere from outside")
      ->check(CLI::IsMember({"latlong", "sphere"}))
      ->capture_default_str();
  command->add_option("--side", flags->side, "where the sphere is seen from")
      ->check(CLI::IsMember({"front", "back", "left", "right", "up", "down"}))
      ->capture_default_str();
  command
      ->add_option_function<std::string>(
          "--color", [flags](const std::string& text) { flags->plot.log_color = text == "log"; },
          "false colour of log luminance, or tone-mapped (default: log)")
      ->check(CLI::IsMember({"log", "tone"}));
  command->add_option("--exposure", flags->plot.exposure_stops, "of --color tone [stops]")
      ->check(FiniteNumber(-100, 100));
  command->add_option("--height", flags->plot.height, "of the picture [pixels]")
      ->capture_default_str();
  command->footer(
      "Examples:\n"
      "  skywave probe plot sky.exr --what cells --method penrose -n 360 -o cells.png\n"
      "  skywave probe plot sky.exr --what strata --view sphere --side up -o strata.png");
  command->callback([flags, &run] { run = [flags] { return PlotMain(*flags); }; });
}

}  // namespace skywave
