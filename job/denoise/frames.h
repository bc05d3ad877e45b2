// Frames of an animation that steady each other: after each has been cleaned by itself, what is
// left of its noise flickers. So a pixel is averaged with those of other frames that show the same
// point of a surface, which optical flow finds (wavefront/film/flow.h), unless a test of their
// halves says that their light differs (kernels/cross_filter.h).
//
// A point is the same only if the flow of the other frame leads back to where it came from: what is
// hidden there by something else is not. Without flow, frames show things that stand still.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "job/denoise/denoised.h"
#include "job/denoise/outliers.h"
#include "job/denoise/planes.h"
#include "job/denoise/statistics.h"

namespace skywave {

// Returns the names of the channels that are read of a frame, where it has them, besides those of
// DenoiserChannels.
std::vector<std::string> FlowChannels();

// To where another frame has what a pixel sees [pixels, y down], by pixel; empty: stands still.
struct FrameFlow {
  std::vector<float> x, y, known;
};

// A frame that has been cleaned by itself, by the statistics of its samples. It needs 120 bytes a
// pixel, 12 more with outliers and 24 more with flow.
struct CleanFrame {
  std::string name;
  DenoiserPlanes planes;
  OutlierExcess outliers;
  HalfTables halves;
  FrameFlow next, previous;
};

// Cleans a frame; see Denoise. Throws InputError also where its flow is there by half.
CleanFrame CleanFrameOf(const std::string& name, const Image& image,
                        std::span<const NamedChannel> layers);

// Returns frame `here` of successive ones, steadied by the others. Throws InputError where they
// differ in size, or where only some have flow.
Denoised Steady(std::span<const CleanFrame* const> frames, std::size_t here);

}  // namespace skywave
