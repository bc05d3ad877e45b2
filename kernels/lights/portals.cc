#include "kernels/lights/portals.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/lights/portals.cc"
#include "hwy/foreach_target.h"
#include "hwy/highway.h"
#include "kernels/simd/math-inl.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

constexpr float kBelowOne = 0x1.fffffep-1f;

// One portal per lane.
struct PortalLanes {
  V3 corner, x, y, z;
  VF size_x, size_y, unit;
  VU sums;
};
HWY_INLINE PortalLanes AllLanes(const PortalRecord& p) {
  return {Set3(p.corner), Set3(p.x),     Set3(p.y),   Set3(p.z),
          Set(p.size_x),  Set(p.size_y), Set(p.unit), SetU(p.sums)};
}
HWY_INLINE PortalLanes FetchPortals(const PortalsView& view, VU portal) {
  const auto* words = reinterpret_cast<const std::uint32_t*>(view.portals);
  const VU at = hn::ShiftLeft<kLogPortalWords>(portal);
  const auto word = [&](std::size_t k)
                        HWY_ATTR { return Gather(words, at + SetU(std::uint32_t(k))); };
  const auto vector = [&](std::size_t k) HWY_ATTR {
    return V3{AsFloat(word(k)), AsFloat(word(k + 1)), AsFloat(word(k + 2))};
  };
  return {vector(SKYWAVE_WORD(PortalRecord, corner)),
          vector(SKYWAVE_WORD(PortalRecord, x)),
          vector(SKYWAVE_WORD(PortalRecord, y)),
          vector(SKYWAVE_WORD(PortalRecord, z)),
          AsFloat(word(SKYWAVE_WORD(PortalRecord, size_x))),
          AsFloat(word(SKYWAVE_WORD(PortalRecord, size_y))),
          AsFloat(word(SKYWAVE_WORD(PortalRecord, unit))),
          word(SKYWAVE_WORD(PortalRecord, sums))};
}

// Returns the point of the surface itself, wherever its origin for rays has been put.
HWY_INLINE V3 PointOf(const V3& org, const V3& ng, VF lift) { return org - ng * lift; }
HWY_INLINE V3 PointOf(const SurfaceColumns& s, std::uint32_t i) {
  return PointOf(Load3(s.org_x + i, s.org_y + i, s.org_z + i),
                 Load3(s.ng_x + i, s.ng_y + i, s.ng_z + i), Load(s.lift + i));
}
HWY_INLINE V3 PointOf(const SurfaceColumns& s, VU row) {
  return PointOf({Gather(s.org_x, row), Gather(s.org_y, row), Gather(s.org_z, row)},
                 {Gather(s.ng_x, row), Gather(s.ng_y, row), Gather(s.ng_z, row)},
                 Gather(s.lift, row));
}

// Returns the corner of the portal as seen from a point, in the frame of the portal.
HWY_INLINE V3 CornerFrom(const PortalLanes& portal, const V3& point) {
  const V3 to = portal.corner - point;
  return {Dot(portal.x, to), Dot(portal.y, to), Dot(portal.z, to)};
}

// Returns the place of a direction on one axis of the rectified map [texels]; `ahead` is positive.
HWY_INLINE VF PlaceOf(const PortalsView& view, VF across, VF ahead) {
  const VF half_turns = Atan2Turn(across, ahead) + 0.25f;
  return Clamp(half_turns * (2.0f * float(view.texels)), 0.0f, float(view.texels));
}
HWY_INLINE VU TexelAt(const PortalsView& view, VF place) {
  return hn::Min(ToUnsigned(place), SetU(view.texels - 1));
}

