#include "wavefront/emission_pilot.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "kernels/partition.h"
#include "wavefront/path_stages.h"

namespace skywave {
namespace {

constexpr std::uint32_t kPilotSamples = 4;         // of a pixel
constexpr std::uint32_t kPilotSeed = 0x5EED9135u;  // turns a frame's seed into the pilot's

// The same film in other pixels.
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

// Collects needs along lines: their places first, then how much.
class NeedList {
 public:
  NeedList(const FrameView& pilot, std::span<const double> radiance, std::vector<SkyNeed>& needs)
      : sphere_(pilot.sphere),
        places_(pilot.options.wave),
        unit_(std::accumulate(radiance.begin(), radiance.end(), 0.0) / double(radiance.size()) /
              kNeedUnits),
        needs_(needs) {}

  void Locate(const SkyLines& lines, std::uint32_t n) { LocateOnDisk(sphere_, lines, n, places_); }
  std::uint32_t cell(std::uint32_t i) const { return places_->cell[i]; }
  void Add(std::uint32_t i, double luminance) {
    constexpr double kMost = 0x1p40;
    const double weight = luminance / unit_;
    if (!(weight >= 1)) return;
    needs_.push_back({.cell = places_->cell[i],
                      .u = std::clamp(places_->u[i], 0.0f, 1.0f),
                      .v = std::clamp(places_->v[i], 0.0f, 1.0f),
                      .weight = std::uint64_t(std::min(weight, kMost))});
  }

 private:
  SceneSphere sphere_;
  soa::Table<DiskPlaceColumns> places_;
  double unit_;
  std::vector<SkyNeed>& needs_;
};

// What rays that left the surfaces at hand see of the sky.
void AddEscapes(const FrameView& pilot, std::uint32_t n, std::span<const double> radiance,
                const Worker& w, NeedList& list) {
  if (n == 0) return;
  const EscapeColumns& rays = w.escaped;
  const float samples = pilot.light_shares().strategy_samples(1);
  pilot.strategy->EvaluateEscaped(Points(pilot, w), n, samples, rays);
  list.Locate({rays.dir_x, rays.dir_y, rays.dir_z, w.surfaces, rays.from}, n);
  for (std::uint32_t i = 0; i < n; ++i) {
    const double throughput =
        Luminance(rays.throughput_r[i], rays.throughput_g[i], rays.throughput_b[i]);
    if (rays.pdf[i] > 0) {
      const double ratio = double(rays.light_pdf[i]) / rays.pdf[i];
      const double seen = Luminance(rays.radiance_r[i], rays.radiance_g[i], rays.radiance_b[i]);
      list.Add(i, throughput * seen / (1 + ratio * ratio));
    } else {
      list.Add(i, throughput * radiance[list.cell(i)]);
    }
  }
}

// Light samples of the surfaces at hand that have arrived from infinitely far away.
void AddLightSamples(std::uint32_t n, const Worker& w, NeedList& list) {
  const LightColumns& lights = w.lights;
  list.Locate({lights.dir_x, lights.dir_y, lights.dir_z, w.surfaces}, n);
  for (std::uint32_t i = 0; i < n; ++i) {
    if (std::isinf(lights.t_far[i])) list.Add(i, Luminance(lights.r[i], lights.g[i], lights.b[i]));
  }
}

}  // namespace

FrameView PilotView(const FrameView& frame) {
  const double pixels = double(frame.camera.whole_width) * frame.camera.whole_height;
  const double scale = std::min(1.0, std::sqrt(double(kPilotPaths) / kPilotSamples / pixels));
  const auto scaled = [&](std::uint32_t side) {
    return std::max(1u, std::uint32_t(std::lround(side * scale)));
  };
  FrameView pilot = frame;
  pilot.strategy = frame.emitter;
  pilot.camera =
      WithPixels(frame.camera, scaled(frame.camera.whole_width), scaled(frame.camera.whole_height));
  RenderOptions& options = pilot.options;
  options = {};
  options.width = int(pilot.camera.width), options.height = int(pilot.camera.height);
  options.samples_per_pixel = kPilotSamples;
  options.max_depth = frame.options.max_depth;
  options.seed = frame.options.seed ^ kPilotSeed;
  options.wave = frame.options.wave;
  pilot.tracer.recorder = nullptr;
  pilot.light_groups = nullptr;
  return pilot;
}

Tile PilotTile(const FrameView& pilot) { return {0, 0, pilot.camera.width, pilot.camera.height}; }

void TracePilotWave(const FrameView& pilot, const WaveRange& range,
                    std::span<const double> radiance, Worker& w, std::vector<SkyNeed>& needs) {
  StageClock clock(w.stats);
  NeedList list(pilot, radiance, needs);
  soa::Table<RayColumns>*rays = &w.rays[0], *next = &w.rays[1];
  GenerateRays(pilot, range, w.uniforms, w.lobe, w.paths, *rays);
  std::uint32_t n = range.count;
  for (std::uint32_t bounce = 0; n > 0; ++bounce) {
    SurfaceRanges ranges;
    const std::uint32_t escaped =
        TraceAndSort(pilot, kCameraEnd, *rays, n, bounce, /*only_delta=*/false, w, ranges, clock);
    MoveEscaped(*rays, w.queue->queue, n, w.escaped);
    if (bounce > 0) AddEscapes(pilot, escaped, radiance, w, list);
    if (bounce == pilot.options.max_depth) break;
    PrepareHits(pilot, kCameraEnd, *rays, n, escaped, ranges, w, clock);
    LightSurfaces(pilot, bounce, w, clock);
    AddLightSamples(w.ranges.light_sampled(), w, list);
    n = Scatter(pilot, kCameraEnd, w.paths, w.surfaces, w.ranges, 0, bounce, w.uniforms, w.lobe,
                *next);
    std::swap(rays, next);
  }
}

}  // namespace skywave
