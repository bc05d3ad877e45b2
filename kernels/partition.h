// From hits to queues. Rows are moved, not listed: one stable compaction a queue leaves every later
// kernel with dense, contiguous columns (measured against index lists and gathers: see
// docs/design.md).
#pragma once

#include <cstdint>

#include "kernels/columns.h"

namespace skywave {

inline constexpr std::uint32_t kMissQueue = kBsdfKinds;  // behind the queues of the BSDFs

// BSDFs as bits: 1 << kind.
using BsdfSet = std::uint32_t;
static_assert(kBsdfKinds <= 32);

// Replaces the triangle of hits [0, n) on a mixture of materials (kMixedTriangle) by its record
// with one of them: the second one where u[i] is below its share, and so on for mixtures of
// mixtures.
void ChooseMaterials(const TriangleRecord* triangles, const float* u, std::uint32_t n,
                     const HitColumns& hits);

// Writes queue[i] for rows [0, n): the BSDF of the triangle that row i hit, which is one of
// `present`, or kMissQueue. Adds the length of every queue to count[kBsdfKinds + 1]. `queue` is a
// padded column; its padding matches no queue. Where `ray_pdf` is not null, hits of rays with a
// density go to no queue (see RayColumns::pdf).
void ClassifyHits(const HitColumns& hits, const TriangleRecord* triangles, BsdfSet present,
                  const float* ray_pdf, std::uint32_t n, std::uint32_t* queue,
                  std::uint32_t* count);

// The same for rays of which only misses matter: the others go to no queue. Returns the misses.
std::uint32_t ClassifyEscapes(const HitColumns& hits, std::uint32_t n, std::uint32_t* queue);

// Appends to `escaped` (from its row 0) the rows whose queue is kMissQueue, in order.
void MoveEscaped(const RayColumns& rays, const std::uint32_t* queue, std::uint32_t n,
                 const EscapeColumns& escaped);

// Appends to `surfaces` (from its row 0) the rows of queue `kind`, in order: the columns of a hit
// and its ray that shading needs.
void MoveHits(const RayColumns& rays, const HitColumns& hits, const std::uint32_t* queue,
              std::uint32_t kind, std::uint32_t n, const SurfaceColumns& surfaces);

}  // namespace skywave
