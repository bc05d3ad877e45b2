#include "kernels/light_paths/photon_cover.h"

#include <array>
#include <bit>
#include <cmath>
#include <limits>

#include "kernels/sampler.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/light_paths/photon_cover.cc"
#include "hwy/foreach_target.h"
#include "hwy/highway.h"
#include "kernels/simd/math-inl.h"

// These are the cells of the unit disk. All have the same share of the kernel.
#ifndef SKYWAVE_KERNELS_DISK_CELLS_
#define SKYWAVE_KERNELS_DISK_CELLS_
namespace skywave {

constexpr std::uint32_t kSectors = 8;

struct DiskCells {
  alignas(kColumnAlignment) std::array<float, kDiskCells> x, y;  // middles
  float inner2;                                                  // squared radius between the rings
};

// Returns the kernel's integral over the disk of radius s.
constexpr double KernelWithin(PhotonKernel kernel, double s) {
  switch (kernel) {
    case PhotonKernel::kConstant:
      return s * s;
    case PhotonKernel::kCone:
      return s * s * (3 - 2 * s);
    case PhotonKernel::kEpanechnikov:
      return s * s * (2 - s * s);
  }
  return 0;
}

constexpr double RadiusOf(PhotonKernel kernel, double share) {
  double low = 0, high = 1;
  for (int step = 0; step < 40; ++step) {
    const double middle = 0.5 * (low + high);
    (KernelWithin(kernel, middle) < share ? low : high) = middle;
  }
  return low;
}

// Sectors are numbered as in OctantOf.
constexpr DiskCells MakeDiskCells(PhotonKernel kernel) {
  constexpr double kCosine = 0.9238795325112867, kSine = 0.3826834323650898;  // of pi / 8
  const double split = RadiusOf(kernel, 0.5);
  DiskCells cells = {.x = {}, .y = {}, .inner2 = float(split * split)};
  for (std::uint32_t i = 0; i < kDiskCells; ++i) {
    const double radius = RadiusOf(kernel, i < kSectors ? 0.25 : 0.75);
    const bool steep = (i & 4) != 0;
    cells.x[i] = float(radius * (steep ? kSine : kCosine) * ((i & 1) != 0 ? -1 : 1));
    cells.y[i] = float(radius * (steep ? kCosine : kSine) * ((i & 2) != 0 ? -1 : 1));
  }
  return cells;
}

inline constexpr DiskCells kCells[] = {MakeDiskCells(PhotonKernel::kConstant),
                                       MakeDiskCells(PhotonKernel::kCone),
                                       MakeDiskCells(PhotonKernel::kEpanechnikov)};

}  // namespace skywave
#endif

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

// Returns the frame in which cells lie: about the normal, turned by a hash of the point.
HWY_INLINE Frame CellFrame(const PhotonDisk& disk) {
  const std::uint32_t bits = PixelSeed(std::bit_cast<std::uint32_t>(disk.point[0]),
                                       std::bit_cast<std::uint32_t>(disk.point[1]),
                                       std::bit_cast<std::uint32_t>(disk.point[2]));
  VF sine, cosine;
  SinCosTurn(ToUnitFloat(SetU(bits)), sine, cosine);
  const Frame frame = MakeFrame(Set3(disk.normal));
  return {frame.s * cosine + frame.t * sine, frame.t * cosine - frame.s * sine, frame.n};
}

HWY_INLINE VU OctantOf(VF x, VF y) {
  const VU left = hn::ShiftRight<31>(AsBits(x)), down = hn::ShiftRight<31>(AsBits(y));
  const MU steep = hn::RebindMask(U(), hn::Gt(hn::Abs(y), hn::Abs(x)));
  return hn::Or(hn::Or(left, down + down), hn::IfThenElseZero(steep, SetU(4)));
}

void AimAtDisk(const PhotonDisk& disk, PhotonKernel kernel, const RayColumns& rays) {
  const DiskCells& cells = kCells[std::uint32_t(kernel)];
  const VF radius = Set(std::sqrt(disk.radius2)), height = Set(disk.height);
  const Frame frame = CellFrame(disk);
  const V3 eye = Set3(disk.point) + frame.n * height;
  for (std::uint32_t i = 0; i < kDiskCells; i += hn::Lanes(F())) {
    const V3 down = {Load(cells.x.data() + i) * radius, Load(cells.y.data() + i) * radius, -height};
    const VF length = hn::Sqrt(Dot(down, down));
    Store3(eye, rays.org_x + i, rays.org_y + i, rays.org_z + i);
    Store3(ToWorld(frame, down * (1.0f / length)), rays.dir_x + i, rays.dir_y + i, rays.dir_z + i);
    Store(2.0f * length, rays.t_far + i);
  }
}

