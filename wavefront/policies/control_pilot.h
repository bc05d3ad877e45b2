// A pilot learns how much the control variate of irradiance should weigh at the places of a scene.
#pragma once

#include <memory>
#include <vector>

#include "kernels/lights/irradiance.h"
#include "lights/tables/places.h"
#include "wavefront/frame.h"
#include "wavefront/policies/guide_counts.h"
#include "wavefront/worker_pool.h"

namespace skywave {

struct ControlWeights {
  PlaceTree tree;
  std::vector<float> of_places;  // 0 to 1

  ControlWeightView view() const { return {.places = tree.view(), .weight = of_places.data()}; }
};

// Learns the weights for the strategy of the frame, which has a control variate, and sets them. If
// they are all 1, the frame gets none; if the control removes too little noise, the frame loses it.
// What is learnt depends on neither threads nor wave, nor on which part of the film or which
// samples the frame has. Statistics of the workers stay as they are.
ControlWeights LearnControl(WorkerPool& pool, FrameView& frame, GuideCounts& counts);

}  // namespace skywave
