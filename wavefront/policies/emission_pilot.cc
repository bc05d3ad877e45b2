#include "wavefront/policies/emission_pilot.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <numbers>
#include <numeric>
#include <utility>

#include "base/clock.h"
#include "kernels/light_paths/emission_guide.h"
#include "lights/maps/sphere_map.h"
#include "lights/strategies/importance.h"
#include "wavefront/paths/pilot.h"
#include "wavefront/policy.h"
#include "wavefront/render_option.h"
#include "wavefront/stages/path_stages.h"

namespace skywave {
namespace {

// Collects the guide samples of the paths of a wave, line by line, places first, then weights.
class GuideSampleList {
 public:
  GuideSampleList(const FrameView& pilot, const PilotQuestion& question,
                  std::vector<GuideSample>& samples)
      : pilot_(pilot),
        sphere_(pilot.sphere),
        question_(question),
        surfaces_met_(pilot.options.wave),
        places_(pilot.options.wave),
        unit_(std::accumulate(question.radiance.begin(), question.radiance.end(), 0.0) /
              double(question.radiance.size()) / kGuideSampleUnits),
        needs_(samples) {}

  void SeeRays(const Worker&, const RayColumns&, std::uint32_t) {}

  // Adds what rays [0, n) that left the current surfaces see of the environment, as the strategy
  // has it.
  void SeeEscapes(const Worker& w, std::uint32_t n) {
    pilot_.strategy->EvaluateEscaped(Points(pilot_, w), n,
                                     pilot_.light_shares().strategy_samples(1), w.escaped);
    const EscapeColumns& rays = w.escaped;
    LocateOnDisk(sphere_, {rays.dir_x, rays.dir_y, rays.dir_z, w.surfaces, rays.from}, n, places_);
    for (std::uint32_t i = 0; i < n; ++i) {
      const bool delta = !(rays.pdf[i] > 0);
      const std::uint32_t path = rays.path[i];
      if (surfaces_met_[path] < (delta ? 1 : question_.least_surfaces)) continue;
      const double ratio = delta ? 0 : double(rays.light_pdf[i]) / rays.pdf[i];
      const double seen =
          delta ? question_.radiance[places_->cell[i]]
                : Luminance(rays.radiance_r[i], rays.radiance_g[i], rays.radiance_b[i]);
      const double throughput =
          Luminance(rays.throughput_r[i], rays.throughput_g[i], rays.throughput_b[i]);
      Add(w, i, rays.from[i], path, throughput * seen / (1 + ratio * ratio));
    }
  }

  // Counts surfaces [0, n), which have a density, for their paths, and adds those of their light
  // samples that have arrived from infinitely far away.
  void SeeLightSamples(const Worker& w, std::uint32_t n) {
    for (std::uint32_t i = 0; i < n; ++i) ++surfaces_met_[w.surfaces->path[i]];
    const LightColumns& lights = w.lights;
    LocateOnDisk(sphere_, {lights.dir_x, lights.dir_y, lights.dir_z, w.surfaces}, n, places_);
    for (std::uint32_t i = 0; i < n; ++i) {
      const std::uint32_t path = w.surfaces->path[i];
      // Occluded rays have a negative reach.
      const bool arrives = lights.t_far[i] == std::numeric_limits<float>::infinity();
      if (!arrives || surfaces_met_[path] < question_.least_surfaces) continue;
      Add(w, i, i, path, Luminance(lights.r[i], lights.g[i], lights.b[i]));
    }
  }

 private:
  // Adds line i, which goes through surface `row`.
  void Add(const Worker& w, std::uint32_t i, std::uint32_t row, std::uint32_t path,
           double luminance) {
    constexpr double kMost = 0x1p40;
    const double weight = luminance / unit_;
    if (!(weight >= 1)) return;
    needs_.push_back(
        {.cell = places_->cell[i],
         .u = std::clamp(places_->u[i], 0.0f, 1.0f),
         .v = std::clamp(places_->v[i], 0.0f, 1.0f),
         .point = {w.surfaces->org_x[row], w.surfaces->org_y[row], w.surfaces->org_z[row]},
         .pixel = w.paths->pixel[path],
         .weight = std::uint64_t(std::min(weight, kMost))});
  }

