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
                        HWY_ATTR { return Gather(words, hn::Add(at, SetU(std::uint32_t(k)))); };
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
HWY_INLINE V3 PointOf(const V3& org, const V3& ng, VF lift) { return Sub(org, Scale(ng, lift)); }
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
  const V3 to = Sub(portal.corner, point);
  return {Dot(portal.x, to), Dot(portal.y, to), Dot(portal.z, to)};
}

// Returns the place of a direction on one axis of the rectified map [texels]; `ahead` is positive.
HWY_INLINE VF PlaceOf(const PortalsView& view, VF across, VF ahead) {
  const VF half_turns = hn::Add(Atan2Turn(across, ahead), Set(0.25f));
  return Clamp(hn::Mul(half_turns, Set(2.0f * float(view.texels))), 0.0f, float(view.texels));
}
HWY_INLINE VU TexelAt(const PortalsView& view, VF place) {
  return hn::Min(ToUnsigned(place), SetU(view.texels - 1));
}

// An interval on one axis of the rectified map: it begins in texel `first`, of which it has the
// part `in_first` of the texel's length, and ends in texel `last`. If both are the same, in_last is
// 0.
struct Interval {
  HWY_INLINE Interval(const PortalsView& view, VF begin, VF end)
      : low(begin), high(hn::Max(begin, end)) {
    first = TexelAt(view, low), last = TexelAt(view, high);
    same = hn::Eq(first, last);
    const MF same_f = hn::RebindMask(F(), same);
    const VF after_first = ToFloat(hn::Add(first, SetU(1)));
    in_first = hn::Sub(IfThen(same_f, high, after_first), low);
    in_last = IfThen(same_f, hn::Zero(F()), hn::Sub(high, ToFloat(last)));
  }
  VF low, high;
  VU first, last;
  MU same;
  VF in_first, in_last;
};

struct Found {
  VU texel;
  VF begin;  // the energy of the interval before the texel
};
// Finds the texel of an interval in which the energy up to it reaches `target`. before(edge) is the
// energy of whole texels from the second one up to an edge, and `in_first` that of the first one.
template <class Before>
HWY_INLINE Found FindTexel(const Interval& interval, VF in_first, VF target, const Before& before) {
  const VU one = SetU(1);
  Found found = {interval.first, hn::Zero(F())};
  VU last = interval.last;
  while (!hn::AllTrue(U(), hn::Eq(found.texel, last))) {
    const VU middle = hn::ShiftRight<1>(hn::Add(hn::Add(found.texel, last), one));
    const MU done = hn::Eq(found.texel, last);
    const VF begin = hn::Add(in_first, before(middle));
    const MF behind = hn::Ge(target, begin);
    const MU moves = hn::AndNot(done, hn::RebindMask(U(), behind));
    found.texel = IfThen(moves, middle, found.texel);
    found.begin = IfThen(hn::RebindMask(F(), moves), begin, found.begin);
    last = IfThen(hn::Or(done, moves), last, hn::Sub(middle, one));
  }
  return found;
}
// Returns the place in the texel found that has `target` of the energy before it; `energy` is that
// of the whole texel.
HWY_INLINE VF PlaceIn(const Interval& interval, const Found& found, VF target, VF energy) {
  const MF is_first = hn::RebindMask(F(), hn::Eq(found.texel, interval.first));
  const VF from = IfThen(is_first, interval.low, ToFloat(found.texel));
  const VF end = hn::Min(ToFloat(hn::Add(found.texel, SetU(1))), interval.high);
  return hn::Min(hn::Add(from, hn::Div(hn::Sub(target, found.begin), energy)), end);
}

