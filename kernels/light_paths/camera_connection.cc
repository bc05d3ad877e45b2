#include "kernels/light_paths/camera_connection.h"

#include <cmath>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/light_paths/camera_connection.cc"
#include "hwy/foreach_target.h"
#include "hwy/highway.h"
#include "kernels/simd/sphere-inl.h"

#ifndef SKYWAVE_KERNELS_CAMERA_CONNECTION_CC_ONCE_
#define SKYWAVE_KERNELS_CAMERA_CONNECTION_CC_ONCE_
namespace skywave {
namespace {

// A plane film has a normal, whose length is the area of a pixel, and vectors that give the column
// and the row of a point in it.
struct PlaneFilm {
  explicit PlaneFilm(const CameraView& camera) {
    const float *r = camera.right, *d = camera.down;
    double n[3], size2 = 0;
    for (int i = 0; i < 3; ++i) {
      const int j = (i + 1) % 3, k = (i + 2) % 3;
      n[i] = double(r[j]) * d[k] - double(r[k]) * d[j];
      size2 += n[i] * n[i];
    }
    double height = 0;
    for (int i = 0; i < 3; ++i) {
      const int j = (i + 1) % 3, k = (i + 2) % 3;
      normal[i] = float(n[i]);
      column[i] = float((d[j] * n[k] - d[k] * n[j]) / size2);
      row[i] = float((n[j] * r[k] - n[k] * r[j]) / size2);
      height += n[i] * camera.corner[i];
    }
    corner_height = float(height);
  }
  float normal[3], column[3], row[3];
  float corner_height;  // height of the corner along the normal
};

}  // namespace
}  // namespace skywave
#endif

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

// This is one vector of connections.
struct Connection {
  V3 to_point;  // from the camera to the point
  VF distance;  // length of to_point
  VF x, y, importance;
  MF seen;
};

HWY_INLINE V3 LensPoint(const CameraView& camera, const UniformColumns& lens, std::uint32_t i) {
  VF x, y;
  SampleDisc(Load(lens.u + i), Load(lens.v + i), x, y);
  return Set3(camera.lens_x) * x + Set3(camera.lens_y) * y;
}

// A pixel is seen under the solid angle |N . D| / |D|^3, N being the cross product of its sides and
// D the vector to it on the film's plane. N . D is the same all over the film and the distance of
// the point is |D| times its depth s, so a pixel covers s^3 |N . D| / distance of area at the
// point. A lens moves the image on the film, but does not change the area that a pixel covers.
struct ToPerspective {
  template <bool kLens>
  static HWY_INLINE Connection Connect(const CameraView& camera, const PlaneFilm& film,
                                       const UniformColumns& lens, const V3& point,
                                       std::uint32_t i) {
    V3 to_point = point - Set3(camera.origin), shift;
    if constexpr (kLens) shift = LensPoint(camera, lens, i), to_point = to_point - shift;
    const VF distance = hn::Sqrt(Dot(to_point, to_point));
    const VF height = Set(film.corner_height);
    const VF depth = Dot(Set3(film.normal), to_point) / height;
    const MF seen = hn::Gt(depth, Set(1e-20f));
    const VF inverse = 1.0f / IfThen(seen, depth, Set(1.0f));
    V3 on = to_point * inverse;  // on the film's plane
    if constexpr (kLens) on = on + shift * (1 / camera.focal_distance);
    on = on - Set3(camera.corner);
    const VF importance = distance * (inverse * (inverse * inverse)) / hn::Abs(height);
    return {to_point,   distance, Dot(Set3(film.column), on), Dot(Set3(film.row), on),
            importance, seen};
  }
};

// Rays are parallel for each point of the lens: a pixel covers |N . d| of area across them.
struct ToOrthographic {
  template <bool kLens>
  static HWY_INLINE Connection Connect(const CameraView& camera, const PlaneFilm& film,
                                       const UniformColumns& lens, const V3& point,
                                       std::uint32_t i) {
    V3 from_corner = point - Set3(camera.corner), along = Set3(camera.forward);
    if constexpr (kLens) {
      const V3 shift = LensPoint(camera, lens, i);
      from_corner = from_corner - shift;
      along = along * camera.focal_distance - shift;
    }
    const V3 normal = Set3(film.normal);
    const VF slope = Dot(normal, along);
    const VF steps = Dot(normal, from_corner) / slope;
    const V3 to_point = along * steps, on = from_corner - to_point;
    const VF length = hn::Sqrt(Dot(along, along));
    return {to_point,
            steps * length,
            Dot(Set3(film.column), on),
            Dot(Set3(film.row), on),
            length / hn::Abs(slope),
            hn::Gt(steps, hn::Zero(F()))};
  }
};

