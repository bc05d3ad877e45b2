// Instances of objects. The triangles of an object are in a space of their own; what kernels read
// of them goes to the world by the record of the instance that a ray has hit.
#pragma once

#include <cstdint>

#include "kernels/columns.h"

namespace skywave {

// 16 words. Record 0 is that of the world itself, which changes nothing.
struct InstanceRecord {
  float normal[9];  // rows of the inverse transpose of its matrix without the translation
  // The largest coordinate of its triangles in the world, or of its translation: the precision of
  // hits depends on it.
  float extent;
  float unused[6];
};
inline constexpr int kLogInstanceWords = 4;
static_assert(sizeof(InstanceRecord) == sizeof(std::uint32_t) << kLogInstanceWords);

// Copies the instances of the rows of queue `kind` to `surfaces`, as MoveHits does with the rest.
// Scenes without instances have no use for it.
void MoveInstances(const HitColumns& hits, const std::uint32_t* queue, std::uint32_t kind,
                   std::uint32_t n, const SurfaceColumns& surfaces);

}  // namespace skywave
