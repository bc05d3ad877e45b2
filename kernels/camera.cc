#include "kernels/camera.h"

#include <limits>
#include <type_traits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/camera.cc"
#include "hwy/foreach_target.h"
#include "hwy/highway.h"
#include "kernels/lens-inl.h"
#include "kernels/simd/records-inl.h"
#include "kernels/simd/sphere-inl.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

HWY_INLINE VF FilterOffset(const float* table, VF uniform) {
  const VF position = uniform * float(kFilterCells);
  const VU cell = ToUnsigned(position);
  VF low, high;
  GatherPairs(table, cell, low, high);
  return low + (position - ToFloat(cell)) * (high - low);
}

// The direction of a camera ray may have any length here.
struct OriginAndDirection {
  V3 origin, dir;
};

// Moves the origin over the lens so that the point at the focal distance stays where it is.
HWY_INLINE void RefractByLens(const CameraView& camera, const UniformColumns& lens,
                              std::uint32_t row, OriginAndDirection& ray) {
  VF x, y;
  SampleDisc(Load(lens.u + row), Load(lens.v + row), x, y);
  const V3 shift = Set3(camera.lens_x) * x + Set3(camera.lens_y) * y;
  ray.origin = ray.origin + shift;
  ray.dir = ray.dir * camera.focal_distance - shift;
}

HWY_INLINE V3 FilmPoint(const CameraView& camera, VF x, VF y) {
  return Set3(camera.corner) + (Set3(camera.right) * x + Set3(camera.down) * y);
}

struct Perspective {
  static HWY_INLINE OriginAndDirection Ray(const CameraView& camera, VF x, VF y) {
    return {Set3(camera.origin), FilmPoint(camera, x, y)};
  }
};

struct Orthographic {
  static HWY_INLINE OriginAndDirection Ray(const CameraView& camera, VF x, VF y) {
    return {FilmPoint(camera, x, y), Set3(camera.forward)};
  }
};

// Returns the sum of the camera's axes, weighted by `right`, `down` and `forward`.
HWY_INLINE V3 FromAxes(const CameraView& camera, VF right, VF down, VF forward) {
  return Set3(camera.right) * right + Set3(camera.down) * down + Set3(camera.forward) * forward;
}

HWY_INLINE VF Fraction(VF x) { return x - hn::Floor(x); }

struct LatLong {
  // The filter reaches beyond the edge of the film: past the left side follows the right one, and
  // past a pole the opposite meridian, which a negative sine of the polar angle yields.
  static HWY_INLINE OriginAndDirection Ray(const CameraView& camera, VF x, VF y) {
    VF sin_phi, cos_phi, sin_theta, cos_theta;
    SinCosTurn(Fraction(x / float(camera.whole_width)), sin_phi, cos_phi);
    SinCosTurn(Fraction(y / float(camera.whole_height) * 0.5f), sin_theta, cos_theta);
    // The middle column (half a turn) looks forward, the columns to its right look to the right.
    const VF minus_sin_theta = -sin_theta;
    return {Set3(camera.origin),
            FromAxes(camera, minus_sin_theta * sin_phi, -cos_theta, minus_sin_theta * cos_phi)};
  }
};

// Past a side of the square follows the same side in reverse.
HWY_INLINE void WrapSquare(VF& a, VF& b) {
  const VF one = Set(1.0f), two = Set(2.0f), zero = hn::Zero(F());
  const MF below = hn::Lt(a, zero), above = hn::Gt(a, one);
  a = IfThen(below, -a, IfThen(above, two - a, a));
  b = IfThen(hn::Or(below, above), one - b, b);
}

struct EqualArea {
  static HWY_INLINE OriginAndDirection Ray(const CameraView& camera, VF x, VF y) {
    const VF one = Set(1.0f);
    VF u = x / float(camera.whole_width);
    VF v = y / float(camera.whole_height);
    WrapSquare(u, v);
    WrapSquare(v, u);
    const VF a = u + u - one, b = v + v - one;
    const V3 d = DirectionOnEqualAreaSquare(a, b);
    return {Set3(camera.origin), FromAxes(camera, d.x, -d.z, d.y)};
  }
};

struct Fisheye {
  // Makes (x, y) an offset from the middle of the whole film; returns its length [pixels].
  static HWY_INLINE VF FromMiddle(const CameraView& camera, VF& x, VF& y) {
    x = x - (0.5f * float(camera.whole_width));
    y = y - (0.5f * float(camera.whole_height));
    return hn::Sqrt(x * x + y * y);
  }
  static HWY_INLINE MF Sees(const CameraView& camera, VF x, VF y) {
    const VF radius = FromMiddle(camera, x, y);
    return hn::Le(radius * camera.turns_per_pixel, Set(camera.rim_turns));
  }
  static HWY_INLINE OriginAndDirection Ray(const CameraView& camera, VF x, VF y) {
    const VF radius = FromMiddle(camera, x, y);
    VF sine, cosine;
    SinCosTurn(hn::Min(radius * camera.turns_per_pixel, Set(0.5f)), sine, cosine);
    const MF middle = hn::Eq(radius, hn::Zero(F()));
    const VF across = sine / IfThen(middle, Set(1.0f), radius);
    return {Set3(camera.origin), FromAxes(camera, x * across, y * across, cosine)};
  }
};

