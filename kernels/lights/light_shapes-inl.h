// These functions read the shapes of lights on vectors: what a light sends into a direction, and
// how light paths draw directions from it.
#if defined(SKYWAVE_KERNELS_LIGHT_SHAPES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SKYWAVE_KERNELS_LIGHT_SHAPES_INL_H_
#undef SKYWAVE_KERNELS_LIGHT_SHAPES_INL_H_
#else
#define SKYWAVE_KERNELS_LIGHT_SHAPES_INL_H_
#endif

#include "kernels/columns.h"
#include "kernels/lights/light_shapes.h"
#include "kernels/simd/sphere-inl.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

// Returns 3 t^2 - 2 t^3 of t, clamped to [0, 1].
HWY_INLINE VF SmoothStep(VF t) {
  const VF inside = Clamp(t, 0.0f, 1.0f);
  return inside * inside * (3.0f - 2.0f * inside);
}

// Finds one of `count` intervals per lane: that which holds `target`. Their bounds, which begin
// with 0, lie at `first` and on.
struct Interval {
  HWY_INLINE Interval(const std::uint32_t* bounds, VU first, VU count, VU target) {
    index = SetU(0);
    for (VU length = count; !hn::AllFalse(U(), hn::Gt(length, SetU(1)));) {
      const VU half = hn::ShiftRight<1>(length), middle = index + half;
      index = IfThen(hn::Gt(Gather(bounds, first + middle), target), index, middle);
      length = length - half;
    }
    const VU at = first + index;
    low = Gather(bounds, at);
    width = Gather(bounds, at + SetU(1)) - low;
  }
  // Returns where in the interval a uniform is that was taken in the middle of its unit.
  HWY_INLINE VF Rest(VU target) const { return (ToFloat(target - low) + 0.5f) / ToFloat(width); }
  HWY_INLINE VF probability() const { return ToFloat(width) * (1.0f / kChoiceUnits); }
  VU index, low, width;
};

// Reads the fields of one shape per lane.
struct ShapeLanes {
  HWY_INLINE ShapeLanes(const LightShapeView& shapes, VU shape)
      : view(shapes),
        words(reinterpret_cast<const std::uint32_t*>(shapes.shapes)),
        at(hn::ShiftLeft<kLogShapeWords>(shape)) {}
  HWY_INLINE VU Word(std::uint32_t field) const { return Gather(words, at + SetU(field)); }
  HWY_INLINE VF Number(std::uint32_t field) const { return AsFloat(Word(field)); }
  HWY_INLINE MF Is(LightMapping mapping) const {
    return hn::RebindMask(F(), hn::Eq(Word(0), SetU(std::uint32_t(mapping))));
  }
  HWY_INLINE VF extent(std::uint32_t i) const {
    return Number(SKYWAVE_WORD(LightShape, extent) + i);
  }
  HWY_INLINE VU width() const { return Word(SKYWAVE_WORD(LightShape, width)); }
  HWY_INLINE VU height() const { return Word(SKYWAVE_WORD(LightShape, height)); }
  HWY_INLINE VU first_choice() const { return Word(SKYWAVE_WORD(LightShape, first_choice)); }
  // Multiplies by the matrix at `field`.
  HWY_INLINE V3 Transform(std::uint32_t field, const V3& d) const {
    const auto row = [&](std::uint32_t f) HWY_ATTR {
      return Dot({Number(f), Number(f + 1), Number(f + 2)}, d);
    };
    return {row(field), row(field + 3), row(field + 6)};
  }

  const LightShapeView& view;
  const std::uint32_t* words;
  VU at;
};

// Directions of one vector are places on the squares of their shapes.
struct ShapePlace {
  VU row, column;
  MF inside;
  VF square_density;  // of directions in the world, if places are uniform in the square [1/sr]
  VF falloff;         // of cones, 1 for others
};

// Returns the share of a spot's light at t of the way from its dark edge to its full cone.
HWY_INLINE VF CurveOfSpot(VF t, VU curve) {
  const VF way = Clamp(t, 0.0f, 1.0f), square = way * way;
  const MF smooth = hn::RebindMask(F(), hn::Eq(curve, SetU(std::uint32_t(SpotCurve::kSmoothStep))));
  const MF fourth = hn::RebindMask(F(), hn::Eq(curve, SetU(std::uint32_t(SpotCurve::kFourth))));
  return IfThen(smooth, SmoothStep(t), IfThen(fourth, square * square, square));
}

// Completes a place by the direction `d` of the light's space, unit, and the solid angle there of
// one in the world.
HWY_INLINE void FinishPlace(const ShapeLanes& shape, const V3& d, VF stretch, ShapePlace& place) {
  const VF one = Set(1.0f), edge = shape.extent(0);
  const MF cone = shape.Is(LightMapping::kCone), plane = shape.Is(LightMapping::kPlane);
  const VF z = hn::Max(d.z, Set(1e-6f));
  const VF area = 4.0f * edge * shape.extent(1);
  const VF on_plane = one / (area * (z * (z * z)));
  const VF in_cone = (0.5f * kInvPi) / hn::Max(one - edge, Set(1e-7f));
  VF density = Set(0.25f * kInvPi);
  density = IfThen(cone, in_cone, IfThen(plane, on_plane, density));
  place.square_density = density * stretch;
  const VF falloff =
      CurveOfSpot((d.z - edge) * shape.extent(1), shape.Word(SKYWAVE_WORD(LightShape, curve)));
  place.falloff = IfThen(cone, falloff, one);
}