// What a point sees of the rectified map through a portal.
class Window {
 public:
  // `corner` is that of the portal from the point.
  HWY_INLINE Window(const PortalsView& view, const PortalLanes& portal, const V3& corner)
      : x_(view, PlaceOf(view, corner.x, corner.z),
           PlaceOf(view, hn::Add(corner.x, portal.size_x), corner.z)),
        y_(view, PlaceOf(view, corner.y, corner.z),
           PlaceOf(view, hn::Add(corner.y, portal.size_y), corner.z)),
        table_(view.sums),
        columns_(view.columns),
        stride_(view.texels + 1),
        sums_(portal.sums) {
    const VU stride = SetU(stride_), one = SetU(1);
    row_[0] = hn::Add(sums_, hn::Mul(y_.first, stride));
    row_[1] = hn::Add(row_[0], stride);
    // One row has no others behind it.
    const VU last = hn::Add(sums_, hn::Mul(y_.last, stride));
    row_[2] = IfThen(y_.same, row_[1], last);
    row_[3] = IfThen(y_.same, row_[1], hn::Add(last, stride));

    second_ = UpTo(hn::Add(x_.first, one));
    in_first_ = hn::Mul(x_.in_first, Between(UpTo(x_.first), second_));
    const Sums last_edge = UpTo(x_.last);
    const VF in_last = hn::Mul(x_.in_last, Between(last_edge, UpTo(hn::Add(x_.last, one))));
    const VF others = hn::Add(Between(second_, last_edge), in_last);
    const VF energy = IfThen(hn::RebindMask(F(), x_.same), in_first_, hn::Add(in_first_, others));
    energy_ = hn::IfThenElseZero(hn::Gt(corner.z, hn::Zero(F())), energy);
  }

  // Returns its energy [units]; 0 where the point is not behind the portal.
  HWY_INLINE VF energy() const { return energy_; }

  // Draws a place in it.
  HWY_INLINE void Draw(VF u, VF v, VF& x, VF& y) const {
    const VF target = hn::Mul(u, energy_);
    const Found column = FindTexel(x_, in_first_, target,
                                   [&](VU edge) HWY_ATTR { return Between(second_, UpTo(edge)); });
    const VU left = column.texel, right = hn::Add(left, SetU(1));
    const VF in_column = Between(UpTo(left), UpTo(right));
    x = PlaceIn(x_, column, target, in_column);
    // The same again along the column.
    const VU begin = hn::Add(sums_, hn::Mul(left, SetU(stride_)));
    const auto up_to = [&](VU row) HWY_ATTR { return Gather(columns_, hn::Add(begin, row)); };
    const VU second = up_to(hn::Add(y_.first, SetU(1)));
    const VF in_first = hn::Mul(y_.in_first, ToFloat(hn::Sub(second, up_to(y_.first))));
    const VF target_y = hn::Mul(v, in_column);
    const Found row = FindTexel(y_, in_first, target_y, [&](VU edge) HWY_ATTR {
      return ToFloat(hn::Sub(up_to(edge), second));
    });
    const VU in_texel = hn::Sub(up_to(hn::Add(row.texel, SetU(1))), up_to(row.texel));
    y = PlaceIn(y_, row, target_y, ToFloat(in_texel));
  }

 private:
  // Units of the window's first row, whole rows and last row, up to an edge of a column.
  struct Sums {
    VU first, whole, last;
  };
  HWY_INLINE Sums UpTo(VU edge) const {
    VU sum[4];
    for (int k = 0; k < 4; ++k) sum[k] = Gather(table_, hn::Add(row_[k], edge));
    return {hn::Sub(sum[1], sum[0]), hn::Sub(sum[2], sum[1]), hn::Sub(sum[3], sum[2])};
  }
  // Returns the energy of the window's rows between two edges. The differences are those of whole
  // numbers, so nothing is lost between bright texels.
  HWY_INLINE VF Between(const Sums& left, const Sums& right) const {
    const VF first = ToFloat(hn::Sub(right.first, left.first));
    const VF whole = ToFloat(hn::Sub(right.whole, left.whole));
    const VF last = ToFloat(hn::Sub(right.last, left.last));
    return hn::Add(hn::Add(hn::Mul(y_.in_first, first), whole), hn::Mul(y_.in_last, last));
  }

