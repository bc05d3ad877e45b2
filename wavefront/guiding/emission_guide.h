// Where light paths of the sky are needed, learnt from what camera paths see of it.
//
// A sky's light paths start on a disk as wide as the scene (kernels/light_paths/emission.h), most
// of them where nobody looks: over the far ends of a floor, on the walls around a window. Before a
// frame a few camera paths, the pilot, note where lines of light enter that would have brought
// something, as importance maps do for photons (Peter and Pietrek 1998). What they find becomes a
// density over directions and places (kernels/light_paths/emission_guide.h), mixed with the even
// one, so every start stays possible and the estimate unbiased.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "kernels/light_paths/emission_guide.h"
#include "lights/maps/environment_map.h"
#include "lights/strategies/strategy.h"
#include "wavefront/frame.h"
#include "wavefront/guiding/guide_counts.h"
#include "wavefront/guiding/guide_sample.h"
#include "wavefront/worker_pool.h"

namespace skywave {

// Shares of light paths that start evenly over the disk of the scene, as if nothing were known, and
// over that of the focus: what the pilot has missed is at most so much rarer.
inline constexpr double kEvenShare = 1.0 / 16, kFocusShare = 1.0 / 8;

struct EmissionGuide {
  std::vector<GuideCell> cells;  // empty: nothing was learnt
  std::vector<float> cuts;
  SceneSphere focus;
  // Draws directions in place of the strategy; null: the strategy does, and every gain is 1.
  std::unique_ptr<EnvStrategy> directions;
  std::unique_ptr<EnvironmentMap> map;  // of `directions`, where it needs one of its own

  bool empty() const { return cells.empty(); }
  std::size_t bytes() const;
  EmissionGuideView view() const;
};

// The guide of a frame; nothing was learnt where it has none.
inline EmissionGuideView GuideOf(const FrameView& frame) {
  return frame.guide != nullptr ? frame.guide->view() : EmissionGuideView();
}

// The table, for a scene within `sphere`. `shares`: how often light samples are in a cell, if
// directions are to be guided too; else empty. The order of `needs` does not matter, and is lost.
EmissionGuide MakeGuide(std::vector<GuideSample> samples, std::span<const double> shares,
                        const SceneSphere& sphere);

// Traces the pilot of a frame whose light paths start with frame.emitter, and makes its guide; an
// empty one where no camera path finds the sky. Depends on neither threads nor wave, nor on which
// part of the film or which samples the frame has. Statistics of the workers stay as they are, and
// no rays are recorded.
EmissionGuide LearnEmission(const FrameView& frame, WorkerPool& pool, GuideCounts& counts);

}  // namespace skywave
