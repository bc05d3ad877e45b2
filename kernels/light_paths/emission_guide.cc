#include "kernels/light_paths/emission_guide.h"

#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/light_paths/emission_guide.cc"
#include "hwy/foreach_target.h"
#include "hwy/highway.h"
#include "kernels/light_paths/emission-inl.h"
#include "kernels/lights/environment-inl.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

HWY_INLINE VU GuideCellOf(const V3& towards) {
  const VF half = Set(0.5f);
  const VU row = CellOf(towards.z * half + half, kGuideRows);
  const VU turn = CellOf(Atan2Turn(towards.y, towards.x) + half, kGuideTurns);
  return row * SetU(kGuideTurns) + turn;
}

// These are the fields of one cell per lane.
struct CellLanes {
  VU cell;
  VF gain, even, focused;
  VF low[2], high[2];

  HWY_INLINE CellLanes(const EmissionGuideView& guide, VU of) : cell(of) {
    static_assert(kGuideCellFloats == 8);
    const auto* const floats = reinterpret_cast<const float*>(guide.cells);
    const VU first = hn::ShiftLeft<3>(cell);
    const auto field = [&](std::uint32_t i) HWY_ATTR { return Gather(floats + i, first); };
    gain = field(0), even = field(1), focused = field(2);
    low[0] = field(3), low[1] = field(4), high[0] = field(5), high[1] = field(6);
  }
};

// This is one leaf of the boxes' trees per lane.
struct Leaf {
  VF low[2], width[2];
  // Returns the density of starts that the trees place [1 / area of the square].
  HWY_INLINE VF density() const { return (1.0f / kGuideLeaves) / (width[0] * width[1]); }
};

// Walks down the trees; `goes_up(axis, cut)` selects the lanes that go to the upper part.
template <class GoesUp>
HWY_INLINE Leaf Descend(const EmissionGuideView& guide, const CellLanes& c, const GoesUp& goes_up) {
  VF low[2] = {c.low[0], c.low[1]}, high[2] = {c.high[0], c.high[1]};
  const VU tree = hn::ShiftLeft<kGuideLevels>(c.cell);
  VU node = SetU(1);
  for (std::uint32_t level = 0; level < kGuideLevels; ++level) {
    const std::uint32_t axis = level & 1;
    const VF cut = Gather(guide.cuts, tree + node);
    const MF up = goes_up(axis, cut);
    low[axis] = IfThen(up, cut, low[axis]);
    high[axis] = IfThen(up, high[axis], cut);
    const VU one = hn::IfThenElseZero(hn::RebindMask(U(), up), SetU(1));
    node = node + node + one;
  }
  return {{low[0], low[1]}, {high[0] - low[0], high[1] - low[1]}};
}

// A line along `towards` enters the scene's disk at (u, v).
struct Line {
  V3 point;
  VF u, v;
};

// Returns how crowded starts are where a line enters, given its direction: their density over the
// uniform one.
HWY_INLINE VF Crowding(const SceneSphere& sphere, const EmissionGuideView& guide,
                       const CellLanes& c, const V3& towards, const Line& line) {
  const VF at[2] = {line.u, line.v};
  const Leaf leaf =
      Descend(guide, c, [&](std::uint32_t axis, VF cut) HWY_ATTR { return hn::Ge(at[axis], cut); });
  MF boxed = hn::And(hn::Ge(line.u, c.low[0]), hn::Le(line.u, c.high[0]));
  boxed = hn::And(boxed, hn::And(hn::Ge(line.v, c.low[1]), hn::Le(line.v, c.high[1])));
  const VF others = 1.0f - c.even - c.focused;

  const V3 from = line.point - Set3(guide.focus.center);
  const V3 across = from - towards * Dot(from, towards);
  // Starts on the rim must not round to the outside, where their flux would be divided by too
  // little.
  const float rim = guide.focus.radius + 0x1p-20f * sphere.radius;
  const MF seen = hn::Le(Dot(across, across), Set(rim * rim));
  const float narrower = sphere.radius / guide.focus.radius;
  return c.even + hn::IfThenElseZero(boxed, others * leaf.density()) +
         hn::IfThenElseZero(seen, c.focused * (narrower * narrower));
}

