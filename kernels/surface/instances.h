// Instances of objects. The triangles of an object are in a space of their own; what kernels read
// of them goes to the world by the record of the instance that a ray has hit.
#pragma once

#include <array>
#include <cstdint>

#include "kernels/columns.h"

namespace skywave {

// 16 words. Record 0 is that of the world itself, which changes nothing.
struct InstanceRecord {
  float linear[9];       // rows of its matrix, world from object, without the translation
  float translation[3];  // its last column
  // Where Embree takes rays to the object and back, hits lose two more bits than in the world: four
  // times the largest coordinate of its triangles in the world, or of its translation. 0: the
  // world.
  float extent;
  float scale;  // the largest factor by which a vector grows
  // The factor of the cofactors of `linear` in its inverse transpose, up to a positive constant
  // that keeps the product near 1: negative where the instance mirrors.
  float cofactors;
  float unused;
};

// Returns a normal of the object in the world, of another length.
inline std::array<float, 3> NormalInWorld(const InstanceRecord& record, float x, float y, float z) {
  const float* const m = record.linear;
  const auto cofactors_times = [&](int r0, int r1) {
    const float *const a = m + 3 * r0, *const b = m + 3 * r1;
    return record.cofactors * ((a[1] * b[2] - a[2] * b[1]) * x + (a[2] * b[0] - a[0] * b[2]) * y +
                               (a[0] * b[1] - a[1] * b[0]) * z);
  };
  return {cofactors_times(1, 2), cofactors_times(2, 0), cofactors_times(0, 1)};
}
inline constexpr int kLogInstanceWords = 4;
static_assert(sizeof(InstanceRecord) == sizeof(std::uint32_t) << kLogInstanceWords);

// Copies the instances of the rows of queue `kind` to `surfaces`, as MoveHits does with the rest.
// Scenes without instances have no use for it.
void MoveInstances(const HitColumns& hits, const std::uint32_t* queue, std::uint32_t kind,
                   std::uint32_t n, const SurfaceColumns& surfaces);

}  // namespace skywave
