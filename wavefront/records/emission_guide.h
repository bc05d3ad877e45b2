// Camera paths learn where light paths of the environment are needed.
//
// Light paths of the environment start on a disk as wide as the scene
// (kernels/light_paths/emission.h), most of them out of sight: over the far ends of a floor, on the
// walls around a window. Before a frame a few camera paths, the pilot, record where lines of light
// enter that would have contributed, as importance maps do for photons (Peter and Pietrek 1998).
// These guide samples become a density over directions and places
// (kernels/light_paths/emission_guide.h), mixed with the uniform one, so every start stays possible
// and the estimate unbiased.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "kernels/light_paths/emission_guide.h"
#include "lights/maps/environment_map.h"
#include "lights/strategies/strategy.h"
#include "wavefront/records/guide_sample.h"

namespace skywave {

// These are the shares of light paths that start uniformly over the disk of the scene, as if
// nothing were known, and over that of the focus: starts that the pilot has missed are at most that
// much rarer.
inline constexpr double kEvenShare = 1.0 / 16, kFocusShare = 1.0 / 8;

struct EmissionGuide {
  std::vector<GuideCell> cells;  // empty: nothing was learnt
  std::vector<float> cuts;
  SceneSphere focus;
  // Draws directions in place of the strategy; if it is null, the strategy does, and every gain is
  // 1.
  std::unique_ptr<EnvStrategy> directions;
  std::unique_ptr<EnvironmentMap> map;  // for `directions`, if it needs one of its own

  bool empty() const { return cells.empty(); }
  std::size_t bytes() const;
  EmissionGuideView view() const;
};

// Makes the table for a scene within `sphere`. `shares` is how often light samples are in a cell,
// if directions are to be guided too, else empty. The order of `samples` does not matter.
EmissionGuide MakeGuide(std::vector<GuideSample> samples, std::span<const double> shares,
                        const SceneSphere& sphere);

}  // namespace skywave