// Returns the line along `towards` through surface `row`.
HWY_INLINE Line LineOf(const SceneSphere& sphere, const V3& towards, const SurfaceColumns& s,
                       VU row) {
  const V3 ng = {Gather(s.ng_x, row), Gather(s.ng_y, row), Gather(s.ng_z, row)};
  const V3 org = {Gather(s.org_x, row), Gather(s.org_y, row), Gather(s.org_z, row)};
  Line line = {.point = org - ng * Gather(s.lift, row)};
  DiskPlace(sphere, towards, line.point, line.u, line.v);
  return line;
}

HWY_INLINE V3 Towards(const EnvironmentLines& lines, std::uint32_t i) {
  return Load3(lines.dir_x + i, lines.dir_y + i, lines.dir_z + i);
}
// Rows beyond n may be anything.
HWY_INLINE VU RowOf(const EnvironmentLines& lines, std::uint32_t i, std::uint32_t n) {
  const VU row = lines.rows != nullptr ? Load(lines.rows + i) : hn::Iota(U(), i);
  return hn::IfThenElseZero(RowsBelow(i, n), row);
}

void LocateOnDisk(const SceneSphere& sphere, const EnvironmentLines& lines, std::uint32_t n,
                  const DiskPlaceColumns& places) {
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    const V3 towards = Towards(lines, i);
    const Line line = LineOf(sphere, towards, lines.surfaces, RowOf(lines, i, n));
    Store(GuideCellOf(towards), places.cell + i);
    Store(line.u, places.u + i), Store(line.v, places.v + i);
  }
}

void FindGuideCells(const float* dir_x, const float* dir_y, const float* dir_z, std::uint32_t n,
                    std::uint32_t* cell) {
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    Store(GuideCellOf(Load3(dir_x + i, dir_y + i, dir_z + i)), cell + i);
  }
}

HWY_INLINE VF EvenDensity(const SceneSphere& sphere) {
  return Set(1 / (kPi * sphere.radius * sphere.radius));
}

void EnvironmentArrivals(const SceneSphere& sphere, const EmissionGuideView& guide,
                         const EnvironmentLines& lines, std::uint32_t n, float* arrival) {
  const VF even = EvenDensity(sphere), one = Set(1.0f);
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    if (guide.cells == nullptr) {
      Store(even, arrival + i);
      continue;
    }
    const V3 towards = Towards(lines, i);
    const VU cell = hn::IfThenElseZero(RowsBelow(i, n), GuideCellOf(towards));
    const Line line = LineOf(sphere, towards, lines.surfaces, RowOf(lines, i, n));
    const CellLanes c(guide, cell);
    const VF crowding = Crowding(sphere, guide, c, towards, line);
    VF gain = c.gain;
    if (lines.pdf != nullptr) gain = IfThen(hn::Lt(Load(lines.pdf + i), Set(kPunctual)), gain, one);
    Store(even * gain * crowding, arrival + i);
  }
}

// Warps a pair of uniforms to the place where a line enters, outside the scene's sphere.
HWY_INLINE Line Warp(const SceneSphere& sphere, const EmissionGuideView& guide, const CellLanes& c,
                     const V3& towards, VF u, VF v) {
  const VF one = Set(1.0f);
  const VF split = c.even + c.focused;
  const MF even = hn::Lt(u, c.even), boxed = hn::Ge(u, split);
  // The choice leaves a rest of u.
  const VF start = IfThen(boxed, split, hn::IfThenElseZero(hn::Ge(u, c.even), c.even));
  const VF length = IfThen(boxed, one - split, IfThen(even, c.even, c.focused));
  u = hn::Min((u - start) / length, Set(0x1.fffffep-1f));
  // The digits leave a rest of both.
  VF rest[2] = {u, v};
  const Leaf leaf = Descend(guide, c, [&](std::uint32_t axis, VF) HWY_ATTR {
    const VF twice = rest[axis] + rest[axis];
    const MF up = hn::Ge(twice, one);
    rest[axis] = twice - hn::IfThenElseZero(up, one);
    return up;
  });
  Line line;
  const auto in_leaf = [&](int axis) HWY_ATTR {
    const VF place = leaf.low[axis] + rest[axis] * leaf.width[axis];
    return hn::Min(place, c.high[axis]);
  };
  line.u = IfThen(boxed, in_leaf(0), u);
  line.v = IfThen(boxed, in_leaf(1), v);
  line.point = DiskPoint(sphere, towards, line.u, line.v);
  const MF focused = hn::Not(hn::Or(even, boxed));
  if (hn::AllFalse(F(), focused)) return line;
  V3 in_focus = DiskPoint(guide.focus, towards, u, v);
  const VF inside = Dot(in_focus - Set3(sphere.center), towards);
  in_focus = in_focus + towards * (sphere.radius - inside);
  VF focus_u, focus_v;
  DiskPlace(sphere, towards, in_focus, focus_u, focus_v);
  return {IfThen(focused, in_focus, line.point), IfThen(focused, focus_u, line.u),
          IfThen(focused, focus_v, line.v)};
}

