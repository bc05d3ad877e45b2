#include "wavefront/guiding/pilot.h"

#include <algorithm>
#include <cmath>

namespace skywave {
namespace {

// The pilot has about this many camera paths: few against a usual render, enough for a small one.
constexpr double kLeastPilotPaths = 1 << 14, kMostPilotPaths = 1 << 17;

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

}  // namespace

FrameView PilotView(const FrameView& frame, const EnvStrategy& strategy) {
  // Pixels get a few samples, those of small films more.
  constexpr double kSamples = 4;
  const double pixels = double(frame.camera.whole_width) * frame.camera.whole_height;
  const double scale = std::min(1.0, std::sqrt(kMostPilotPaths / kSamples / pixels));
  const double samples = std::max(kSamples, std::ceil(kLeastPilotPaths / pixels));
  const auto scaled = [&](std::uint32_t side) { return int(std::lround(side * scale)); };
  const CropWindow film = WholeBlocks({0, 0, std::max(1, scaled(frame.camera.whole_width)),
                                       std::max(1, scaled(frame.camera.whole_height))});
  FrameView pilot = frame;
  pilot.strategy = &strategy;
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
  pilot.irradiance = {};
  return pilot;
}

Tile PilotTile(const FrameView& pilot) { return {0, 0, pilot.camera.width, pilot.camera.height}; }

std::uint64_t PilotPaths(const FrameView& pilot) {
  return std::uint64_t(pilot.camera.width) * pilot.camera.height * pilot.options.samples_per_pixel;
}

}  // namespace skywave