// The texels of the rectified map that a point sees through a portal, also those of which it sees a
// part: whole texels take a fraction of the lookups, and directions beside the portal meet the
// wall.
struct Range {
  HWY_INLINE Range(const PortalsView& view, const PortalLanes& portal, const V3& corner)
      : left(TexelAt(view, PlaceOf(view, corner.x, corner.z))),
        right(TexelAt(view, PlaceOf(view, corner.x + portal.size_x, corner.z))),
        top(TexelAt(view, PlaceOf(view, corner.y, corner.z))),
        bottom(TexelAt(view, PlaceOf(view, corner.y + portal.size_y, corner.z))),
        open(hn::Gt(corner.z, hn::Zero(F()))) {}
  // Selects the points that see a texel.
  HWY_INLINE MF Holds(VU column, VU row) const {
    const MU beside = hn::Or(hn::Lt(column, left), hn::Lt(right, column));
    const MU above = hn::Or(hn::Lt(row, top), hn::Lt(bottom, row));
    return hn::AndNot(hn::RebindMask(F(), hn::Or(beside, above)), open);
  }
  VU left, right, top, bottom;  // the last ones are inside
  MF open;                      // the point is behind the portal
};

struct Found {
  VU texel;
  VF begin;  // the energy before the texel
};
// Finds the last texel in [first, last] before which there is no more energy than `target`, or the
// first one; before(edge) grows with the edge.
template <class Before>
HWY_INLINE Found FindTexel(VU first, VU last, VF target, const Before& before) {
  const VU one = SetU(1);
  Found found = {first, hn::Zero(F())};
  while (!hn::AllTrue(U(), hn::Eq(found.texel, last))) {
    const VU middle = hn::ShiftRight<1>(found.texel + last + one);
    const MU done = hn::Eq(found.texel, last);
    const VF begin = before(middle);
    const MU moves = hn::AndNot(done, hn::RebindMask(U(), hn::Ge(target, begin)));
    found.texel = IfThen(moves, middle, found.texel);
    found.begin = IfThen(hn::RebindMask(F(), moves), begin, found.begin);
    last = IfThen(hn::Or(done, moves), last, middle - one);
  }
  return found;
}
// Returns the place in the texel found that has `target` of the energy before it; `energy` is that
// of the texel.
HWY_INLINE VF PlaceIn(const Found& found, VF target, VF energy) {
  const VF part = (target - found.begin) / energy;
  return ToFloat(found.texel) + hn::Min(part, Set(kBelowOne));
}

// The energy of such a range. Differences of sums are those of whole numbers, so nothing is lost
// between bright texels.
class Window {
 public:
  HWY_INLINE Window(const PortalsView& view, const PortalLanes& portal, const Range& range)
      : view_(view), range_(range), sums_(portal.sums) {
    const VU stride = SetU(view.texels + 1), one = SetU(1);
    top_ = sums_ + range.top * stride;
    bottom_ = sums_ + (range.bottom + one) * stride;
    left_ = UpTo(range.left);
    const VF energy = ToFloat(UpTo(range.right + one) - left_);
    energy_ = hn::IfThenElseZero(range.open, energy);
  }

  // Returns its energy [units]; 0 where the point is not behind the portal.
  HWY_INLINE VF energy() const { return energy_; }

  // Draws a place in it.
  HWY_INLINE void Draw(VF u, VF v, VF& x, VF& y) const {
    const VF target_x = u * energy_;
    const Found column = FindTexel(range_.left, range_.right, target_x,
                                   [&](VU edge) HWY_ATTR { return ToFloat(UpTo(edge) - left_); });
    // The same again along the column.
    const VU begin = sums_ + column.texel * SetU(view_.texels + 1);
    const auto down_to = [&](VU edge) HWY_ATTR { return Gather(view_.columns, begin + edge); };
    const VU one = SetU(1), above = down_to(range_.top);
    const VF in_column = ToFloat(down_to(range_.bottom + one) - above);
    const VF target_y = v * in_column;
    const Found row = FindTexel(range_.top, range_.bottom, target_y,
                                [&](VU edge) HWY_ATTR { return ToFloat(down_to(edge) - above); });
    const VU in_texel = down_to(row.texel + one) - down_to(row.texel);
    x = PlaceIn(column, target_x, in_column);
    y = PlaceIn(row, target_y, ToFloat(in_texel));
  }

 private:
  // Returns the units of its rows up to an edge of a column.
  HWY_INLINE VU UpTo(VU edge) const {
    return Gather(view_.sums, bottom_ + edge) - Gather(view_.sums, top_ + edge);
  }

