// Implements skywave probe info: the contents of a map.
#include <fmt/format.h>

#include <array>
#include <cmath>
#include <numbers>

#include "base/files.h"
#include "bench/measure/json_reports.h"
#include "cli/print.h"
#include "cli/probe/commands.h"
#include "lights/maps/projections.h"
#include "lights/maps/resample.h"
#include "lights/probe/probe_info.h"

namespace skywave {
namespace {

struct InfoFlags {
  MapFlags map;
  int spots = 5;
  std::string json;
};

void PrintProbe(const InfoFlags& flags, const ProbeMap& map, const ProbeInfo& info) {
  const double pixels_per_sr = info.sphere_pixels / (4 * std::numbers::pi);
  const auto row = [](const char* name, const std::string& value) {
    Print(stdout, "{:<22}{}\n", name, value);
  };
  row("map", flags.map.path);
  row("size", fmt::format("{} x {}", map.image.width, map.image.height));
  row("projection",
      fmt::format("{} ({})", ToString(map.projection), map.assumed ? "as given" : "by shape"));
  row("bad pixels", fmt::format("{} NaN, {} infinite, {} negative", map.bad.nan, map.bad.infinite,
                                map.bad.negative));
  row("luminance",
      fmt::format("{:.6g} to {:.6g}{}", info.least, info.greatest,
                  info.greatest > 0 ? fmt::format(", {:.1f} stops above the dimmest light",
                                                  std::log2(info.greatest / info.least_positive))
                                    : ""));
  row("mean radiance",
      fmt::format("{:.6g} {:.6g} {:.6g}", info.mean[0], info.mean[1], info.mean[2]));
  row("energy", fmt::format("{:.8g} luminance * sr", info.energy));
  Print(stdout, "\nbrightest spots, {} degrees apart, and the share of the energy within that\n",
        kSpotRadiusDegrees);
  Print(stdout, "{:>6}{:>6}{:>10}{:>10}{:>10}{:>13}{:>9}\n", "x", "y", "right", "forward", "up",
        "luminance", "share");
  for (const BrightSpot& s : info.spots) {
    Print(stdout, "{:>6}{:>6}{:>10.4f}{:>10.4f}{:>10.4f}{:>13.6g}{:>8.2f}%\n", s.x, s.y,
          s.direction.x, s.direction.y, s.direction.z, s.luminance, 100 * s.share);
  }
  const Strata& s = info.strata;
  Print(stdout, "\nstrata by the greatest variation (areas and energies in pixels of {} x {})\n",
        info.width, info.height);
  row("spherical area", fmt::format("{:.2f}", info.sphere_pixels));
  row("energy", fmt::format("{:.2f}", info.energy_pixels));
  row("minimum of zeta", fmt::format("{:.2f}", info.zeta_minimum));
  row("p", fmt::format("{:.5f}", s.p));
  row("luminance threshold", fmt::format("{:.6g}", s.threshold));
  row("texels A, B", fmt::format("{}, {}", s.texels_a, s.texels_b));
  row("area A, B",
      fmt::format("{:.2f}, {:.2f} ({:.3f} %, {:.3f} %)", s.solid_angle_a * pixels_per_sr,
                  s.solid_angle_b * pixels_per_sr, s.solid_angle_a * 25 / std::numbers::pi,
                  s.solid_angle_b * 25 / std::numbers::pi));
  row("energy A, B",
      fmt::format("{:.2f}, {:.2f}", s.energy_a * pixels_per_sr, s.energy_b * pixels_per_sr));
}

int InfoMain(const InfoFlags& flags) {
  CheckOutputs(std::array{flags.json}, std::array{flags.map.path});
  ProbeMap map = ReadProbe(flags.map);
  const Image latlong = ToLatLong(map.image, map.projection);
  const ProbeInfo info = DescribeMap(MakeSphereMap(latlong), flags.spots);
  PrintProbe(flags, map, info);
  if (!flags.json.empty()) WriteFileAtomically(flags.json, JsonText(map, info) + "\n");
  return 0;
}

#define FIELD SKYWAVE_FIELD
std::vector<OptionOf<InfoFlags>> InfoOptions() {
  constexpr OptionMaker<InfoFlags> option = {};
  // clang-format off
  return {
    option({.name = "spots", .help = "brightest spots to list"}, FIELD(spots), Numbers(0, 1000)),
    option({.name = "json", .help = "write the same as JSON"}, FIELD(json), Texts("JSON")),
  };
  // clang-format on
}
#undef FIELD

}  // namespace

Command ProbeInfoCommand() {
  const auto flags = std::make_shared<InfoFlags>();
  Command command = {.name = "info",
                     .summary = "What is in a map",
                     .run = [flags](const GivenOptions&) { return InfoMain(*flags); }};
  AddMapOptions(command, std::shared_ptr<MapFlags>(flags, &flags->map));
  const auto options = InfoOptions();
  AddOptions(command, options, flags);
  return command;
}

}  // namespace skywave