HWY_INLINE V3 Select(MF mask, const V3& yes, const V3& no) {
  return {IfThen(mask, yes.x, no.x), IfThen(mask, yes.y, no.y), IfThen(mask, yes.z, no.z)};
}

// Selects points with unit normals `a` and `b`, `between` apart, that may lie on one smooth
// surface: on any ball or cylinder they have no distance along the mean of their normals, of either
// sign.
HWY_INLINE MF OnOneLayer(const V3& between, const V3& a, const V3& b, VF layer) {
  const VF sign = hn::CopySign(Set(1.0f), Dot(a, b));
  const V3 mean = a + b * sign;
  return hn::Lt(hn::Abs(Dot(between, mean)), layer * hn::Sqrt(Dot(mean, mean)));
}

void FindSeenCells(const PhotonDisk& disk, const TriangleRecord* triangles, const RayColumns& rays,
                   const HitColumns& hits, DiskSurface& surface) {
  constexpr float kOrigin[3] = {0, 0, 0};
  const auto* const words = reinterpret_cast<const std::uint32_t*>(triangles);
  const V3 normal = Set3(disk.normal);
  alignas(kColumnAlignment) std::uint32_t seen[kDiskCells];
  for (std::uint32_t i = 0; i < kDiskCells; i += hn::Lanes(F())) {
    const MU hit = hn::Ne(Load(hits.geom + i), SetU(kNoHit));
    const V3 ng = Load3(hits.ng_x + i, hits.ng_y + i, hits.ng_z + i);
    const V3 origin = Load3(rays.org_x + i, rays.org_y + i, rays.org_z + i);
    const V3 dir = Load3(rays.dir_x + i, rays.dir_y + i, rays.dir_z + i);
    const V3 offset = origin + dir * Load(rays.t_far + i) - Set3(disk.point);
    const VF length = hn::Sqrt(Dot(ng, ng));
    const VF cosine = hn::Abs(Dot(ng, normal));
    const MF same = hn::Gt(cosine, kLeastNormalCosine * length);
    const MF near = hn::Lt(Dot(offset, offset), Set(disk.radius2));
    const VU record = hn::ShiftLeft<2>(hn::IfThenElseZero(hit, Load(hits.triangle + i)));
    const VU tag = Gather(words, record + SetU(3));
    const MU delta = hn::Gt(hn::ShiftRight<kKindShift>(tag), SetU(kFirstDeltaBsdf - 1));
    const MU lies = hn::And(hit, hn::AndNot(delta, hn::RebindMask(U(), hn::And(same, near))));
    Store(hn::IfThenElseZero(hn::Or(lies, hn::And(hit, delta)), SetU(1)), seen + i);
    // Where no surface is known, photons are taken to lie on the plane of the disk.
    const MF known = hn::RebindMask(F(), lies);
    const VF scale = 1.0f / IfThen(known, length, Set(1.0f));
    Store3(Select(known, ng * scale, normal), surface.normal_x + i, surface.normal_y + i,
           surface.normal_z + i);
    Store3(Select(known, offset, Set3(kOrigin)), surface.x + i, surface.y + i, surface.z + i);
  }
  std::uint32_t bits = 0;
  for (std::uint32_t i = 0; i < kDiskCells; ++i) bits |= seen[i] << i;
  surface.seen = bits == 0 ? kAllCells : bits;
}

// Returns the positions of neighbors from the middle of the disk.
HWY_INLINE V3 OffsetsOf(const V3& middle, const PointTreeView& tree, VU point) {
  return V3{Gather(tree.x, point), Gather(tree.y, point), Gather(tree.z, point)} - middle;
}

// Returns the cells of neighbors.
HWY_INLINE VU CellsOf(const Frame& frame, const V3& offset, VF inner2, VF distance2) {
  const MU outer = hn::RebindMask(U(), hn::Gt(distance2, inner2));
  return hn::Or(OctantOf(Dot(frame.s, offset), Dot(frame.t, offset)),
                hn::IfThenElseZero(outer, SetU(kSectors)));
}