  const PortalsView& view_;
  const Range& range_;
  VU sums_, top_, bottom_, left_;
  VF energy_;
};

void PickPortals(const PortalsView& view, const SurfaceColumns& surfaces, const float* u,
                 float share, std::uint32_t n, float* energy, const PortalPickColumns& picks) {
  const VF zero = hn::Zero(F());
  alignas(kColumnAlignment) float seen[kMaxPortals][kPadRows];
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    const MF inside = hn::RebindMask(F(), RowsBelow(i, n));
    const V3 none = {zero, zero, zero};
    const V3 point = IfThen(inside, PointOf(surfaces, i), none);
    VF total = zero;
    for (std::uint32_t k = 0; k < view.count; ++k) {
      const PortalLanes portal = AllLanes(view.portals[k]);
      const Range range(view, portal, CornerFrom(portal, point));
      const VF through = Window(view, portal, range).energy() * portal.unit;
      Store(through, seen[k]);
      total = total + through;
    }
    const VF x = hn::IfThenElseZero(inside, Load(u + i));
    const MF lit = hn::Gt(total, zero);
    const MF through_portal = hn::And(lit, hn::Ge(x, Set(share)));
    // What is left of the uniform number goes on to the portal, or to the other technique.
    const VF other = share > 0 ? x / share : x;
    const VF rest = (x - share) / (1.0f - share);
    const VF target = rest * total;
    VU portal = SetU(kNoPortal);
    VF before = zero, begin = zero, width = Set(1.0f);
    for (std::uint32_t k = 0; k < view.count; ++k) {
      const VF through = Load(seen[k]);
      const MF here =
          hn::And(through_portal, hn::And(hn::Gt(through, zero), hn::Ge(target, before)));
      portal = IfThen(hn::RebindMask(U(), here), SetU(k), portal);
      begin = IfThen(here, before, begin);
      width = IfThen(here, through, width);
      before = before + through;
    }
    const VF in_portal = (target - begin) / width;
    const VF left = IfThen(through_portal, in_portal, IfThen(lit, other, x));
    StoreBelow(total, energy, i, n);
    Store(portal, picks.portal + i);
    Store(hn::Min(left, Set(kBelowOne)), picks.u + i);
  }
}

void SamplePortals(const PortalsView& view, const SurfaceColumns& surfaces,
                   const PortalPickColumns& picks, const float* v, std::uint32_t n,
                   const LightColumns& out) {
  const VF zero = hn::Zero(F());
  const VF texel = Set(0.5f / float(view.texels));  // [turns]
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    const VU picked = Load(picks.portal + i);
    const MU drawn = hn::AndNot(hn::Eq(picked, SetU(kNoPortal)), RowsBelow(i, n));
    const MF drawn_f = hn::RebindMask(F(), drawn);
    const PortalLanes portal = FetchPortals(view, hn::IfThenElseZero(drawn, picked));
    const V3 none = {zero, zero, zero};
    const V3 point = IfThen(drawn_f, PointOf(surfaces, i), none);
    VF x, y;
    const Range range(view, portal, CornerFrom(portal, point));
    Window(view, portal, range)
        .Draw(hn::IfThenElseZero(drawn_f, Load(picks.u + i)),
              hn::IfThenElseZero(drawn_f, Load(v + i)), x, y);
    // Angles count from -pi/2 on, so their sines are minus cosines of what follows.
    VF sin_x, cos_x, sin_y, cos_y;
    SinCosTurn(x * texel, cos_x, sin_x);
    SinCosTurn(y * texel, cos_y, sin_y);
    const V3 local = {-(sin_x * cos_y), -(sin_y * cos_x), cos_x * cos_y};
    const V3 world = portal.x * local.x + portal.y * local.y + portal.z * local.z;
    const V3 ahead = {zero, zero, Set(1.0f)};
    const MF good = hn::And(drawn_f, hn::Gt(Dot(world, world), zero));
    Store3(Normalize(IfThen(good, world, ahead)), out.dir_x + i, out.dir_y + i, out.dir_z + i);
  }
}