// The image on the film is upside down, so right and down of the picture are -x and y of the film.
struct Realistic {
  static HWY_INLINE OriginAndDirection Ray(const CameraView& camera, VF x, VF y, VF lens_u,
                                           VF lens_v, VF& throughput) {
    const VF from_left = x - 0.5f * float(camera.whole_width);
    const VF from_top = y - 0.5f * float(camera.whole_height);
    LensRay ray = ToPupil(*camera.realistic, -from_left * camera.pixel_side,
                          from_top * camera.pixel_side, lens_u, lens_v, throughput);
    PassLens(*camera.realistic, ray);
    throughput = hn::IfThenElseZero(ray.passes, throughput);
    const V3 dir = IfThen(ray.passes, ray.dir, V3{hn::Zero(F()), hn::Zero(F()), Set(1.0f)});
    const V3 at = IfThen(ray.passes, ray.origin, V3{hn::Zero(F()), hn::Zero(F()), hn::Zero(F())});
    return {Set3(camera.origin) + FromAxes(camera, at.x, -at.y, at.z),
            FromAxes(camera, dir.x, -dir.y, dir.z)};
  }
};

template <class Kind, bool kLens>
HWY_INLINE void GenerateRaysOf(const CameraView& camera, const PathColumns& paths,
                               const UniformColumns& film, const UniformColumns& lens,
                               std::uint32_t n, const RayColumns& rays) {
  const VF one = Set(1.0f), zero = hn::Zero(F());
  const VF infinity = Set(std::numeric_limits<float>::infinity());
  // The column is pixel - row * width; the row comes from a float multiplication and may be one too
  // large or too small.
  const VF inverse_width = Set(1.0f / float(camera.width));
  const VU width = SetU(camera.width);
  const VU first_column = SetU(camera.first_column), first_row = SetU(camera.first_row);
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    const VU pixel = Load(paths.pixel + i);
    VU row = ToUnsigned(ToFloat(pixel) * inverse_width);
    row = IfThen(hn::Gt(row * width, pixel), row - SetU(1), row);
    VU column = pixel - row * width;
    const MU next = hn::Gt(column, SetU(camera.width - 1));
    row = IfThen(next, row + SetU(1), row) + first_row;
    column = IfThen(next, column - width, column) + first_column;
    const VF x = ToFloat(column) + 0.5f + FilterOffset(camera.filter_offset, Load(film.u + i));
    const VF y = ToFloat(row) + 0.5f + FilterOffset(camera.filter_offset, Load(film.v + i));
    VF throughput = one, t_far = infinity;
    OriginAndDirection ray;
    if constexpr (std::is_same_v<Kind, Realistic>) {
      ray = Kind::Ray(camera, x, y, Load(lens.u + i), Load(lens.v + i), throughput);
      t_far = IfThen(hn::Gt(throughput, zero), infinity, Set(-1.0f));
    } else {
      ray = Kind::Ray(camera, x, y);
      if constexpr (kLens) RefractByLens(camera, lens, i, ray);
    }
    const V3 dir = Normalize(ray.dir);
    Store3(ray.origin, rays.org_x + i, rays.org_y + i, rays.org_z + i);
    Store3(dir, rays.dir_x + i, rays.dir_y + i, rays.dir_z + i);
    if constexpr (requires { Kind::Sees(camera, x, y); }) {
      const MF seen = Kind::Sees(camera, x, y);
      throughput = IfThen(seen, one, zero), t_far = IfThen(seen, infinity, Set(-1.0f));
    }
    Store(t_far, rays.t_far + i);
    Store3({throughput, throughput, throughput}, rays.throughput_r + i, rays.throughput_g + i,
           rays.throughput_b + i);
    Store(zero, rays.pdf + i);
    const VU path = hn::Iota(U(), i);
    Store(path, rays.path + i);
    Store(path, rays.from + i);
  }
}

void GenerateCameraRays(const CameraView& camera, const PathColumns& paths,
                        const UniformColumns& film, const UniformColumns& lens, std::uint32_t n,
                        const RayColumns& rays) {
  const bool has_lens = camera.has_lens();
  switch (camera.kind) {
    case CameraKind::kPerspective:
      return has_lens ? GenerateRaysOf<Perspective, true>(camera, paths, film, lens, n, rays)
                      : GenerateRaysOf<Perspective, false>(camera, paths, film, lens, n, rays);
    case CameraKind::kOrthographic:
      return has_lens ? GenerateRaysOf<Orthographic, true>(camera, paths, film, lens, n, rays)
                      : GenerateRaysOf<Orthographic, false>(camera, paths, film, lens, n, rays);
    case CameraKind::kLatLong:
      return GenerateRaysOf<LatLong, false>(camera, paths, film, lens, n, rays);
    case CameraKind::kEqualArea:
      return GenerateRaysOf<EqualArea, false>(camera, paths, film, lens, n, rays);
    case CameraKind::kFisheye:
      return GenerateRaysOf<Fisheye, false>(camera, paths, film, lens, n, rays);
    case CameraKind::kRealistic:
      return GenerateRaysOf<Realistic, true>(camera, paths, film, lens, n, rays);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace skywave {

HWY_EXPORT(GenerateCameraRays);

void GenerateCameraRays(const CameraView& camera, const PathColumns& paths,
                        const UniformColumns& film, const UniformColumns& lens, std::uint32_t n,
                        const RayColumns& rays) {
  HWY_DYNAMIC_DISPATCH(GenerateCameraRays)(camera, paths, film, lens, n, rays);
}

}  // namespace skywave
#endif  // HWY_ONCE
