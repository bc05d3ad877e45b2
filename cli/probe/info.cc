// Implements skywave probe info: the contents of a map.
#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "base/files.h"
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

nlohmann::ordered_json Json(const ProbeFile& file, const ProbeInfo& info) {
  const Strata& s = info.strata;
  const double pixels_per_sr = info.sphere_pixels / (4 * std::numbers::pi);
  nlohmann::ordered_json json;
  json["schema"] = "skywave-probe-info-1";
  json["width"] = file.image.width;
  json["height"] = file.image.height;
  json["projection"] = ToString(file.projection);
  json["projection_assumed"] = file.assumed;
  json["bad_pixels"] = {
      {"nan", file.bad.nan}, {"infinite", file.bad.infinite}, {"negative", file.bad.negative}};
  json["luminance"] = {{"least", info.least}, {"greatest", info.greatest}};
  json["mean_radiance"] = info.mean;
  json["energy"] = info.energy;
  json["table_7_1"] = {{"latlong", {info.width, info.height}},
                       {"sphere_area", info.sphere_pixels},
                       {"energy", info.energy_pixels},
                       {"zeta_minimum", info.zeta_minimum},
                       {"p", s.p},
                       {"threshold", s.texels_a ? s.threshold : 0},
                       {"texels_a", s.texels_a},
                       {"area_a", s.solid_angle_a * pixels_per_sr},
                       {"texels_b", s.texels_b},
                       {"area_b", s.solid_angle_b * pixels_per_sr},
                       {"energy_a", s.energy_a * pixels_per_sr},
                       {"energy_b", s.energy_b * pixels_per_sr}};
  for (const BrightSpot& spot : info.spots) {
    json["spots"].push_back({{"x", spot.x},
                             {"y", spot.y},
                             {"direction", {spot.direction.x, spot.direction.y, spot.direction.z}},
                             {"luminance", spot.luminance},
                             {"share", spot.share}});
  }
  return json;
}

void Print(const InfoFlags& flags, const ProbeFile& file, const ProbeInfo& info) {
  const double pixels_per_sr = info.sphere_pixels / (4 * std::numbers::pi);
  const auto row = [](const char* name, const std::string& value) {
    fmt::print("{:<22}{}\n", name, value);
  };
  row("map", flags.map.path);
  row("size", fmt::format("{} x {}", file.image.width, file.image.height));
  row("projection",
      fmt::format("{} ({})", ToString(file.projection), file.assumed ? "as told" : "by shape"));
  row("bad pixels", fmt::format("{} NaN, {} infinite, {} negative", file.bad.nan, file.bad.infinite,
                                file.bad.negative));
  row("luminance",
      fmt::format("{:.6g} to {:.6g}{}", info.least, info.greatest,
                  info.greatest > 0 ? fmt::format(", {:.1f} stops above the dimmest light",
                                                  std::log2(info.greatest / info.least_positive))
                                    : ""));
  row("mean radiance",
      fmt::format("{:.6g} {:.6g} {:.6g}", info.mean[0], info.mean[1], info.mean[2]));
  row("energy", fmt::format("{:.8g} luminance * sr", info.energy));
  fmt::print("\nbrightest spots, {} degrees apart, and the share of the energy within that\n",
             kSpotRadiusDegrees);
  fmt::print("{:>6}{:>6}{:>10}{:>10}{:>10}{:>13}{:>9}\n", "x", "y", "right", "forward", "up",
             "luminance", "share");
  for (const BrightSpot& s : info.spots) {
    fmt::print("{:>6}{:>6}{:>10.4f}{:>10.4f}{:>10.4f}{:>13.6g}{:>8.2f}%\n", s.x, s.y, s.direction.x,
               s.direction.y, s.direction.z, s.luminance, 100 * s.share);
  }
  const Strata& s = info.strata;
  fmt::print("\nstrata by the greatest variation (areas and energies in pixels of {} x {})\n",
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
  ProbeFile file = ReadProbe(flags.map);
  const Image latlong = ToLatLong(file.image, file.projection);
  const ProbeInfo info = DescribeMap(MakeSphereMap(latlong), flags.spots);
  Print(flags, file, info);
  if (!flags.json.empty()) WriteFileAtomically(flags.json, Json(file, info).dump(2) + "\n");
  return 0;
}

#define FIELD SKYWAVE_FIELD
std::vector<OptionOf<InfoFlags>> InfoOptions() {
  const auto option = [](OptionInfo info, auto field, auto codec) {
    return MakeOption<InfoFlags>(info, field, codec);
  };
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