bool LooksWhole(const PhotonDisk& disk, PhotonKernel kernel, const PhotonColumns& photons,
                const PointTreeView& tree, const NeighborColumns& found, std::uint32_t n) {
  constexpr int kLeastCells = kDiskCells - 3;  // 50 uniform photons leave 0.6 cells empty
  const Frame frame = CellFrame(disk);
  const V3 middle = Set3(disk.point);
  const VF inner2 = Set(kCells[std::uint32_t(kernel)].inner2 * disk.radius2);
  const VF layer = Set(kLayerHeight * std::sqrt(disk.radius2));
  VU occupied = SetU(0);
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    const MU inside = RowsBelow(i, n);
    const VU point = hn::IfThenElseZero(inside, Load(found.point + i));
    const V3 offset = OffsetsOf(middle, tree, point);
    const V3 normal = DecodeNormal(Gather(photons.normal, point));
    const MF same = hn::Gt(hn::Abs(Dot(frame.n, normal)), Set(kLeastNormalCosine));
    const VF above = Dot(frame.n, DecodeNormal(Gather(photons.dir, point)));
    const MF counts = hn::And(hn::And(same, OnOneLayer(offset, frame.n, normal, layer)),
                              hn::Gt(above, hn::Zero(F())));
    if (!hn::AllTrue(U(), hn::Or(hn::RebindMask(U(), counts), hn::Not(inside)))) return false;
    const VU cell = CellsOf(frame, offset, inner2, Load(found.distance2 + i));
    occupied = hn::Or(occupied, hn::IfThenElseZero(inside, hn::Shl(SetU(1), cell)));
  }
  alignas(kColumnAlignment) std::uint32_t lanes[kPadRows] = {};
  Store(occupied, lanes);
  std::uint32_t bits = 0;
  for (const std::uint32_t lane : lanes) bits |= lane;
  return std::popcount(bits) >= kLeastCells;
}

void CloseUnseen(const PhotonDisk& disk, PhotonKernel kernel, const DiskSurface& surface,
                 const PhotonColumns& photons, const PointTreeView& tree,
                 const NeighborColumns& found, std::uint32_t n) {
  const Frame frame = CellFrame(disk);
  const V3 middle = Set3(disk.point);
  const VF inner2 = Set(kCells[std::uint32_t(kernel)].inner2 * disk.radius2);
  const VF layer = Set(kLayerHeight * std::sqrt(disk.radius2));
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    const VU point = hn::IfThenElseZero(RowsBelow(i, n), Load(found.point + i));
    const VF distance2 = Load(found.distance2 + i);
    const V3 offset = OffsetsOf(middle, tree, point);
    const VU cell = CellsOf(frame, offset, inner2, distance2);
    const VU bit = hn::And(hn::Shr(SetU(surface.seen), cell), SetU(1));
    const V3 seen = {Gather(surface.x, cell), Gather(surface.y, cell), Gather(surface.z, cell)};
    const V3 normal = {Gather(surface.normal_x, cell), Gather(surface.normal_y, cell),
                       Gather(surface.normal_z, cell)};
    const MF one_layer =
        OnOneLayer(offset - seen, normal, DecodeNormal(Gather(photons.normal, point)), layer);
    const MF open = hn::And(hn::RebindMask(F(), hn::Ne(bit, SetU(0))), one_layer);
    Store(IfThen(open, distance2, Set(std::numeric_limits<float>::infinity())),
          found.distance2 + i);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace skywave {

HWY_EXPORT(AimAtDisk);
HWY_EXPORT(LooksWhole);
HWY_EXPORT(FindSeenCells);
HWY_EXPORT(CloseUnseen);

bool LooksWhole(const PhotonDisk& disk, PhotonKernel kernel, const PhotonColumns& photons,
                const PointTreeView& tree, const NeighborColumns& found, std::uint32_t n) {
  return HWY_DYNAMIC_DISPATCH(LooksWhole)(disk, kernel, photons, tree, found, n);
}

void AimAtDisk(const PhotonDisk& disk, PhotonKernel kernel, const RayColumns& rays) {
  HWY_DYNAMIC_DISPATCH(AimAtDisk)(disk, kernel, rays);
}

void FindSeenCells(const PhotonDisk& disk, const TriangleRecord* triangles, const RayColumns& rays,
                   const HitColumns& hits, DiskSurface& surface) {
  HWY_DYNAMIC_DISPATCH(FindSeenCells)(disk, triangles, rays, hits, surface);
}

void CloseUnseen(const PhotonDisk& disk, PhotonKernel kernel, const DiskSurface& surface,
                 const PhotonColumns& photons, const PointTreeView& tree,
                 const NeighborColumns& found, std::uint32_t n) {
  HWY_DYNAMIC_DISPATCH(CloseUnseen)(disk, kernel, surface, photons, tree, found, n);
}

}  // namespace skywave
#endif  // HWY_ONCE
