#include "kernels/emission_guide.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/emission_guide.cc"
#include "hwy/foreach_target.h"
#include "hwy/highway.h"
#include "kernels/disk-inl.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

// A part of one of `parts` equal ones of [0, 1].
HWY_INLINE VU PartOf(VF x, std::uint32_t parts) {
  return hn::Min(ToUnsigned(hn::Max(hn::Mul(x, Set(float(parts))), hn::Zero(F()))),
                 SetU(parts - 1));
}

HWY_INLINE VU GuideCell(const V3& towards) {
  const VF half = Set(0.5f);
  const VU row = PartOf(hn::Add(hn::Mul(towards.z, half), half), kGuideRows);
  const VU turn = PartOf(hn::Add(Atan2Turn(towards.y, towards.x), half), kGuideTurns);
  return hn::Add(hn::Mul(row, SetU(kGuideTurns)), turn);
}

// A point of the square, and the density there of what the tree draws.
struct Place {
  VF at[2];
  VF density;
};

// Walks down the trees of the cells: `goes_up(axis, cut)` says in which lanes to the upper part.
// `inside`: where in the leaf that is found, in [0, 1), in u and v; read at the end.
template <class GoesUp>
HWY_INLINE Place Descend(const EmissionGuideView& guide, VU cell, const VF (&inside)[2],
                         const GoesUp& goes_up) {
  VF low[2] = {hn::Zero(F()), hn::Zero(F())}, high[2] = {Set(1.0f), Set(1.0f)};
  const VU tree = hn::ShiftLeft<kGuideLevels>(cell);
  VU node = SetU(1);
  for (std::uint32_t level = 0; level < kGuideLevels; ++level) {
    const std::uint32_t axis = level & 1;
    const VF cut = Gather(guide.cuts, hn::Add(tree, node));
    const MF up = goes_up(axis, cut);
    low[axis] = IfThen(up, cut, low[axis]);
    high[axis] = IfThen(up, high[axis], cut);
    const VU one = hn::IfThenElseZero(hn::RebindMask(U(), up), SetU(1));
    node = hn::Add(hn::Add(node, node), one);
  }
  const VF width[2] = {hn::Sub(high[0], low[0]), hn::Sub(high[1], low[1])};
  return {{hn::Add(low[0], hn::Mul(inside[0], width[0])),
           hn::Add(low[1], hn::Mul(inside[1], width[1]))},
          hn::Div(Set(1.0f / kGuideLeaves), hn::Mul(width[0], width[1]))};
}

// Where on the disk the line along `towards` through surface `row` enters.
HWY_INLINE void PlaceOf(const SceneSphere& sphere, const V3& towards, const SurfaceColumns& s,
                        VU row, VF& u, VF& v) {
  const V3 ng = {Gather(s.ng_x, row), Gather(s.ng_y, row), Gather(s.ng_z, row)};
  const V3 org = {Gather(s.org_x, row), Gather(s.org_y, row), Gather(s.org_z, row)};
  DiskPlace(sphere, towards, Sub(org, Scale(ng, Gather(s.lift, row))), u, v);
}

HWY_INLINE V3 Towards(const SkyLines& lines, std::uint32_t i) {
  return Load3(lines.dir_x + i, lines.dir_y + i, lines.dir_z + i);
}
// Rows behind n may be anything.
HWY_INLINE VU RowOf(const SkyLines& lines, std::uint32_t i, std::uint32_t n) {
  const VU row = lines.rows != nullptr ? Load(lines.rows + i) : hn::Iota(U(), i);
  return hn::IfThenElseZero(RowsBelow(i, n), row);
}

void LocateOnDisk(const SceneSphere& sphere, const SkyLines& lines, std::uint32_t n,
                  const DiskPlaceColumns& places) {
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    const V3 towards = Towards(lines, i);
    VF u, v;
    PlaceOf(sphere, towards, lines.surfaces, RowOf(lines, i, n), u, v);
    Store(GuideCell(towards), places.cell + i);
    Store(u, places.u + i), Store(v, places.v + i);
  }
}

void FindGuideCells(const float* dir_x, const float* dir_y, const float* dir_z, std::uint32_t n,
                    std::uint32_t* cell) {
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    Store(GuideCell(Load3(dir_x + i, dir_y + i, dir_z + i)), cell + i);
  }
}

HWY_INLINE VF EvenDensity(const SceneSphere& sphere) {
  return Set(1 / (kPi * sphere.radius * sphere.radius));
}

