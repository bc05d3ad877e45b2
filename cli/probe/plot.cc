// Implements skywave probe plot: pictures of a map, its lights, cells and strata, and curves of how
// it is sampled.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <memory>
#include <numbers>
#include <optional>
#include <set>

#include "base/error.h"
#include "base/files.h"
#include "bench/measure/plot.h"
#include "cli/print.h"
#include "cli/probe/commands.h"
#include "job/sample_counts.h"
#include "lights/light_sets/penrose.h"
#include "lights/probe/densities.h"
#include "lights/probe/plot.h"
#include "lights/tables/max_pyramid.h"
#include "scene/scene_hash.h"

namespace skywave {
namespace {

struct PlotFlags {
  MapFlags map;
  LightRequest request;
  PlotRequest plot;
  std::string output, what = "map", view = "latlong", side = "front";
  JobRequest job;  // of `what samples`
  std::optional<double> column;

  bool has_curves() const { return what == "thresholds" || what == "densities"; }
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

int WritePlot(PlotFlags& flags, const SphereMap& map) {
  flags.plot.view = ViewOf(flags);
  int width, height;
  const std::vector<std::uint8_t> rgb = PlotMap(map, flags.plot, width, height);
  WritePng(flags.output, width, height, rgb);
  Print(stdout, "wrote {}\n", flags.output);
  return 0;
}

Plot Curve(const char* title, const char* x, const char* y, std::vector<PlotPoint> points) {
  return {.title = title,
          .x_label = x,
          .y_label = y,
          .series = {{y, std::move(points)}},
          .markers = false};
}

// f, g and zeta over the share of the sphere that the bright part has, and where it ends (T figures
// 7.9 to 7.17).
std::vector<Plot> CurvesOfThresholds(const SphereMap& map, const Strata& strata) {
  constexpr std::size_t kPoints = 600;
  constexpr char kShare[] = "x: share of the sphere, brightest texels first";
  const double whole = 4 * std::numbers::pi;
  std::vector<PlotPoint> f, g, zeta;
  for (const StratumPrefix& prefix : PrefixesOf(map, kPoints)) {
    const double x = prefix.area / whole;
    f.push_back({x, prefix.luminance});
    g.push_back({x, map.energy > 0 ? prefix.energy / map.energy : 0});
    zeta.push_back({x, prefix.zeta});
  }
  std::vector<Plot> plots = {Curve("Luminance of the dimmest texel", kShare, "f(x)", std::move(f)),
                             Curve("Share of the energy", kShare, "g(x)", std::move(g)),
                             Curve("What two trapezia leave", kShare, "zeta(x)", std::move(zeta))};
  plots[1].y_scale = PlotScale::kLinear;
  for (Plot& plot : plots) {
    plot.marks = {{fmt::format("A ends, p = {:.4g}", strata.p), strata.solid_angle_a / whole}};
  }
  return plots;
}

// p(u) and p(v | u) with their integrals (T figures 6.3 to 6.7). `at` is u; unset: that of the
// texel with most energy.
std::vector<Plot> CurvesOfDensities(const SphereMap& map, std::optional<double> at) {
  const int column = at ? std::min(int(*at * map.width), map.width - 1) : BrightestColumn(map);
  std::vector<Plot> plots;
  const auto add = [&](const TexelDensity1D& of, const std::string& name, const char* variable) {
    std::vector<PlotPoint> density, cumulative = {{0, 0}};
    const auto count = double(of.density.size());
    for (std::size_t i = 0; i < of.density.size(); ++i) {
      const double begin = double(i) / count, end = double(i + 1) / count;
      density.push_back({begin, of.density[i]}), density.push_back({end, of.density[i]});
      cumulative.push_back({end, of.cumulative[i]});
    }
    plots.push_back(Curve("Density", variable, name.c_str(), std::move(density)));
    plots.push_back(Curve("Cumulative distribution", variable, ("P" + name.substr(1)).c_str(),
                          std::move(cumulative)));
  };
  add(ColumnDensity(map), "p(u)", "u");
  add(RowDensity(map, column), fmt::format("p(v | u = {:.4g})", (column + 0.5) / map.width), "v");
  for (Plot& plot : plots) plot.x_scale = plot.y_scale = PlotScale::kLinear;
  return plots;
}

// Throws OptionError for an option that is about another kind of plot.
void RequireUsed(const GivenOptions& given, const std::string& what) {
  using Names = std::set<std::string_view>;
  static const Names kOfLights = {"method", "lights",  "position",   "longest",  "lloyd",
                                  "seed",   "cluster", "separation", "clusters", "strata"};
  static const std::map<std::string_view, Names> kUsed = {
      {"lights", kOfLights},
      {"cells", kOfLights},
      {"strata", {"strata"}},
      {"thresholds", {"strata"}},
      {"samples", {"scene", "strategy", "spp"}},
      {"merging", {"method", "lights", "longest", "seed", "cluster", "separation", "clusters"}},
      {"plane", {"lights", "seed"}},
      {"densities", {"column"}}};
  const auto used = kUsed.find(what);
  for (const auto& [other, options] : kUsed) {
    for (const std::string_view option : options) {
      if (!given.contains(option) || (used != kUsed.end() && used->second.contains(option)))
        continue;
      throw OptionError(std::string(option), "",
                        fmt::format("has nothing to say of `what {}`", what));
    }
  }
}

// Returns how often a render of the scene samples each texel of the map (T figure 7.3).
Image CountsOf(PlotFlags& flags, const Image& latlong) {
  if (flags.job.scene.empty()) {
    throw OptionError("scene", "", "is missing: `what samples` is of a render");
  }
  EnvironmentRequest& environment = flags.job.environment;
  environment.image = std::make_shared<Image>(latlong);
  environment.image_hash = MapHash(latlong);
  environment.projection = Projection::kLatLong;
  constexpr std::uint32_t kSamples = 4;
  flags.job.samples_per_pixel = flags.job.samples_per_pixel.value_or(kSamples);
  Image counts = CountSamples(RenderJob(flags.job));
  double samples = 0;
  for (std::size_t i = 0; i < counts.rgb.size(); i += 3) samples += double(counts.rgb[i]);
  Print(stdout, "{:.0f} light samples\n", samples);
  return counts;
}

// Returns the dots of lights before and after they are merged, in the thesis's colours.
std::vector<PlotDots> DotsOfMerging(const SphereMap& map, const LightOptions& options) {
  if (!options.cluster) {
    throw OptionError("cluster", "none", "merges no lights: `what merging` needs F1, F2 or F3");
  }
  MergedSamples samples = MergeSamples(map, options);
  Print(stdout, "{} lights stay, {} are merged into {}\n", samples.kept.size(),
        samples.merged.size(), samples.made.size());
  return {{std::move(samples.merged), {0.9, 0.1, 0.1}},
          {std::move(samples.kept), {0.1, 0.1, 0.1}},
          {std::move(samples.made), {0.1, 0.8, 0.2}}};
}

int PlotMain(PlotFlags& flags, const GivenOptions& given) {
  CheckOutputs(std::array{flags.output}, std::array{flags.map.path});
  const bool svg = flags.output.ends_with(".svg");
  if (svg != flags.has_curves()) {
    throw OptionError("output", flags.output,
                      fmt::format("`what {}` makes {}: name a file that ends in {}", flags.what,
                                  svg ? "a picture" : "curves", svg ? ".png" : ".svg"));
  }
  RequireUsed(given, flags.what);
  const Image latlong = ReadProbeAsLatLong(flags.map);
  const SphereMap map = MakeSphereMap(latlong);
  if (flags.has_curves()) {
    const std::vector<Plot> plots =
        flags.what == "thresholds"
            ? CurvesOfThresholds(map,
                                 DivideMap(map, flags.request.strata.value_or(StrataRequest{})))
            : CurvesOfDensities(map, flags.column);
    WriteFileAtomically(flags.output, Svg(plots));
    Print(stdout, "wrote {}\n", flags.output);
    return 0;
  }
  if (flags.what == "density") {
    const Image density = JointDensity(map);
    return WritePlot(flags, MakeSphereMap(density));
  }
  if (flags.what == "samples") {
    const Image counts = CountsOf(flags, latlong);
    return WritePlot(flags, MakeSphereMap(counts));
  }
  if (flags.what == "merging") flags.plot.dots = DotsOfMerging(map, flags.request.lights);
  if (flags.what == "plane") {
    const LightOptions& lights = flags.request.lights;
    const PenroseSet samples =
        PenroseSamples(PlanePyramid(map), lights.lights, {.seed = lights.seed});
    flags.plot.dots = {{Directions(samples), {0.1, 0.1, 0.1}}};
  }
  ProbeLights lights;
  if (flags.what == "lights" || flags.what == "cells") {
    lights = MakeProbeLights(map, flags.request);
    flags.plot.lights = lights.set.lights;
    if (flags.what == "cells") flags.plot.cells = &lights.set.cell_of_texel;
  } else if (flags.what == "strata") {
    lights.strata = DivideMap(map, flags.request.strata.value_or(StrataRequest{}));
  }
  if (lights.strata) flags.plot.strata = &*lights.strata;
  return WritePlot(flags, map);
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
    option({.name = "output", .help = "PNG file; curves: SVG", .letter = 'o', .required = true}, FIELD(output), Texts("PNG|SVG")),
    option({.name = "what", .help = "the map, its lights, their cells as well, its strata, or its density p(u, v); how often a render samples it (T 7.3), lights that are merged (red) into others (green) and those that stay (T 7.18), or Penrose samples as if it were a plane (T 5.4a); curves: of the densities p(u) and p(v | u), or of thresholds, f, g and zeta of the strata (T 7.9 to 7.17)"}, FIELD(what), OneOf("map|lights|cells|strata|density|samples|merging|plane|densities|thresholds")),
    option({.name = "scene", .help = "scene that `what samples` renders"}, FIELD(job.scene), Texts("SCENE")),
    option({.name = "strategy", .help = "its strategy", .default_text = "importance", .metavar = "NAME[:KEY=VALUE,...]"}, FIELD(job.strategy), Texts("a strategy")),
    option({.name = "spp", .help = "its samples per pixel", .default_text = "4"}, FIELD(job.samples_per_pixel), Numbers(1u, 1u << 16)),
    option({.name = "column", .help = "u of the column of `what densities`", .default_text = "the brightest"}, FIELD(column), Numbers(0.0, 1.0)),
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
          "  skywave probe plot sky.exr --what strata --view sphere --side up -o strata.png\n"
          "  skywave probe plot sky.exr --what samples --scene spheres -o samples.png\n"
          "  skywave probe plot sky.exr --what thresholds -o curves.svg",
      .run = [flags](const GivenOptions& given) { return PlotMain(*flags, given); }};
  AddMapOptions(command, std::shared_ptr<MapFlags>(flags, &flags->map));
  AddLightOptions(command, std::shared_ptr<LightRequest>(flags, &flags->request));
  const auto options = PlotOptions();
  AddOptions(command, options, flags);
  return command;
}

}  // namespace skywave
