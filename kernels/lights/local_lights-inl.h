// These functions read the records of local lights on vectors, pick a light and a point on it.
#if defined(SKYWAVE_KERNELS_LOCAL_LIGHTS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SKYWAVE_KERNELS_LOCAL_LIGHTS_INL_H_
#undef SKYWAVE_KERNELS_LOCAL_LIGHTS_INL_H_
#else
#define SKYWAVE_KERNELS_LOCAL_LIGHTS_INL_H_
#endif

#include <cassert>

#include "kernels/lights/light_shapes-inl.h"
#include "kernels/lights/light_tree-inl.h"
#include "kernels/lights/local_lights.h"
#include "kernels/simd/math-inl.h"
#include "kernels/surface/texture-inl.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

// Reads the fields of one light per lane.
struct LightLanes {
  HWY_INLINE LightLanes(const LocalLightView& view, VU light)
      : words(reinterpret_cast<const std::uint32_t*>(view.lights)), at(hn::ShiftLeft<4>(light)) {}
  HWY_INLINE VU Word(std::uint32_t field) const { return Gather(words, at + SetU(field)); }
  HWY_INLINE VF Number(std::uint32_t field) const { return AsFloat(Word(field)); }
  HWY_INLINE V3 Vector(std::uint32_t field) const {
    return {Number(field), Number(field + 1), Number(field + 2)};
  }
  HWY_INLINE MF Is(LocalLightKind kind) const {
    return hn::RebindMask(F(), hn::Eq(Word(0), SetU(std::uint32_t(kind))));
  }
  HWY_INLINE V3 emission() const { return Vector(1); }
  HWY_INLINE V3 position() const { return Vector(4); }
  HWY_INLINE VF area() const { return Number(7); }
  HWY_INLINE V3 axis() const { return Vector(8); }
  HWY_INLINE MF two_sided() const { return hn::RebindMask(F(), hn::Ne(Word(11), SetU(0))); }
  HWY_INLINE VU shape() const { return Word(11); }
  HWY_INLINE V3 edge() const { return Vector(12); }
  HWY_INLINE VU triangle() const { return Word(15); }

  const std::uint32_t* words;
  VU at;
};

// Returns the light whose interval holds `target`, which is below the last bound.
HWY_INLINE VU FindLight(const LightChoice& choice, std::uint32_t count, VU target) {
  VU light = SetU(0);
  for (std::uint32_t length = count; length > 1;) {
    const std::uint32_t half = length / 2;
    const VU middle = light + SetU(half);
    light = IfThen(hn::Gt(Gather(choice.first, middle), target), light, middle);
    length -= half;
  }
  return light;
}

// Returns the probability that a light is picked.
HWY_INLINE VF Probability(const LightChoice& choice, VU light) {
  const VU width = Gather(choice.first, light + SetU(1)) - Gather(choice.first, light);
  return ToFloat(width) * (1.0f / kChoiceUnits);
}

// Uniforms u of rows i and on, below n, pick these lights for `surfaces`. Where light paths begin
// there are none, and the choice has no tree.
struct LightPick {
  HWY_INLINE LightPick(const LocalLightView& view, const LightChoice& choice, const float* u,
                       std::uint32_t i, std::uint32_t n, const SurfaceColumns* surfaces) {
    assert(surfaces != nullptr || choice.tree == nullptr);
    VU target = ToUnsigned(Load(u + i) * float(kChoiceUnits));
    VU units = SetU(choice.first[view.count]);
    const MU picks = hn::And(RowsBelow(i, n), hn::Gt(units, target));
    picked = hn::RebindMask(F(), picks);
    if (none()) return;
    target = hn::IfThenElseZero(picks, target);
    // The second test is for g++ 12, which without it takes more instructions for the other branch.
    if (choice.tree != nullptr && surfaces != nullptr) {
      PickByTree(*choice.tree, *surfaces, i, picks, target, units);
    } else {
      light = FindLight(choice, view.count, target);
      probability = Probability(choice, light);
      target = target - Gather(choice.first, light);
    }
    // The uniform is taken in the middle of its 2^-24, so the rest is in (0, 1) and uniform there.
    rest = (ToFloat(target) + 0.5f) / (probability * float(kChoiceUnits));
  }
  // This is a function of its own, so that it takes no registers from the loops that pick by power.
  HWY_NOINLINE void PickByTree(const LightTreeView& tree, const SurfaceColumns& surfaces,
                               std::uint32_t i, MU picks, VU& target, VU units) {
    const Receivers to = ReceiversOf(tree, surfaces, hn::Iota(U(), i), picks);
    light = PickFromLightTree(tree, to, target, units);
    probability = ToFloat(units) * (1.0f / kChoiceUnits);
  }
  HWY_INLINE bool none() const { return hn::AllFalse(F(), picked); }

  MF picked;       // false for rows that pick no light; light 0 stands in for theirs
  VU light;        // unset if none(), like the next two
  VF probability;  // chance of that pick
  VF rest;         // the rest of u after the pick
};

// A point is uniform over a triangle (Turk 1990): both of its free coordinates are monotone maps.
struct TrianglePoint {
  VF along_axis, along_edge;
  HWY_INLINE V3 From(const V3& axis, const V3& edge) const {
    return axis * along_axis + edge * along_edge;
  }
};
HWY_INLINE TrianglePoint PointOf(VF x, VF y) {
  const VF root = hn::Sqrt(x);
  return {1.0f - root, y * root};
}

// Returns 1 inside the inner cone, 0 outside the outer one, and the light's curve between them.
HWY_INLINE VF SpotFalloff(const LightLanes& light, VF cosine) {
  return CurveOfSpot((cosine - light.Number(12)) * light.Number(13), light.Word(14));
}

// These are the shapes of the lights in `lanes`; other lanes stand for the first one. The view has
// shapes.
struct ShapedLights {
  HWY_INLINE ShapedLights(const LocalLightView& view, const LightLanes& light, MF picked)
      : lanes(hn::And(picked, light.Is(LocalLightKind::kShaped))),
        shape(view.shapes, hn::IfThenElseZero(hn::RebindMask(U(), lanes), light.shape())) {}
  MF lanes;
  ShapeLanes shape;
};

// Multiplies `emission` of the lights in `lanes` by their textures at barycentric (u, v) of their
// triangles.
HWY_INLINE V3 TexturedEmission(const LocalLightView& view, const LightLanes& light, VU index,
                               MU lanes, VF u, VF v, const V3& emission) {
  const VU named = hn::IfThenElseZero(lanes, Gather(view.emission_texture, index));
  const MU textured = hn::Ne(named, hn::Zero(U()));
  if (hn::AllFalse(U(), textured)) return emission;
  const TextureLanes record(view.textures, hn::IfThenElseZero(textured, named - SetU(1)));
  const VU triangle = hn::IfThenElseZero(textured, light.triangle());
  const MF inside = hn::RebindMask(F(), textured);
  const V3 seen =
      LookUpLevel(view.textures, record, record.Word(0), UvsOf(view.textures, record, triangle),
                  hn::IfThenElseZero(inside, u), hn::IfThenElseZero(inside, v), UnpackColor);
  return IfThen(inside, emission * seen, emission);
}

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
