#include "wavefront/guiding/emission_pilot.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "kernels/light_paths/emission_guide.h"
#include "kernels/partition.h"
#include "wavefront/stages/path_stages.h"

namespace skywave {
namespace {

constexpr std::uint32_t kPilotSeed = 0x5EED9135u;  // turns a frame's seed into the pilot's

// Returns the same film in other pixels.
CameraView WithPixels(CameraView camera, std::uint32_t width, std::uint32_t height) {
  const float wider = float(camera.whole_width) / float(width);
  const float higher = float(camera.whole_height) / float(height);
  if (HasPlaneFilm(camera.kind)) {
    for (float& x : camera.right) x *= wider;
    for (float& x : camera.down) x *= higher;
  }
  camera.turns_per_pixel *= std::max(wider, higher);
  camera.width = camera.whole_width = width;
  camera.height = camera.whole_height = height;
  camera.first_column = camera.first_row = 0;
  return camera;
}

double Luminance(float r, float g, float b) {
  return double(kLuminance[0]) * r + double(kLuminance[1]) * g + double(kLuminance[2]) * b;
}

// Collects the guide samples of the paths of a wave, line by line, places first, then weights.
class GuideSampleList {
 public:
  GuideSampleList(const FrameView& pilot, const PilotQuestion& question,
                  std::vector<GuideSample>& samples)
      : sphere_(pilot.sphere),
        question_(question),
        surfaces_met_(pilot.options.wave),
        places_(pilot.options.wave),
        unit_(std::accumulate(question.radiance.begin(), question.radiance.end(), 0.0) /
              double(question.radiance.size()) / kGuideSampleUnits),
        needs_(samples) {}

  // Counts surfaces [0, n) of w.surfaces, which have a density, for their paths.
  void Meet(const Worker& w, std::uint32_t n) {
    for (std::uint32_t i = 0; i < n; ++i) ++surfaces_met_[w.surfaces->path[i]];
  }

  // Adds what rays [0, n) that left the current surfaces see of the environment, as the strategy
  // has it.
  void AddEscapes(const Worker& w, std::uint32_t n) {
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

  // Adds those light samples [0, n) of the current surfaces that have arrived from infinitely far
  // away.
  void AddLightSamples(const Worker& w, std::uint32_t n) {
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

  SceneSphere sphere_;
  PilotQuestion question_;
  std::vector<std::uint32_t> surfaces_met_;
  soa::Table<DiskPlaceColumns> places_;
  double unit_;
  std::vector<GuideSample>& needs_;
};

}  // namespace

FrameView PilotView(const FrameView& frame) {
  // Pixels get a few samples, those of small films more.
  constexpr double kSamples = 4;
  const double pixels = double(frame.camera.whole_width) * frame.camera.whole_height;
  const double scale = std::min(1.0, std::sqrt(kMostPilotPaths / kSamples / pixels));
  const double samples = std::max(kSamples, std::ceil(kLeastPilotPaths / pixels));
  const auto scaled = [&](std::uint32_t side) { return int(std::lround(side * scale)); };
  const CropWindow film = WholeBlocks({0, 0, std::max(1, scaled(frame.camera.whole_width)),
                                       std::max(1, scaled(frame.camera.whole_height))});
  FrameView pilot = frame;
  pilot.strategy = frame.emitter;
  pilot.camera = WithPixels(frame.camera, std::uint32_t(film.width), std::uint32_t(film.height));
  RenderOptions& options = pilot.options;
  options = {};
  options.width = int(pilot.camera.width), options.height = int(pilot.camera.height);
  options.samples_per_pixel = std::uint32_t(samples);
  options.max_depth = frame.options.max_depth;
  options.seed = frame.options.seed ^ kPilotSeed;
  options.wave = WholeBeams(frame.options.wave);
  pilot.tracer.recorder = nullptr;
  pilot.light_groups = nullptr;
  return pilot;
}

Tile PilotTile(const FrameView& pilot) { return {0, 0, pilot.camera.width, pilot.camera.height}; }

void TracePilotWave(const FrameView& pilot, const WaveRange& range, const PilotQuestion& question,
                    Worker& w, std::vector<GuideSample>& samples) {
  StageClock clock(w.stats);
  GuideSampleList list(pilot, question, samples);
  const float light_samples = pilot.light_shares().strategy_samples(1);
  soa::Table<RayColumns>*rays = &w.rays[0], *next = &w.rays[1];
  GenerateRays(pilot, range, FilmUniforms(w.scratch), LensUniforms(w.scratch), w.paths, *rays);
  std::uint32_t n = range.count;
  for (std::uint32_t bounce = 0; n > 0; ++bounce) {
    SortedHits sorted =
        TraceAndSort(pilot, kCameraEnd, *rays, n, bounce, /*only_delta=*/false, w, clock);
    MoveEscaped(*rays, sorted.queues->queue, n, w.escaped);
    if (const std::uint32_t escaped = sorted.escaped; bounce > 0 && escaped > 0) {
      pilot.strategy->EvaluateEscaped(Points(pilot, w), escaped, light_samples, w.escaped);
      list.AddEscapes(w, escaped);
    }
    if (bounce == pilot.options.max_depth) break;
    PrepareHits(pilot, kCameraEnd, *rays, n, std::move(sorted), w, clock);
    LightSurfaces(pilot, bounce, w, clock);
    list.Meet(w, w.ranges.light_sampled());
    list.AddLightSamples(w, w.ranges.light_sampled());
    n = Scatter(pilot, kCameraEnd, w.paths, w.surfaces, w.ranges, 0, bounce,
                DirectionUniforms(w.scratch), LobeUniforms(w.scratch), *next);
    std::swap(rays, next);
  }
}

}  // namespace skywave