// Returns the energy [units] of a texel of the rectified map.
HWY_INLINE VF TexelEnergy(const PortalsView& view, VU sums, VU column, VU row) {
  const VU at = sums + column * SetU(view.texels + 1) + row;
  return ToFloat(Gather(view.columns, at + SetU(1)) - Gather(view.columns, at));
}

void MixPortalDensity(const PortalsView& view, const SurfaceColumns& surfaces, const float* energy,
                      const PortalDirections& directions, float share, float samples,
                      std::uint32_t n, float* pdf) {
  const VF zero = hn::Zero(F());
  const float texels_per_radian = float(view.texels) * kInvPi;
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    const MU inside = RowsBelow(i, n);
    const MF inside_f = hn::RebindMask(F(), inside);
    V3 point;
    VF total;
    if (directions.from == nullptr) {
      point = PointOf(surfaces, i);
      total = Load(energy + i);
    } else {
      const MF left = hn::Gt(Load(directions.bsdf_pdf + i), zero);
      const MU known = hn::And(inside, hn::RebindMask(U(), left));
      const VU from = hn::IfThenElseZero(known, Load(directions.from + i));
      point = PointOf(surfaces, from);
      total = Gather(energy, from);
    }
    const V3 dir = Load3(directions.dir_x + i, directions.dir_y + i, directions.dir_z + i);
    const MF lit = hn::And(inside_f, hn::Gt(total, zero));
    VF through = zero;  // share of the map's energy per square of angle
    for (std::uint32_t k = 0; k < view.count; ++k) {
      const PortalLanes portal = AllLanes(view.portals[k]);
      const V3 corner = CornerFrom(portal, point);
      const V3 local = {Dot(portal.x, dir), Dot(portal.y, dir), Dot(portal.z, dir)};
      const MF ahead = hn::And(lit, hn::Gt(local.z, zero));
      const V3 forward = {zero, zero, Set(1.0f)};
      const V3 seen = IfThen(ahead, local, forward);
      const VU column = TexelAt(view, PlaceOf(view, seen.x, seen.z));
      const VU row = TexelAt(view, PlaceOf(view, seen.y, seen.z));
      const MF passes = hn::And(ahead, Range(view, portal, corner).Holds(column, row));
      if (hn::AllFalse(F(), passes)) continue;
      const VF in_texel = TexelEnergy(view, portal.sums, column, row) * portal.unit;
      // The solid angle of a square of angles is (1 - x^2) (1 - y^2) / z.
      const VF z2 = seen.z * seen.z;
      const VF stretch = (z2 + seen.y * seen.y) * (z2 + seen.x * seen.x);
      const VF density = in_texel * (seen.z / hn::Max(stretch, Set(1e-30f)));
      through = through + hn::IfThenElseZero(passes, density);
    }
    const VF other = Load(pdf + i);
    const VF scale = Set((1.0f - share) * texels_per_radian * texels_per_radian);
    const VF mixed = share * other + scale * (through / IfThen(lit, total, Set(1.0f)));
    StoreBelow(samples * IfThen(lit, mixed, other), pdf, i, n);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace skywave {

HWY_EXPORT(PickPortals);
HWY_EXPORT(SamplePortals);
HWY_EXPORT(MixPortalDensity);

void PickPortals(const PortalsView& view, const SurfaceColumns& surfaces, const float* u,
                 float share, std::uint32_t n, float* energy, const PortalPickColumns& picks) {
  HWY_DYNAMIC_DISPATCH(PickPortals)(view, surfaces, u, share, n, energy, picks);
}
void SamplePortals(const PortalsView& view, const SurfaceColumns& surfaces,
                   const PortalPickColumns& picks, const float* v, std::uint32_t n,
                   const LightColumns& out) {
  HWY_DYNAMIC_DISPATCH(SamplePortals)(view, surfaces, picks, v, n, out);
}
void MixPortalDensity(const PortalsView& view, const SurfaceColumns& surfaces, const float* energy,
                      const PortalDirections& directions, float share, float samples,
                      std::uint32_t n, float* pdf) {
  HWY_DYNAMIC_DISPATCH(MixPortalDensity)
  (view, surfaces, energy, directions, share, samples, n, pdf);
}

}  // namespace skywave
#endif  // HWY_ONCE