// Returns the place of a direction of the world, of any length.
HWY_INLINE ShapePlace PlaceOf(const ShapeLanes& shape, const V3& direction) {
  const VF one = Set(1.0f), half = Set(0.5f), zero = hn::Zero(F());
  const V3 to = shape.Transform(SKYWAVE_WORD(LightShape, light_from_world), Normalize(direction));
  const VF inverse = one / hn::Sqrt(Dot(to, to));
  const V3 d = to * inverse;
  const MF cone = shape.Is(LightMapping::kCone), plane = shape.Is(LightMapping::kPlane);
  VF a, b;
  PlaceOnEqualAreaSquare(d, a, b);
  const VF z = hn::Max(d.z, Set(1e-6f));
  a = IfThen(plane, d.x / (z * shape.extent(0)), a);
  b = IfThen(plane, -(d.y / (z * shape.extent(1))), b);
  // All of a cone is one texel.
  a = IfThen(cone, zero, a), b = IfThen(cone, zero, b);
  const MF beyond = hn::Gt(hn::Max(hn::Abs(a), hn::Abs(b)), one);
  const MF behind = hn::And(plane, hn::Le(d.z, Set(1e-6f)));
  const MF dark = hn::And(cone, hn::Lt(d.z, shape.extent(0)));
  ShapePlace place;
  place.inside = hn::Not(hn::Or(hn::And(plane, beyond), hn::Or(behind, dark)));
  const auto texel = [&](VF at, VU count) HWY_ATTR {
    const VF fraction = Clamp((at + one) * half, 0.0f, 1.0f);
    return hn::Min(ToUnsigned(fraction * ToFloat(count)), count - SetU(1));
  };
  place.column = texel(a, shape.width());
  place.row = texel(b, shape.height());
  FinishPlace(shape, d, inverse * (inverse * inverse), place);
  return place;
}

// Returns the factors of the light's emission at a place.
HWY_INLINE V3 ShapeValue(const ShapeLanes& shape, const ShapePlace& place) {
  const VU texel = place.row * shape.width() + place.column;
  const VU at = shape.Word(SKYWAVE_WORD(LightShape, first_texel)) + (texel + (texel + texel));
  const auto channel = [&](std::uint32_t c)
                           HWY_ATTR { return Gather(shape.view.texels, at + SetU(c)); };
  const VF share = hn::IfThenElseZero(place.inside, place.falloff);
  return V3{channel(0), channel(1), channel(2)} * share;
}

// Returns where the bounds of the columns of a row begin.
HWY_INLINE VU FirstColumnChoice(const ShapeLanes& shape, VU row) {
  const VU one = SetU(1);
  return shape.first_choice() + (shape.height() + one) + row * (shape.width() + one);
}

// Returns the density with which light paths draw the direction of a place, in the world [1/sr].
HWY_INLINE VF ShapeDensity(const ShapeLanes& shape, const ShapePlace& place) {
  const std::uint32_t* bounds = shape.view.choices;
  const auto share = [&](VU first, VU index) HWY_ATTR {
    const VU at = first + index;
    const VU width = Gather(bounds, at + SetU(1)) - Gather(bounds, at);
    return ToFloat(width) * (1.0f / kChoiceUnits);
  };
  const VF texel = share(shape.first_choice(), place.row) *
                   share(FirstColumnChoice(shape, place.row), place.column);
  const VF texels = ToFloat(shape.width()) * ToFloat(shape.height());
  const VF density = texel * texels * place.square_density;
  return hn::IfThenElseZero(place.inside, density);
}

// A direction that a light path drew, its density and what the light sends there.
struct DrawnDirection {
  V3 dir;  // world, unit
  VF pdf;  // [1/sr]
  V3 value;
};

HWY_INLINE DrawnDirection DrawDirection(const ShapeLanes& shape, VF u, VF v) {
  const VF one = Set(1.0f);
  const auto unit = [](VF x) HWY_ATTR { return ToUnsigned(x * float(kChoiceUnits)); };
  const VU along = unit(u), down = unit(v);
  const VU width = shape.width(), height = shape.height();
  ShapePlace place;
  const Interval row(shape.view.choices, shape.first_choice(), height, down);
  place.row = row.index;
  const Interval column(shape.view.choices, FirstColumnChoice(shape, place.row), width, along);
  place.column = column.index;
  place.inside = hn::RebindMask(F(), hn::Gt(width, SetU(0)));
  const VF s = (ToFloat(place.column) + column.Rest(along)) / ToFloat(width);
  const VF t = (ToFloat(place.row) + row.Rest(down)) / ToFloat(height);

  const MF cone = shape.Is(LightMapping::kCone), plane = shape.Is(LightMapping::kPlane);
  const VF a = s + s - one, b = t + t - one;
  V3 d = DirectionOnEqualAreaSquare(a, b);
  d = IfThen(plane, Normalize({a * shape.extent(0), -(b * shape.extent(1)), one}), d);
  d = IfThen(cone, InCone(s, t, one - shape.extent(0)), d);
  // The way to the world has the inverse stretch.
  const V3 to = shape.Transform(SKYWAVE_WORD(LightShape, world_from_light), d);
  const VF length = hn::Sqrt(Dot(to, to));
  FinishPlace(shape, d, length * (length * length), place);
  const VF texel = row.probability() * column.probability();
  const VF texels = ToFloat(width) * ToFloat(height);
  return {to * (one / length), texel * texels * place.square_density, ShapeValue(shape, place)};
}

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