// Cameras that see directions use the vector to the point, its length, and the unit direction in
// the camera's axes.
struct SeenDirection {
  HWY_INLINE SeenDirection(const CameraView& camera, const V3& point)
      : to_point(point - Set3(camera.origin)), distance(hn::Sqrt(Dot(to_point, to_point))) {
    seen = hn::Gt(distance, Set(1e-15f));
    const V3 dir = to_point * (1.0f / IfThen(seen, distance, Set(1.0f)));
    right = Dot(Set3(camera.right), dir);
    down = Dot(Set3(camera.down), dir);
    forward = Dot(Set3(camera.forward), dir);
  }
  // `density` is in pixels per steradian.
  HWY_INLINE Connection At(VF x, VF y, VF density) const {
    const VF distance2 = hn::Max(distance * distance, Set(1e-30f));
    return {to_point, distance, x, y, density / distance2, seen};
  }
  V3 to_point;
  VF distance, right, down, forward;
  MF seen;
};

HWY_INLINE VF Hypotenuse(VF a, VF b) { return hn::Sqrt(a * a + b * b); }

struct ToLatLong {
  template <bool>
  static HWY_INLINE Connection Connect(const CameraView& camera, const PlaneFilm&,
                                       const UniformColumns&, const V3& point, std::uint32_t) {
    const SeenDirection to(camera, point);
    const VF width = Set(float(camera.whole_width)), height = Set(float(camera.whole_height));
    const VF sine = Hypotenuse(to.right, to.forward);
    VF turn = Atan2Turn(-to.right, -to.forward);
    turn = turn - hn::Floor(turn);
    const VF polar = Atan2Turn(sine, -to.down);  // [turns], up to 1/2
    const VF density = width * height / hn::Max((2 * kPi * kPi) * sine, Set(1e-20f));
    return to.At(turn * width, (polar + polar) * height, density);
  }
};

struct ToEqualArea {
  template <bool>
  static HWY_INLINE Connection Connect(const CameraView& camera, const PlaneFilm&,
                                       const UniformColumns&, const V3& point, std::uint32_t) {
    const SeenDirection to(camera, point);
    const VF one = Set(1.0f);
    VF a, b;
    PlaceOnEqualAreaSquare({to.right, to.forward, -to.down}, a, b);
    const float width = float(camera.whole_width), rows = float(camera.whole_height);
    return to.At((a + one) * (0.5f * width), (b + one) * (0.5f * rows),
                 Set(width * rows * 0.25f * kInvPi));
  }
};

struct ToFisheye {
  template <bool>
  static HWY_INLINE Connection Connect(const CameraView& camera, const PlaneFilm&,
                                       const UniformColumns&, const V3& point, std::uint32_t) {
    const SeenDirection to(camera, point);
    const VF one = Set(1.0f), sine = Hypotenuse(to.right, to.down);
    const VF turns = Atan2Turn(sine, to.forward);
    const VF radius = turns * (1 / camera.turns_per_pixel);
    // This is radius / sine, or its limit for small angles in the middle.
    const float per_radian = 0.5f * kInvPi / camera.turns_per_pixel;
    const MF middle = hn::Lt(sine, Set(1e-6f));
    const VF across = IfThen(middle, Set(per_radian), radius / IfThen(middle, one, sine));
    Connection connection =
        to.At(to.right * across + (0.5f * float(camera.whole_width)),
              to.down * across + (0.5f * float(camera.whole_height)), across * per_radian);
    connection.seen = hn::And(connection.seen, hn::Le(turns, Set(camera.rim_turns)));
    return connection;
  }
};

template <class Kind, bool kLens>
HWY_INLINE void ConnectCameraOf(const CameraView& camera, const SurfaceColumns& points,
                                const UniformColumns& lens, std::uint32_t n,
                                const LightColumns& lights, const CameraColumns& out) {
  const PlaneFilm film(camera);
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    const V3 point = Load3(points.org_x + i, points.org_y + i, points.org_z + i);
    const Connection c = Kind::template Connect<kLens>(camera, film, lens, point, i);
    const VF one = Set(1.0f);
    const V3 back = c.to_point * (-1.0f / IfThen(c.seen, c.distance, one));
    Store3(back, lights.dir_x + i, lights.dir_y + i, lights.dir_z + i);
    Store(IfThen(c.seen, c.distance, Set(-1.0f)), lights.t_far + i);
    Store(c.x, out.x + i);
    Store(c.y, out.y + i);
    Store(hn::IfThenElseZero(c.seen, c.importance), out.importance + i);
  }
}

