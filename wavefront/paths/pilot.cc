#include "wavefront/paths/pilot.h"

#include <algorithm>
#include <cmath>

namespace skywave {
namespace {

// The pilot has about this many camera paths: few compared with a usual render, enough for a small
// one.
constexpr double kLeastPilotPaths = 1 << 14;

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
  camera.pixel_side *= std::max(wider, higher);
  camera.width = camera.whole_width = width;
  camera.height = camera.whole_height = height;
  camera.first_column = camera.first_row = 0;
  return camera;
}

}  // namespace

FrameView CoarseView(const FrameView& frame, std::uint64_t paths, std::uint32_t samples) {
  const double pixels = double(frame.camera.whole_width) * frame.camera.whole_height;
  const double scale = std::min(1.0, std::sqrt(double(paths) / samples / pixels));
  const auto scaled = [&](std::uint32_t side) { return int(std::lround(side * scale)); };
  const CropWindow film = WholeBlocks({0, 0, std::max(1, scaled(frame.camera.whole_width)),
                                       std::max(1, scaled(frame.camera.whole_height))});
  FrameView coarse = frame;
  coarse.camera = WithPixels(frame.camera, std::uint32_t(film.width), std::uint32_t(film.height));
  RenderOptions& options = coarse.options;
  options.width = film.width, options.height = film.height;
  options.film_width = options.film_height = options.crop_x = options.crop_y = 0;
  const double least = std::min(double(paths), kLeastPilotPaths) / pixels;
  options.samples_per_pixel = std::max(samples, std::uint32_t(std::ceil(least)));
  options.first_sample = 0, options.picture_samples = {};
  options.wave = WholeBeams(frame.options.wave);
  options.aovs = 0;
  coarse.tracer.recorder = nullptr;
  coarse.light_groups = nullptr;
  return coarse;
}

FrameView PilotView(const FrameView& frame, const EnvStrategy& strategy, std::uint64_t paths) {
  constexpr std::uint32_t kSamples = 4;
  FrameView pilot = CoarseView(frame, paths, kSamples);
  pilot.strategy = &strategy;
  pilot.Show<ControlView>(nullptr);
  const RenderOptions coarse = pilot.options;
  pilot.options = {};
  pilot.options.width = coarse.width, pilot.options.height = coarse.height;
  pilot.options.samples_per_pixel = coarse.samples_per_pixel;
  pilot.options.max_depth = coarse.max_depth;
  pilot.options.seed = coarse.seed ^ kPilotSeed;
  pilot.options.wave = coarse.wave;
  return pilot;
}

std::uint64_t PilotShare(const FrameView& frame, std::uint64_t least, std::uint64_t most) {
  constexpr std::uint64_t kPicturePaths = 64;
  const std::uint64_t paths = std::uint64_t{frame.camera.whole_width} * frame.camera.whole_height *
                              PictureSamples(frame.options).count();
  return std::clamp(paths / kPicturePaths, least, most);
}

PlaceBox PlaceBoxOf(const SceneSphere& sphere) {
  PlaceBox box;
  for (std::size_t i = 0; i < 3; ++i) {
    box.low[i] = sphere.low[i];
    box.side = std::max(box.side, sphere.high[i] - sphere.low[i]);
  }
  return std::isfinite(box.side) ? box : PlaceBox{};
}

Tile PilotTile(const FrameView& pilot) { return {0, 0, pilot.camera.width, pilot.camera.height}; }

std::uint64_t PilotPaths(const FrameView& pilot) {
  return std::uint64_t(pilot.camera.width) * pilot.camera.height * pilot.options.samples_per_pixel;
}

}  // namespace skywave