  const FrameView& pilot_;
  SceneSphere sphere_;
  PilotQuestion question_;
  std::vector<std::uint32_t> surfaces_met_;
  soa::Table<DiskPlaceColumns> places_;
  double unit_;
  std::vector<GuideSample>& needs_;
};

// Turns the weights of a pixel into parts of their sum, so that dark pixels count as much as bright
// ones: noise is seen against what it lies on. Pixels darker than the mean by more than kDarkest
// count less.
void MakeRelative(std::vector<GuideSample>& samples, std::size_t pixels) {
  constexpr std::uint64_t kDarkest = 16;
  std::vector<std::uint64_t> sums(pixels);
  for (const GuideSample& sample : samples) sums[sample.pixel] += sample.weight;
  const std::uint64_t least =
      std::accumulate(sums.begin(), sums.end(), std::uint64_t{0}) / pixels / kDarkest + 1;
  for (GuideSample& sample : samples) {
    sample.weight = std::uint64_t(double(sample.weight) / double(sums[sample.pixel] + least) *
                                  kGuideSampleUnits);
  }
}

// With this many columns a map's texels are small against cells of directions.
constexpr int kLeastColumns = 256;

// Returns the same map in more texels.
EnvironmentMap Finer(const EnvironmentMap& map, int factor) {
  const Image& from = map.latlong;
  Image finer(from.width * factor, from.height * factor);
  for (int y = 0; y < finer.height; ++y) {
    for (int x = 0; x < finer.width; ++x) {
      std::copy_n(from.Pixel(x / factor, y / factor), 3, finer.Pixel(x, y));
    }
  }
  return {.latlong = std::move(finer), .map_from_world = map.map_from_world};
}

// Every texel has the cell of its centre, and how often light samples are in it.
struct MapTexels {
  std::vector<std::uint32_t> cell;
  std::vector<double> probability;  // empty if lights of the strategy stand for parts of the map
};
MapTexels LocateTexels(const EnvironmentMap& map, const EnvStrategy& strategy) {
  const Image& image = map.latlong;
  const auto n = std::uint32_t(image.width);
  const std::size_t all = std::size_t(image.width) * std::size_t(image.height);
  MapTexels texels;
  texels.cell.resize(all);
  if (strategy.unbiased()) texels.probability.resize(all);
  // Every column has a horizontal direction, which rows lift.
  std::vector<Vector3> horizon;
  for (std::uint32_t x = 0; x < n; ++x) {
    horizon.push_back(DirectionOfUv((double(x) + 0.5) / image.width, 0.5));
  }
  tbb::parallel_for(tbb::blocked_range<int>(0, image.height), [&](const auto& range) {
    const soa::Table<EscapeColumns> rows(n);
    std::vector<std::uint32_t> cells(PaddedRows(n));
    for (int y = range.begin(); y < range.end(); ++y) {
      const Vector3 row = DirectionOfUv(0.5, (y + 0.5) / image.height);  // forwards
      for (std::uint32_t x = 0; x < n; ++x) {
        const auto world =
            WorldFromMap({row.y * horizon[x].x, row.y * horizon[x].y, row.z}, map.map_from_world);
        rows->dir_x[x] = world[0], rows->dir_y[x] = world[1], rows->dir_z[x] = world[2];
        rows->pdf[x] = 1;
      }
      const std::size_t first = std::size_t(y) * n;
      FindGuideCells(rows->dir_x, rows->dir_y, rows->dir_z, n, cells.data());
      std::copy_n(cells.begin(), n, &texels.cell[first]);
      if (texels.probability.empty()) continue;
      // Strategies that can emit do not look at surfaces.
      const SurfaceColumns surfaces = {};
      const PathColumns paths = {};
      strategy.EvaluateEscaped(
          {.surfaces = surfaces, .ranges = {}, .materials = {}, .paths = paths}, n, 1, rows);
      const double solid_angle = RowSolidAngle(image.width, image.height, y);
      for (std::uint32_t x = 0; x < n; ++x) {
        texels.probability[first + x] = double(rows->light_pdf[x]) * solid_angle;
      }
    }
  });
  return texels;
}

// Returns the mean luminance of each cell. A cell smaller than a texel may have no texel's centre:
// it gets the mean of all.
std::vector<double> CellRadiance(const Image& image, std::span<const std::uint32_t> cells) {
  std::vector<double> energy(kGuideCells), solid_angle(kGuideCells);
  double all = 0;
  for (int y = 0; y < image.height; ++y) {
    const double texel = RowSolidAngle(image.width, image.height, y);
    for (int x = 0; x < image.width; ++x) {
      const float* const rgb = image.Pixel(x, y);
      const std::uint32_t cell = cells[std::size_t(y) * std::size_t(image.width) + std::size_t(x)];
      const double luminance = Luminance(rgb);
      energy[cell] += luminance * texel, solid_angle[cell] += texel;
      all += luminance * texel;
    }
  }
  for (std::uint32_t cell = 0; cell < kGuideCells; ++cell) {
    energy[cell] =
        solid_angle[cell] > 0 ? energy[cell] / solid_angle[cell] : all / (4 * std::numbers::pi);
  }
  return energy;
}

}  // namespace

void TracePilotWave(const FrameView& pilot, const WaveRange& range, const PilotQuestion& question,
                    Worker& w, std::vector<GuideSample>& samples) {
  GuideSampleList list(pilot, question, samples);
  FollowPilotPaths(pilot, range, w, list);
}

EmissionGuide LearnEmission(const FrameView& frame, WorkerPool& pool, PilotCounts& counts) {
  const auto start = Clock::now();
  const EnvStrategy& strategy = *frame.emitter;
  const int factor = (kLeastColumns + frame.map->latlong->width - 1) / frame.map->latlong->width;
  std::unique_ptr<EnvironmentMap> finer;
  if (factor > 1) finer = std::make_unique<EnvironmentMap>(Finer(*frame.map, factor));
  const EnvironmentMap& map = finer ? *finer : *frame.map;
  MapTexels texels = LocateTexels(map, strategy);
  const std::vector<double> radiance = CellRadiance(map.latlong, texels.cell);

  const FrameView pilot = PilotView(frame, strategy);
  const Tile tile = PilotTile(pilot);
  // Light samples find light that reaches a surface directly and goes to the eye from there.
  const LightSamples taken = Describe(frame.options.integrator).light_samples;
  const PilotQuestion question = {.radiance = radiance,
                                  .least_surfaces = taken == LightSamples::kNone ? 1u : 2u};
  std::vector<GuideSample> samples = TracePilot<GuideSample>(
      pilot, pool, [&](const WaveRange& range, Worker& worker, std::vector<GuideSample>& found) {
        TracePilotWave(pilot, range, question, worker, found);
      });
  MakeRelative(samples, std::size_t(tile.width) * tile.height);
  counts.paths = PilotPaths(pilot), counts.samples = samples.size();

  // Lights that stand for parts of the map are drawn by their strategy only.
  std::vector<double> shares;
  if (!texels.probability.empty()) {
    shares.resize(kGuideCells);
    for (std::size_t i = 0; i < texels.cell.size(); ++i) {
      shares[texels.cell[i]] += texels.probability[i];
    }
  }
  EmissionGuide guide = MakeGuide(std::move(samples), shares, frame.sphere);
  if (!guide.empty() && !shares.empty()) {
    for (std::size_t i = 0; i < texels.cell.size(); ++i) {
      texels.probability[i] *= double(guide.cells[texels.cell[i]].gain);
    }
    guide.directions = std::make_unique<ImportanceStrategy>(map, texels.probability);
    guide.map = std::move(finer);
  }
  counts.bytes = guide.bytes();
  counts.seconds = SecondsSince(start);
  return guide;
}

namespace {

bool HasLightPaths(Integrator integrator) { return Describe(integrator).has_light_paths(); }

std::span<const RenderOption> Options() {
  // clang-format off
  static const RenderOption table[] = {
      MakeRenderOption({.name = "guide", .group = "Paths", .help = "light paths from the map start where a pilot of camera paths needed them", .scope = OptionScope::kPixels, .example = "--integrator light --guide", .applies = HasLightPaths},
                       SKYWAVE_FIELD_OF(GuideOptions, guide), Switches()),
  };
  // clang-format on
  return table;
}

std::shared_ptr<const void> Teach(FrameView& frame, const Pilots& pilots) {
  const bool wanted = frame.options.of<GuideOptions>().guide;
  if (!wanted || !HasLightPaths(frame.options.integrator) || !frame.has_environment()) {
    return nullptr;
  }
  PilotCounts counts = {.policy = "guide", .found = "lines of light"};
  auto guide = std::make_shared<EmissionGuide>(LearnEmission(frame, pilots.pool, counts));
  pilots.reports.counts.push_back(counts);
  if (!guide->empty()) frame.Show<EmissionGuide>(guide.get());
  return guide;
}

}  // namespace

PolicyDescriptor GuidePolicy() { return {.options = Options, .teach = Teach}; }

}  // namespace skywave
