// Hits are sorted into queues, one per BSDF. Rows are moved, not listed: one stable compaction per
// queue leaves every later kernel with dense, contiguous columns (measured against index lists and
// gathers: see docs/design.md).
#pragma once

#include <cstdint>

#include "kernels/columns.h"
#include "kernels/lights/irradiance.h"
#include "kernels/surface/texture.h"

namespace skywave {

inline constexpr std::uint32_t kMissQueue = kBsdfKinds;  // follows those of the BSDFs

// A set of BSDFs has the bit 1 << kind for each of them.
using BsdfSet = std::uint32_t;
static_assert(kBsdfKinds <= 32);

// A mixture whose share has this bit (the sign of a float) has the first channel of a texture, at
// level 0, in place of a number; the other bits are its row in the texture table.
inline constexpr std::uint32_t kShareOfTexture = 1u << 31;

// Replaces the triangle of hits [0, n) on a mixture of materials (kMixedTriangle) by its record
// with one of them: the second one where u[i] is below its share, and so on for mixtures of
// mixtures.
void ChooseMaterials(const TriangleRecord* triangles, const TextureView& textures, const float* u,
                     std::uint32_t n, const HitColumns& hits);

// Writes queue[i] for rows [0, n): the BSDF of the triangle that row i hit, which is one of
// `present`, or kMissQueue. Adds the length of every queue to count[kBsdfKinds + 1]. `queue` is a
// padded column; its padding matches no queue. If `ray_pdf` is not null, hits of rays with a
// density go to no queue (see RayColumns::pdf).
void ClassifyHits(const HitColumns& hits, const TriangleRecord* triangles, BsdfSet present,
                  const float* ray_pdf, std::uint32_t n, std::uint32_t* queue,
                  std::uint32_t* count);

// The same for rays of which only misses matter: hits go to no queue. Returns the number of misses.
std::uint32_t ClassifyEscapes(const HitColumns& hits, std::uint32_t n, std::uint32_t* queue);

// Copies the rows whose queue is kMissQueue to `escaped`, in order, from its row 0 on.
void MoveEscaped(const RayColumns& rays, const std::uint32_t* queue, std::uint32_t n,
                 const EscapeColumns& escaped);

// Copies to `escaped` the rows whose weight is not 0: their throughput less their control if they
// escaped, minus their control if they hit something. Returns their number.
std::uint32_t MoveControlled(const RayColumns& rays, const std::uint32_t* queue, std::uint32_t n,
                             const ControlColumns& control, const EscapeColumns& escaped);

// Copies the rows of queue `kind` to `surfaces`, in order, from its row 0 on: the columns of a hit
// and its ray that shading needs.
void MoveHits(const RayColumns& rays, const HitColumns& hits, const std::uint32_t* queue,
              std::uint32_t kind, std::uint32_t n, const SurfaceColumns& surfaces);

}  // namespace skywave
