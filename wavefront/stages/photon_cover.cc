#include "wavefront/stages/photon_cover.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "kernels/chunk.h"
#include "kernels/sampler.h"
#include "wavefront/rays/trace.h"
#include "wavefront/scratch.h"

namespace skywave {
namespace {

// The eye's height over its disk, in radii, is high enough not to graze what is nearly flat, and
// low enough to stay in front of what stands around.
constexpr float kEyeHeight = 0.5f, kLeastHeight = 0x1p-6f;

// Rays and hits of a block of disks lie on the stack: 22 KiB.
struct CoverTables {
  static constexpr std::uint32_t kRows = kLookupBlock * kDiskCells;
  Chunk<RayColumns, kRows> rays;
  Chunk<HitColumns, kRows> hits;
  Chunk<KeyColumns, kRows> keys;
};

void AimUp(const PhotonDisk& disk, const RayColumns& rays, std::uint32_t row) {
  rays.org_x[row] = disk.point[0], rays.org_y[row] = disk.point[1];
  rays.org_z[row] = disk.point[2];
  rays.dir_x[row] = disk.normal[0], rays.dir_y[row] = disk.normal[1];
  rays.dir_z[row] = disk.normal[2];
  rays.t_far[row] = disk.height;
}

// Returns keys in scenes with alpha: each ray has its own, the same for the same ray.
const std::uint32_t* KeysOf(const FrameView& frame, const RayColumns& rays, std::uint32_t n,
                            std::uint32_t* keys) {
  if (!frame.geometry->has_alpha()) return nullptr;
  for (std::uint32_t i = 0; i < n; ++i) {
    keys[i] = PixelSeed(std::bit_cast<std::uint32_t>(rays.dir_x[i]),
                        std::bit_cast<std::uint32_t>(rays.dir_y[i]),
                        std::bit_cast<std::uint32_t>(rays.org_x[i]));
  }
  return keys;
}

void Trace(const FrameView& frame, const CoverTables& t, std::uint32_t n, RenderStats& stats,
           StageClock& clock) {
  const std::uint32_t* const keys = KeysOf(frame, t.rays, n, t.keys->key);
  stats.rays[std::uint32_t(RayKind::kBounce)] += n;
  clock.Lap(Stage::kPhotons);
  TraceClosest(frame.tracer, RayKind::kBounce, t.rays, n, t.hits, keys);
  clock.Lap(Stage::kIntersect, RayKind::kBounce);
}

}  // namespace

void CoverDisks(const FrameView& frame, const CoveredDisks& of, RenderStats& stats,
                StageClock& clock) {
  const std::uint32_t n = of.count;
  PhotonDisk* const disks = of.disks;
  if (n == 0) return;
  const CoverTables t;
  const RayColumns& rays = t.rays;
  const HitColumns& hits = t.hits;
  for (std::uint32_t i = 0; i < n; ++i) {
    disks[i].height = kEyeHeight * std::sqrt(disks[i].radius2);
    AimUp(disks[i], rays, i);
  }
  Trace(frame, t, n, stats, clock);
  for (std::uint32_t i = 0; i < n; ++i) {
    if (hits.geom[i] == kNoHit) continue;
    disks[i].height *= std::max(0.5f * rays.t_far[i] / disks[i].height, kLeastHeight);
  }
  for (std::uint32_t i = 0; i < n; ++i) {
    AimAtDisk(disks[i], of.kernel, Slice(rays, i * kDiskCells));
  }
  Trace(frame, t, n * kDiskCells, stats, clock);
  for (std::uint32_t i = 0; i < n; ++i) {
    FindSeenCells(disks[i], frame.geometry->triangles(), Slice(rays, i * kDiskCells),
                  Slice(hits, i * kDiskCells), of.seen[i]);
  }
}

}  // namespace skywave