void GuideStarts(const SceneSphere& sphere, const EmissionGuideView& guide,
                 const UniformColumns& disk, const float* light_pdf, std::uint32_t n,
                 const RayColumns& rays, const EmissionColumns& emission) {
  const VF even = EvenDensity(sphere);
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    const MU of_environment = hn::Eq(Load(emission.light + i), SetU(kNoLight));
    const MU directional = hn::TestBit(Load(emission.delta + i), SetU(kDeltaDirection));
    const MU distant = hn::And(RowsBelow(i, n), hn::Or(of_environment, directional));
    if (hn::AllFalse(U(), distant)) continue;
    const MF rows = hn::RebindMask(F(), distant);
    const auto store = [&](VF value, float* to)
                           HWY_ATTR { Store(IfThen(rows, value, Load(to + i)), to + i); };
    const V3 towards = -Load3(rays.dir_x + i, rays.dir_y + i, rays.dir_z + i);
    const VU cell = hn::IfThenElseZero(distant, GuideCellOf(towards));
    const CellLanes c(guide, cell);
    const Line line = Warp(sphere, guide, c, towards, Load(disk.u + i), Load(disk.v + i));
    const VF crowding = Crowding(sphere, guide, c, towards, line);
    const V3 org = EnterBox(sphere, line.point, -towards);
    store(org.x, rays.org_x), store(org.y, rays.org_y), store(org.z, rays.org_z);
    const VF factor = 1.0f / crowding;
    for (float* const flux : {rays.throughput_r, rays.throughput_g, rays.throughput_b}) {
      store(Load(flux + i) * factor, flux);
    }
    VF of_light = Load(emission.light_pdf + i);
    if (light_pdf != nullptr) {
      of_light = IfThen(hn::RebindMask(F(), of_environment), Load(light_pdf + i), of_light);
    }
    const VF gain = IfThen(hn::RebindMask(F(), directional), Set(1.0f), c.gain);
    const VF arrival = even * gain * crowding;
    store(of_light, emission.light_pdf);
    store(of_light * arrival, emission.pdf);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace skywave {

HWY_EXPORT(LocateOnDisk);
HWY_EXPORT(FindGuideCells);
HWY_EXPORT(EnvironmentArrivals);
HWY_EXPORT(GuideStarts);

void LocateOnDisk(const SceneSphere& sphere, const EnvironmentLines& lines, std::uint32_t n,
                  const DiskPlaceColumns& places) {
  HWY_DYNAMIC_DISPATCH(LocateOnDisk)(sphere, lines, n, places);
}
void FindGuideCells(const float* dir_x, const float* dir_y, const float* dir_z, std::uint32_t n,
                    std::uint32_t* cell) {
  HWY_DYNAMIC_DISPATCH(FindGuideCells)(dir_x, dir_y, dir_z, n, cell);
}
void EnvironmentArrivals(const SceneSphere& sphere, const EmissionGuideView& guide,
                         const EnvironmentLines& lines, std::uint32_t n, float* arrival) {
  HWY_DYNAMIC_DISPATCH(EnvironmentArrivals)(sphere, guide, lines, n, arrival);
}
void GuideStarts(const SceneSphere& sphere, const EmissionGuideView& guide,
                 const UniformColumns& disk, const float* light_pdf, std::uint32_t n,
                 const RayColumns& rays, const EmissionColumns& emission) {
  HWY_DYNAMIC_DISPATCH(GuideStarts)(sphere, guide, disk, light_pdf, n, rays, emission);
}

}  // namespace skywave
#endif  // HWY_ONCE