void ConnectCamera(const CameraView& camera, const SurfaceColumns& points,
                   const UniformColumns& lens, std::uint32_t n, const LightColumns& lights,
                   const CameraColumns& out) {
  const bool has_lens = camera.has_lens();
  switch (camera.kind) {
    case CameraKind::kPerspective:
      return has_lens ? ConnectCameraOf<ToPerspective, true>(camera, points, lens, n, lights, out)
                      : ConnectCameraOf<ToPerspective, false>(camera, points, lens, n, lights, out);
    case CameraKind::kOrthographic:
      return has_lens
                 ? ConnectCameraOf<ToOrthographic, true>(camera, points, lens, n, lights, out)
                 : ConnectCameraOf<ToOrthographic, false>(camera, points, lens, n, lights, out);
    case CameraKind::kLatLong:
      return ConnectCameraOf<ToLatLong, false>(camera, points, lens, n, lights, out);
    case CameraKind::kEqualArea:
      return ConnectCameraOf<ToEqualArea, false>(camera, points, lens, n, lights, out);
    case CameraKind::kFisheye:
      return ConnectCameraOf<ToFisheye, false>(camera, points, lens, n, lights, out);
    case CameraKind::kRealistic:
      return;  // no light path is connected with such a camera (job/choose_camera.cc)
  }
}

// Along one side of the film, `pixel` is the one that `at` goes to, a whole number that may lie
// beyond the film, and `sum` is that of the filters of all that it could go to, 0 if there are
// none.
struct ChosenPixel {
  VF pixel, sum;
};
HWY_INLINE ChosenPixel ChoosePixel(const FilterView& filter, VF at, VF u) {
  // At most this many pixels, from `first` on, have their centres within the radius of `at`.
  const auto candidates = std::uint32_t(std::floor(2 * filter.radius)) + 1;
  const VF first = hn::Ceil(at - (filter.radius + 0.5f));
  const VF cells = Set(0.5f * float(kFilterCells) / filter.radius);
  const VF zero = hn::Zero(F());
  const auto weight = [&](std::uint32_t k) HWY_ATTR {
    const VF offset = at - (first + (float(k) + 0.5f));
    const VF cell = hn::Floor((offset + filter.radius) * cells);
    const MF inside = hn::And(hn::Ge(cell, zero), hn::Lt(cell, Set(float(kFilterCells))));
    const VF density = Gather(filter.density, ToUnsigned(hn::IfThenElseZero(inside, cell)));
    return hn::IfThenElseZero(inside, density);
  };
  VF sum = zero;
  for (std::uint32_t k = 0; k < candidates; ++k) sum = sum + weight(k);
  const VF target = u * sum;
  VF below = zero, chosen = zero;
  for (std::uint32_t k = 0; k < candidates; ++k) {
    // The last pixel is chosen whose interval begins at or below the target and is not empty.
    const VF width = weight(k);
    const MF here = hn::And(hn::Ge(target, below), hn::Gt(width, zero));
    chosen = IfThen(here, Set(float(k)), chosen);
    below = below + width;
  }
  return {first + chosen, sum};
}

// Wraps pixels beyond the sides of the film to those that GenerateCameraRays sees there.
HWY_INLINE void WrapPixels(const CameraView& camera, VF& column, VF& row) {
  const VF one = Set(1.0f), zero = hn::Zero(F());
  const VF width = Set(float(camera.whole_width)), height = Set(float(camera.whole_height));
  const auto mirrored = [&](VF at, VF size) HWY_ATTR {
    const VF above = size + size - one - at;
    return IfThen(hn::Lt(at, zero), -at - one, IfThen(hn::Ge(at, size), above, at));
  };
  const auto beyond = [&](VF at, VF size)
                          HWY_ATTR { return hn::Or(hn::Lt(at, zero), hn::Ge(at, size)); };
  if (camera.kind == CameraKind::kLatLong) {
    const VF half = Set(float(camera.whole_width / 2));
    column = IfThen(beyond(row, height), column + half, column);
    row = mirrored(row, height);
    column = column - width * hn::Floor(column / width);
  } else if (camera.kind == CameraKind::kEqualArea) {
    const VF turned_row = height - one - row;
    row = IfThen(beyond(column, width), turned_row, row);
    column = mirrored(column, width);
    const VF turned_column = width - one - column;
    column = IfThen(beyond(row, height), turned_column, column);
    row = mirrored(row, height);
  }
}

