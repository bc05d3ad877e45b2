// These functions pick lights from a tree, and give the probability of such a pick.
#if defined(SKYWAVE_KERNELS_LIGHT_TREE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SKYWAVE_KERNELS_LIGHT_TREE_INL_H_
#undef SKYWAVE_KERNELS_LIGHT_TREE_INL_H_
#else
#define SKYWAVE_KERNELS_LIGHT_TREE_INL_H_
#endif

#include "kernels/columns.h"
#include "kernels/lights/light_tree.h"
#include "kernels/simd/math-inl.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

// Surfaces that a light is picked for.
struct Receivers {
  V3 point, normal;
  MF lit_behind;
};

// Returns those of the rows where `valid` holds. A light sample may have moved their origins to the
// other side, so that the points are the hits themselves.
HWY_INLINE Receivers ReceiversOf(const LightTreeView& tree, const SurfaceColumns& s, VU row,
                                 MU valid) {
  row = hn::IfThenElseZero(valid, row);
  const auto at = [&](const float* x, const float* y, const float* z) HWY_ATTR {
    return V3{Gather(x, row), Gather(y, row), Gather(z, row)};
  };
  const VU material =
      hn::IfThenElseZero(valid, hn::And(Gather(s.material, row), SetU(std::uint32_t(~kBackFace))));
  return {.point = at(s.org_x, s.org_y, s.org_z) - at(s.ng_x, s.ng_y, s.ng_z) * Gather(s.lift, row),
          .normal = at(s.ns_x, s.ns_y, s.ns_z),
          .lit_behind = hn::RebindMask(F(), hn::Ne(Gather(tree.lit_behind, material), SetU(0)))};
}

// An angle in [0, pi] by its cosine and sine.
struct Angle {
  VF cosine, sine;
};
HWY_INLINE Angle AngleOf(VF cosine) { return {cosine, SafeSqrt(1.0f - cosine * cosine)}; }
// Returns the difference of two angles, 0 where it is negative.
HWY_INLINE Angle operator-(const Angle& a, const Angle& b) {
  const MF less = hn::Ge(a.cosine, b.cosine);
  return {IfThen(less, Set(1.0f), a.cosine * b.cosine + a.sine * b.sine),
          IfThen(less, hn::Zero(F()), a.sine * b.cosine - a.cosine * b.sine)};
}

struct LightNodeLanes {
  HWY_INLINE LightNodeLanes(const LightTreeView& tree, VU node)
      : words(reinterpret_cast<const std::uint32_t*>(tree.nodes)),
        at(hn::ShiftLeft<4>(node)),
        count_and_flags(Word(SKYWAVE_WORD(LightNode, count))) {}
  HWY_INLINE VU Word(std::uint32_t word) const { return Gather(words, at + SetU(word)); }
  HWY_INLINE VF Number(std::uint32_t word) const { return AsFloat(Word(word)); }
  HWY_INLINE V3 Vector(std::uint32_t word) const {
    return {Number(word), Number(word + 1), Number(word + 2)};
  }
  HWY_INLINE V3 center() const { return Vector(SKYWAVE_WORD(LightNode, center)); }
  HWY_INLINE VF radius() const { return Number(SKYWAVE_WORD(LightNode, radius)); }
  HWY_INLINE V3 axis() const { return Vector(SKYWAVE_WORD(LightNode, axis)); }
  HWY_INLINE Angle cone() const { return AngleOf(Number(SKYWAVE_WORD(LightNode, cos_cone))); }
  HWY_INLINE VF cos_spread() const { return Number(SKYWAVE_WORD(LightNode, cos_spread)); }
  HWY_INLINE VF intensity() const { return Number(SKYWAVE_WORD(LightNode, intensity)); }
  HWY_INLINE MF Is(std::uint32_t flag) const {
    return hn::RebindMask(F(), hn::Ne(hn::And(count_and_flags, SetU(flag)), SetU(0)));
  }
  HWY_INLINE VU count() const { return hn::And(count_and_flags, SetU(kLightNodeCount)); }
  HWY_INLINE VU first() const { return Word(SKYWAVE_WORD(LightNode, first)); }

  const std::uint32_t* words;
  VU at, count_and_flags;
};

