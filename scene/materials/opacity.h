// Holes in a scene: what Embree asks at every candidate hit of a triangle that rays may pass
// through.
#pragma once

#include <embree3/rtcore.h>

#include <vector>

#include "kernels/surface/opacity.h"
#include "scene/scene.h"

namespace skywave {

// Records of all materials, in their order.
std::vector<OpacityRecord> MakeOpacityRecords(const std::vector<Material>& materials);

// What the filter of a geometry is given: its triangles are those from `first` on.
struct AlphaFilter {
  OpacityView opacity;
  std::uint32_t first;
};

// Makes `geometry` ask. `filter` must outlive it; rays carry their keys (DrawRayKeys) in `id`.
void SetAlphaFilter(RTCGeometry geometry, const AlphaFilter& filter);

}  // namespace skywave
