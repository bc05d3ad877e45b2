#include "kernels/lights/projection.h"

#include <algorithm>
#include <cmath>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/lights/projection.cc"
#include "hwy/foreach_target.h"
#include "hwy/highway.h"
#include "kernels/lights/environment-inl.h"
#include "kernels/lights/irradiance-inl.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

HWY_INLINE V3 SeeMap(const EnvironmentView& map, const V3& direction) {
  VF u, v;
  MapPosition(map, direction, u, v);
  return InterpolateTexels(map, u, v);
}

// Returns the photograph at a point, interpolated between the centres of its pixels. A point beside
// the camera or in its back is at the border, on the side where it lies.
HWY_INLINE V3 SeePhotograph(const PhotographView& photograph, const V3& point) {
  const auto row = [&](std::uint32_t i) HWY_ATTR {
    const float* const m = photograph.pixel_from_world[i];
    return Dot(Set3(m), point) + m[3];
  };
  const VF depth = hn::Max(row(2), Set(1e-6f));
  const auto place = [&](VF along, std::uint32_t count)
                         HWY_ATTR { return Clamp(along / depth - 0.5f, 0.0f, float(count - 1)); };
  const VF x = place(row(0), photograph.width), y = place(row(1), photograph.height);
  const VF left = hn::Floor(x), top = hn::Floor(y), fx = x - left, fy = y - top;
  const auto pixel = [&](VF column, VF line) HWY_ATTR {
    const VU at = (ToUnsigned(line) * SetU(photograph.width) + ToUnsigned(column)) * SetU(3);
    const float* const rgb = photograph.rgb;
    return V3{Gather(rgb, at), Gather(rgb, at + SetU(1)), Gather(rgb, at + SetU(2))};
  };
  const VF right = hn::Min(left + 1.0f, Set(float(photograph.width - 1)));
  const VF bottom = hn::Min(top + 1.0f, Set(float(photograph.height - 1)));
  const auto across = [&](VF line) HWY_ATTR {
    return pixel(left, line) * (1.0f - fx) + pixel(right, line) * fx;
  };
  return across(top) * (1.0f - fy) + across(bottom) * fy;
}

// Gathers the points where the surfaces were hit, without their lift.
HWY_INLINE V3 PointsAt(const SurfaceColumns& s, VU row) {
  const V3 org = {Gather(s.org_x, row), Gather(s.org_y, row), Gather(s.org_z, row)};
  const V3 ng = {Gather(s.ng_x, row), Gather(s.ng_y, row), Gather(s.ng_z, row)};
  return org - ng * Gather(s.lift, row);
}

void ColorByProjection(const ProjectionView& projection, const std::uint32_t* rows, std::uint32_t n,
                       const SurfaceColumns& s) {
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    const MU inside = RowsBelow(i, n);
    const VU row = hn::IfThenElseZero(inside, Load(rows + i));
    const V3 point = PointsAt(s, row);
    V3 color = projection.dome != nullptr
                   ? SeeMap(projection.dome->map, Normalize(point - Set3(projection.dome->center)))
                   : SeePhotograph(*projection.photograph, point);
    if (projection.irradiance.nodes != nullptr) {
      const V3 ns = {Gather(s.ns_x, row), Gather(s.ns_y, row), Gather(s.ns_z, row)};
      const V3 irradiance = IrradianceLanes(projection.irradiance, ns, inside).Integral();
      const auto reflectance = [&](VF radiance, VF light) HWY_ATTR {
        return kPi * radiance / hn::Max(light, Set(1e-30f));
      };
      color = {reflectance(color.x, irradiance.x), reflectance(color.y, irradiance.y),
               reflectance(color.z, irradiance.z)};
    }
    color = {Clamp(color.x, 0.0f, 1.0f), Clamp(color.y, 0.0f, 1.0f), Clamp(color.z, 0.0f, 1.0f)};
    alignas(64) float rgb[3][kPadRows];
    Store3(color, rgb[0], rgb[1], rgb[2]);
    const std::uint32_t end = std::min<std::uint32_t>(n - i, hn::Lanes(F()));
    for (std::uint32_t lane = 0; lane < end; ++lane) {
      const std::uint32_t to = rows[i + lane];
      s.color_r[to] = rgb[0][lane], s.color_g[to] = rgb[1][lane], s.color_b[to] = rgb[2][lane];
    }
  }
}

// A ray o + t d from above the ground, over the centre c by o - c, meets it at t = -h / (d . up),
// if h is the height of o. That point is c + t (d + (o - c) / t), so the direction of the map has
// no division by d . up. Where it lies beyond the sphere, the ray goes on to that.
void SeeDome(const DomeView& dome, const RayColumns& rays, std::uint32_t n, float* r, float* g,
             float* b) {
  const VF zero = hn::Zero(F());
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    const V3 d = Load3(rays.dir_x + i, rays.dir_y + i, rays.dir_z + i);
    const V3 from = Load3(rays.org_x + i, rays.org_y + i, rays.org_z + i) - Set3(dome.center);
    const VF height = Dot(from, Set3(dome.up)) + dome.height;
    const VF inverse_t = -(Dot(d, Set3(dome.up)) / height);
    const V3 to_ground = d + from * inverse_t;
    MF on_ground = hn::Gt(inverse_t, zero);
    V3 direction = d;
    if (std::isfinite(dome.radius)) {
      on_ground =
          hn::And(on_ground, hn::Le(hn::Sqrt(Dot(to_ground, to_ground)), inverse_t * dome.radius));
      const VF along = Dot(from, d);
      const VF inside = Set(dome.radius * dome.radius) - Dot(from, from);
      const VF t = SafeSqrt(along * along + inside) - along;
      direction = IfThen(hn::Gt(inside, zero), from + d * t, d);
    }
    const V3 seen = SeeMap(dome.map, Normalize(IfThen(on_ground, to_ground, direction)));
    Store3(seen, r + i, g + i, b + i);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace skywave {

HWY_EXPORT(ColorByProjection);
HWY_EXPORT(SeeDome);

void ColorByProjection(const ProjectionView& projection, const std::uint32_t* rows, std::uint32_t n,
                       const SurfaceColumns& surfaces) {
  HWY_DYNAMIC_DISPATCH(ColorByProjection)(projection, rows, n, surfaces);
}

void SeeDome(const DomeView& dome, const RayColumns& rays, std::uint32_t n, float* r, float* g,
             float* b) {
  HWY_DYNAMIC_DISPATCH(SeeDome)(dome, rays, n, r, g, b);
}

}  // namespace skywave
#endif  // HWY_ONCE