// Returns about the irradiance of surfaces by the lights of a node: at least 0, and 0 only where
// none of them can shine on the surface (Conty Estevez and Kulla 2018, equation 3). The cosines are
// those of the best place in the sphere around the lights, and the distance is that of its middle,
// or its radius for points in it.
HWY_INLINE VF ImportanceOf(const LightNodeLanes& node, const Receivers& to) {
  const VF zero = hn::Zero(F()), one = Set(1.0f);
  const V3 way = node.center() - to.point;
  const VF distance2 = hn::Max(Dot(way, way), Set(1e-30f)), radius = node.radius();
  const VF radius2 = radius * radius;
  const MF distant = node.Is(kDistantNode);
  const Angle cone = node.cone();
  const V3 axis = node.axis();
  const V3 dir = IfThen(distant, axis, way * (one / hn::Sqrt(distance2)));

  // The angle that the lights fill, as the surface sees it: all, if it lies among them.
  const Angle outside = AngleOf(SafeSqrt(one - radius2 / distance2));
  const MF among = hn::Ge(radius2, distance2);
  const Angle seen = {IfThen(distant, cone.cosine, IfThen(among, -one, outside.cosine)),
                      IfThen(distant, cone.sine, IfThen(among, zero, outside.sine))};

  const VF from_axis = -Dot(axis, dir);
  const Angle leaving = AngleOf(IfThen(node.Is(kTwoSidedNode), hn::Abs(from_axis), from_axis));
  const VF leaves = (leaving - cone - seen).cosine;
  const VF emitted =
      IfThen(distant, one,
             hn::IfThenElseZero(hn::Gt(leaves, node.cos_spread()), hn::Max(leaves, Set(0x1p-6f))));
  const VF from_normal = Dot(to.normal, dir);
  const Angle arriving = AngleOf(IfThen(to.lit_behind, hn::Abs(from_normal), from_normal));
  const VF received = hn::Max((arriving - seen).cosine, zero);
  const VF squared = IfThen(distant, one, hn::Max(distance2, radius2));
  return node.intensity() * emitted * received / squared;
}

// Goes down to a leaf in every lane and returns its light. `width` is how many of kChoiceUnits pick
// a light of the tree, and then how many pick that light. `turn(split, inner, depth)` says in which
// of the lanes `inner` the way goes to the second child, where the first one has `split` units.
// Every light has at least one, so that none is lost whatever its importance is.
template <class Turn>
HWY_INLINE VU DescendLightTree(const LightTreeView& tree, const Receivers& to, VU& width,
                               const Turn& turn) {
  VU at = SetU(0);
  for (std::uint32_t depth = 0;; ++depth) {
    const LightNodeLanes node(tree, at);
    const VU count = node.count();
    const MU inner = hn::Gt(count, SetU(1));
    if (hn::AllFalse(U(), inner)) return node.first();
    const VU child = hn::IfThenElseZero(inner, node.first());
    const LightNodeLanes one(tree, child), other(tree, child + SetU(1));
    const VF first = ImportanceOf(one, to), second = ImportanceOf(other, to);
    const VF sum = first + second;
    const VF share =
        IfThen(hn::Gt(sum, hn::Zero(F())), first / sum, ToFloat(one.count()) / ToFloat(count));
    const VU wanted = ToUnsigned(share * ToFloat(width) + 0.5f);
    const VU split = hn::Min(hn::Max(wanted, one.count()), width - other.count());
    const MU second_child = hn::And(inner, turn(split, inner, depth));
    width = IfThen(inner, IfThen(second_child, width - split, split), width);
    at = IfThen(inner, child + hn::IfThenElseZero(second_child, SetU(1)), at);
  }
}

// Returns the light that unit `target` of `width` picks, which are then the unit among those of the
// light and their number.
HWY_INLINE VU PickFromLightTree(const LightTreeView& tree, const Receivers& to, VU& target,
                                VU& width) {
  return DescendLightTree(tree, to, width, [&](VU split, MU inner, std::uint32_t) HWY_ATTR {
    const MU second = hn::AndNot(hn::Gt(split, target), inner);
    target = IfThen(second, target - split, target);
    return second;
  });
}

// Returns how many of `width` units pick `light`.
HWY_INLINE VU UnitsInLightTree(const LightTreeView& tree, const Receivers& to, VU light, VU width) {
  const VU way = Gather(tree.way, light);
  DescendLightTree(tree, to, width, [&](VU, MU, std::uint32_t depth) HWY_ATTR {
    return hn::Ne(hn::And(hn::ShiftRightSame(way, int(depth)), SetU(1)), SetU(0));
  });
  return width;
}

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