void ChoosePixels(const CameraView& camera, const FilterView& filter,
                  const UniformColumns& uniforms, std::uint32_t n, const LightColumns& lights,
                  const CameraColumns& connections) {
  const VF zero = hn::Zero(F()), closed = Set(-1.0f);
  const VF width = Set(float(camera.width)), height = Set(float(camera.height));
  const bool wraps = camera.kind == CameraKind::kLatLong || camera.kind == CameraKind::kEqualArea;
  const auto reach = [&](std::uint32_t first, std::uint32_t size, VF at) HWY_ATTR {
    const VF low = Set(float(first) - filter.radius);
    const VF high = Set(float(first + size) + filter.radius);
    return hn::And(hn::Gt(at, low), hn::Lt(at, high));
  };
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    const VF t_far = Load(lights.t_far + i), x = Load(connections.x + i);
    const VF y = Load(connections.y + i);
    MF open = hn::And(hn::Ge(t_far, zero), hn::RebindMask(F(), RowsBelow(i, n)));
    if (!wraps) {
      open = hn::And(open, reach(camera.first_column, camera.width, x));
      open = hn::And(open, reach(camera.first_row, camera.height, y));
    }
    if (hn::AllFalse(F(), open)) {
      Store(closed, lights.t_far + i);
      continue;
    }
    const ChosenPixel across = ChoosePixel(filter, IfThen(open, x, zero), Load(uniforms.u + i));
    const ChosenPixel down = ChoosePixel(filter, IfThen(open, y, zero), Load(uniforms.v + i));
    VF column = across.pixel, row = down.pixel;
    if (wraps) WrapPixels(camera, column, row);
    column = column - float(camera.first_column);
    row = row - float(camera.first_row);
    const VF weight = across.sum * down.sum;
    open = hn::And(open, hn::Gt(weight, zero));
    open = hn::And(open, hn::And(hn::Ge(column, zero), hn::Lt(column, width)));
    open = hn::And(open, hn::And(hn::Ge(row, zero), hn::Lt(row, height)));
    const VU pixel = ToUnsigned(hn::IfThenElseZero(open, row)) * SetU(camera.width) +
                     ToUnsigned(hn::IfThenElseZero(open, column));
    Store(IfThen(open, t_far, closed), lights.t_far + i);
    Store(pixel, connections.pixel + i);
    Store(hn::IfThenElseZero(open, weight), connections.weight + i);
  }
}

void WeighConnections(const SurfaceColumns& s, const BsdfValueColumns& values,
                      const CameraColumns& connections, std::uint32_t n,
                      const LightColumns& lights) {
  const VF zero = hn::Zero(F());
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    const VF t_far = Load(lights.t_far + i);
    const MF open = hn::Ge(t_far, zero);
    const V3 throughput = Load3(s.throughput_r + i, s.throughput_g + i, s.throughput_b + i);
    const V3 value = Load3(values.r + i, values.g + i, values.b + i);
    const VF seen = Load(connections.importance + i) * Load(connections.weight + i);
    const V3 gain = throughput * value * seen;
    const MF counts = hn::And(open, hn::Gt(MaxComponent(gain), zero));
    Store3(IfThen(counts, gain, V3{zero, zero, zero}), lights.r + i, lights.g + i, lights.b + i);
    Store(IfThen(counts, t_far, Set(-1.0f)), lights.t_far + i);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace skywave {

HWY_EXPORT(ConnectCamera);
HWY_EXPORT(ChoosePixels);
HWY_EXPORT(WeighConnections);

void ConnectCamera(const CameraView& camera, const SurfaceColumns& points,
                   const UniformColumns& lens, std::uint32_t n, const LightColumns& lights,
                   const CameraColumns& out) {
  HWY_DYNAMIC_DISPATCH(ConnectCamera)(camera, points, lens, n, lights, out);
}
void ChoosePixels(const CameraView& camera, const FilterView& filter,
                  const UniformColumns& uniforms, std::uint32_t n, const LightColumns& lights,
                  const CameraColumns& connections) {
  HWY_DYNAMIC_DISPATCH(ChoosePixels)(camera, filter, uniforms, n, lights, connections);
}
void WeighConnections(const SurfaceColumns& surfaces, const BsdfValueColumns& values,
                      const CameraColumns& connections, std::uint32_t n,
                      const LightColumns& lights) {
  HWY_DYNAMIC_DISPATCH(WeighConnections)(surfaces, values, connections, n, lights);
}

}  // namespace skywave
#endif  // HWY_ONCE