  Interval x_, y_;
  const std::uint32_t *table_, *columns_;
  std::uint32_t stride_;
  VU sums_;
  VU row_[4];  // edges of rows: of the first one, of the last one
  Sums second_;
  VF in_first_, energy_;
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
      const VF through =
          hn::Mul(Window(view, portal, CornerFrom(portal, point)).energy(), portal.unit);
      Store(through, seen[k]);
      total = hn::Add(total, through);
    }
    const VF x = hn::IfThenElseZero(inside, Load(u + i));
    const MF lit = hn::Gt(total, zero);
    const MF through_portal = hn::And(lit, hn::Ge(x, Set(share)));
    // What is left of the uniform number goes on to the portal, or to the other technique.
    const VF other = share > 0 ? hn::Div(x, Set(share)) : x;
    const VF rest = hn::Div(hn::Sub(x, Set(share)), Set(1.0f - share));
    const VF target = hn::Mul(rest, total);
    VU portal = SetU(kNoPortal);
    VF before = zero, begin = zero, width = Set(1.0f);
    for (std::uint32_t k = 0; k < view.count; ++k) {
      const VF through = Load(seen[k]);
      const MF here =
          hn::And(through_portal, hn::And(hn::Gt(through, zero), hn::Ge(target, before)));
      portal = IfThen(hn::RebindMask(U(), here), SetU(k), portal);
      begin = IfThen(here, before, begin);
      width = IfThen(here, through, width);
      before = hn::Add(before, through);
    }
    const VF in_portal = hn::Div(hn::Sub(target, begin), width);
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
    Window(view, portal, CornerFrom(portal, point))
        .Draw(hn::IfThenElseZero(drawn_f, Load(picks.u + i)),
              hn::IfThenElseZero(drawn_f, Load(v + i)), x, y);
    // Angles count from -pi/2 on, so their sines are minus cosines of what follows.
    VF sin_x, cos_x, sin_y, cos_y;
    SinCosTurn(hn::Mul(x, texel), cos_x, sin_x);
    SinCosTurn(hn::Mul(y, texel), cos_y, sin_y);
    const V3 local = {hn::Neg(hn::Mul(sin_x, cos_y)), hn::Neg(hn::Mul(sin_y, cos_x)),
                      hn::Mul(cos_x, cos_y)};
    const V3 world =
        Add(Add(Scale(portal.x, local.x), Scale(portal.y, local.y)), Scale(portal.z, local.z));
    const V3 ahead = {zero, zero, Set(1.0f)};
    const MF good = hn::And(drawn_f, hn::Gt(Dot(world, world), zero));
    Store3(Normalize(IfThen(good, world, ahead)), out.dir_x + i, out.dir_y + i, out.dir_z + i);
  }
}

// Returns the energy [units] of a direction's texel in the rectified map.
HWY_INLINE VF TexelEnergy(const PortalsView& view, VU sums, const V3& local) {
  const VU column = TexelAt(view, PlaceOf(view, local.x, local.z));
  const VU row = TexelAt(view, PlaceOf(view, local.y, local.z));
  const VU above = hn::Add(hn::Add(sums, hn::Mul(row, SetU(view.texels + 1))), column);
  const VU below = hn::Add(above, SetU(view.texels + 1));
  const VU one = SetU(1);
  const VU of_below = hn::Sub(Gather(view.sums, hn::Add(below, one)), Gather(view.sums, below));
  const VU of_above = hn::Sub(Gather(view.sums, hn::Add(above, one)), Gather(view.sums, above));
  return ToFloat(hn::Sub(of_below, of_above));
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
      // The direction meets the plane of the portal where local is corner.z / local.z times itself.
      const auto meets = [&](VF along, VF from, VF size) HWY_ATTR {
        const VF reached = hn::Mul(along, corner.z);
        return hn::And(hn::Ge(reached, hn::Mul(from, local.z)),
                       hn::Le(reached, hn::Mul(hn::Add(from, size), local.z)));
      };
      const MF ahead = hn::And(hn::Gt(corner.z, zero), hn::Gt(local.z, zero));
      const MF passes =
          hn::And(hn::And(lit, ahead), hn::And(meets(local.x, corner.x, portal.size_x),
                                               meets(local.y, corner.y, portal.size_y)));
      if (hn::AllFalse(F(), passes)) continue;
      const V3 forward = {zero, zero, Set(1.0f)};
      const V3 seen = IfThen(passes, local, forward);
      const VF in_texel = hn::Mul(TexelEnergy(view, portal.sums, seen), portal.unit);
      // The solid angle of a square of angles is (1 - x^2) (1 - y^2) / z.
      const VF z2 = hn::Mul(seen.z, seen.z);
      const VF stretch =
          hn::Mul(hn::Add(z2, hn::Mul(seen.y, seen.y)), hn::Add(z2, hn::Mul(seen.x, seen.x)));
      const VF density = hn::Mul(in_texel, hn::Div(seen.z, hn::Max(stretch, Set(1e-30f))));
      through = hn::Add(through, hn::IfThenElseZero(passes, density));
    }
    const VF other = Load(pdf + i);
    const VF scale = Set((1.0f - share) * texels_per_radian * texels_per_radian);
    const VF mixed = hn::Add(hn::Mul(Set(share), other),
                             hn::Mul(scale, hn::Div(through, IfThen(lit, total, Set(1.0f)))));
    StoreBelow(hn::Mul(Set(samples), IfThen(lit, mixed, other)), pdf, i, n);
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
