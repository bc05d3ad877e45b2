// Where a render ends before it has all samples that `spp` gives: a range of them, a time, a noise.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "wavefront/film/film.h"
#include "wavefront/option.h"
#include "wavefront/render.h"

namespace skywave {

struct RenderLimits {
  std::optional<SampleRange> samples;  // of those of the picture; unset: all
  double seconds = 0;                  // wall clock; 0: no limit
  double noise = 0;                    // see Film::Noise; 0: no limit
  double adaptive = 0;                 // relative error of WantedSamples; 0: all pixels go on
  std::uint32_t adaptive_min = 16;     // samples that every pixel has before blocks may end
  bool end_early() const { return seconds > 0 || noise > 0 || adaptive > 0; }
};

// Returns the options sample-range, time, noise, adaptive and adaptive-min.
std::vector<OptionOf<RenderLimits>> LimitOptions();

// Prints and parses "FIRST:END".
Codec<SampleRange> SampleRanges();

// Returns the samples of a picture of `samples_per_pixel` samples that are to be rendered. Throws
// OptionError if the picture does not have them.
SampleRange ChooseSamples(const RenderLimits& limits, std::uint32_t samples_per_pixel);

// Returns the layers that a film needs for its noise to be known. Throws OptionError where the
// noise is to be limited and splats have no variance, and where blocks are to end apart and pixels
// share light paths.
AovSet LayersForLimits(const RenderLimits& limits, Integrator integrator);

// Decides where the steps of a render end (RenderControl::next_stop). Under a limit of noise they
// end where the number of samples has doubled, so the result does not depend on threads. Under a
// limit of time the speed so far decides, and a step at most doubles the samples. `film` and
// `elapsed`, which returns the seconds spent, have to outlive the function.
std::function<std::uint32_t(std::uint32_t done)> StopRule(const RenderLimits& limits,
                                                          const SampleRange& samples,
                                                          const Film& film,
                                                          std::function<double()> elapsed);

// Ends the blocks that have all samples that they should have, if the film holds as many as it has
// when that is looked at: adaptive_min and its doubles (RenderControl::end_blocks). `samples` are
// those that are to be rendered. Returns the share of them that is not expected to be needed.
double EndBlocks(const RenderLimits& limits, const SampleRange& samples, const FrameView& frame,
                 const Film& film, RenderState& state);

}  // namespace skywave
