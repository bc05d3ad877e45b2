// Clamps are limits of what a path may bring. They take fireflies out of a picture, and the light
// of these: a picture with clamps is too dark where they work, with any number of samples.
//
// The light of a path is direct up to the second surface, as in the layer `direct`, and then
// indirect; a sample of a pixel is both. What is above the limit is scaled down to it, all channels
// alike, so colours stay.
#pragma once

#include <cstdint>
#include <span>

#include "wavefront/render_option.h"
#include "wavefront/worker.h"

namespace skywave {

// The largest radiance in any channel that a path may bring, or for the last one the largest
// luminance [scene radiance]; 0: any, or what the scene file says.
struct ClampOptions {
  static constexpr float kLifted = 1e12f;  // the same as no limit
  float direct = 0, indirect = 0, sample = 0, luminance = 0;
  static bool Works(float limit) { return limit > 0 && limit < kLifted; }
  bool any() const { return Works(direct) || Works(indirect) || Works(sample) || Works(luminance); }
};

// The options of integrators that follow whole paths from the camera.
std::span<const RenderOption> ClampOptionTable();

// Throws OptionError where parts of the light of a path are kept that clamps do not know.
void CheckClamps(const RenderOptions& options);

// A worker needs these tables where there are clamps.
struct ClampTables {
  explicit ClampTables(std::uint32_t wave) : direct(wave) {}
  soa::Table<RadianceColumns> direct;  // by path: what it has brought up to the second surface
};

void AddClampTables(const RenderOptions& options, Worker& worker);

// Clamps the direct light of the paths of a wave, once their rays to a bounce have met their lights
// and this is the bounce at which indirect light begins. Does nothing without clamps, as the
// others.
void ClampDirect(const FrameView& frame, std::uint32_t bounce, const Worker& w);
// The same of paths that have all ended before that, at `bounce`.
void ClampDirectOfEnded(const FrameView& frame, std::uint32_t bounce, const Worker& w);

// Clamps what paths have brought since then, and all of it, at their ends.
void ClampIndirectAndWhole(const FrameView& frame, const Worker& w);

}  // namespace skywave