void SkyArrivals(const SceneSphere& sphere, const EmissionGuideView& guide, const SkyLines& lines,
                 std::uint32_t n, float* arrival) {
  const VF even = EvenDensity(sphere);
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    if (guide.cuts == nullptr) {
      Store(even, arrival + i);
      continue;
    }
    const V3 towards = Towards(lines, i);
    const VU cell = hn::IfThenElseZero(RowsBelow(i, n), GuideCell(towards));
    VF at[2];
    PlaceOf(sphere, towards, lines.surfaces, RowOf(lines, i, n), at[0], at[1]);
    const Place place = Descend(guide, cell, at, [&](std::uint32_t axis, VF cut) HWY_ATTR {
      return hn::Ge(at[axis], cut);
    });
    Store(hn::Mul(hn::Mul(even, Gather(guide.gain, cell)), place.density), arrival + i);
  }
}

void GuideStarts(const SceneSphere& sphere, const EmissionGuideView& guide,
                 const UniformColumns& disk, const float* light_pdf, std::uint32_t n,
                 const RayColumns& rays, const EmissionColumns& emission) {
  const VF even = EvenDensity(sphere), one = Set(1.0f);
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    const MU of_sky = hn::And(RowsBelow(i, n), hn::Eq(Load(emission.light + i), SetU(kNoLight)));
    if (hn::AllFalse(U(), of_sky)) continue;
    const MF rows = hn::RebindMask(F(), of_sky);
    const auto store = [&](VF value, float* to)
                           HWY_ATTR { Store(IfThen(rows, value, Load(to + i)), to + i); };
    const V3 towards = Neg(Load3(rays.dir_x + i, rays.dir_y + i, rays.dir_z + i));
    const VU cell = hn::IfThenElseZero(of_sky, GuideCell(towards));
    // The digits that have been used up leave a uniform number.
    VF rest[2] = {Load(disk.u + i), Load(disk.v + i)};
    const Place place = Descend(guide, cell, rest, [&](std::uint32_t axis, VF) HWY_ATTR {
      const VF twice = hn::Add(rest[axis], rest[axis]);
      const MF up = hn::Ge(twice, one);
      rest[axis] = hn::Sub(twice, hn::IfThenElseZero(up, one));
      return up;
    });
    const V3 org = DiskPoint(sphere, towards, place.at[0], place.at[1]);
    store(org.x, rays.org_x), store(org.y, rays.org_y), store(org.z, rays.org_z);
    const VF factor = hn::Div(one, place.density);
    for (float* const flux : {rays.throughput_r, rays.throughput_g, rays.throughput_b}) {
      store(hn::Mul(Load(flux + i), factor), flux);
    }
    const VF of_light = Load(light_pdf != nullptr ? light_pdf + i : emission.light_pdf + i);
    const VF arrival = hn::Mul(hn::Mul(even, Gather(guide.gain, cell)), place.density);
    store(of_light, emission.light_pdf);
    store(hn::Mul(of_light, arrival), emission.pdf);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace skywave {

HWY_EXPORT(LocateOnDisk);
HWY_EXPORT(FindGuideCells);
HWY_EXPORT(SkyArrivals);
HWY_EXPORT(GuideStarts);

void LocateOnDisk(const SceneSphere& sphere, const SkyLines& lines, std::uint32_t n,
                  const DiskPlaceColumns& places) {
  HWY_DYNAMIC_DISPATCH(LocateOnDisk)(sphere, lines, n, places);
}
void FindGuideCells(const float* dir_x, const float* dir_y, const float* dir_z, std::uint32_t n,
                    std::uint32_t* cell) {
  HWY_DYNAMIC_DISPATCH(FindGuideCells)(dir_x, dir_y, dir_z, n, cell);
}
void SkyArrivals(const SceneSphere& sphere, const EmissionGuideView& guide, const SkyLines& lines,
                 std::uint32_t n, float* arrival) {
  HWY_DYNAMIC_DISPATCH(SkyArrivals)(sphere, guide, lines, n, arrival);
}
void GuideStarts(const SceneSphere& sphere, const EmissionGuideView& guide,
                 const UniformColumns& disk, const float* light_pdf, std::uint32_t n,
                 const RayColumns& rays, const EmissionColumns& emission) {
  HWY_DYNAMIC_DISPATCH(GuideStarts)(sphere, guide, disk, light_pdf, n, rays, emission);
}

}  // namespace skywave
#endif  // HWY_ONCE
