// Light samples subtract what is known analytically of a map's light, and a pilot learns how much
// that should weigh at the places of a scene.
#pragma once

#include <memory>
#include <vector>

#include "base/names.h"
#include "kernels/lights/irradiance.h"
#include "lights/tables/places.h"
#include "wavefront/frame.h"
#include "wavefront/pilot_reports.h"
#include "wavefront/stages/stages.h"
#include "wavefront/worker_pool.h"

namespace skywave {

// Part of the lighting that is known analytically; only the residual is sampled.
enum class ControlVariate {
  kNone,
  kIrradiance  // that of the map on diffuse surfaces from which nothing hides it
};

template <>
inline constexpr auto kEnumNames<ControlVariate> = std::to_array<Named<ControlVariate>>(
    {{ControlVariate::kNone, "none"}, {ControlVariate::kIrradiance, "irradiance"}});

struct ControlOptions {
  ControlVariate control = ControlVariate::kNone;
};

struct ControlWeights {
  PlaceTree tree;
  std::vector<float> of_places;  // 0 to 1
  ControlView shown;             // by the frame
};

// Learns the weights for the strategy of the frame, which has a control variate, and shows them. If
// they are all 1, the frame shows none; if the control removes too little noise, the frame loses
// it.
std::unique_ptr<ControlWeights> LearnControl(WorkerPool& pool, FrameView& frame,
                                             PilotCounts& counts);

}  // namespace skywave
