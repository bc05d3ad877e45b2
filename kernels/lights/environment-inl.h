// These functions find the texels of directions on vectors, read them and draw directions inside
// them.
#if defined(SKYWAVE_KERNELS_ENVIRONMENT_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SKYWAVE_KERNELS_ENVIRONMENT_INL_H_
#undef SKYWAVE_KERNELS_ENVIRONMENT_INL_H_
#else
#define SKYWAVE_KERNELS_ENVIRONMENT_INL_H_
#endif

#include "kernels/lights/environment.h"
#include "kernels/packed_radiance-inl.h"
#include "kernels/simd/math-inl.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

// Words reads lines as words; WordOf is the index of a texel of the map among them.
HWY_INLINE const std::uint32_t* Words(const TexelLine* lines) {
  return reinterpret_cast<const std::uint32_t*>(lines);
}
HWY_INLINE VU WordOf(const EnvironmentView& map, VU column, VU row) {
  // This is column / kLineTexels, exact for columns below 43690.
  static_assert(kLineTexels == 14 && 18725 * kLineTexels - (1 << 18) == 6);
  const VU line = hn::ShiftRight<18>(column * SetU(18725));
  const VU skipped = line * SetU(kLineWords - kLineTexels);
  return row * SetU(map.lines * kLineWords) + (column + skipped + SetU(kLineWords - kLineTexels));
}
HWY_INLINE V3 FetchTexels(const EnvironmentView& map, VU column, VU row) {
  return UnpackRadiance(Gather(Words(map.texels), WordOf(map, column, row)), map.radiance_unit);
}

HWY_INLINE V3 WorldFromMap(const EnvironmentView& map, const V3& m) {
  const float* r = map.map_from_world;  // orthonormal: its transpose is its inverse
  return Set3(r) * m.x + Set3(r + 3) * m.y + Set3(r + 6) * m.z;
}
HWY_INLINE V3 MapFromWorld(const EnvironmentView& map, const V3& w) {
  const float* r = map.map_from_world;
  return {Dot(Set3(r), w), Dot(Set3(r + 3), w), Dot(Set3(r + 6), w)};
}

// Finds the position of a direction on the map: u, v in [0, 1].
HWY_INLINE void MapPosition(const EnvironmentView& map, const V3& dir, VF& u, VF& v) {
  const V3 m = MapFromWorld(map, dir);
  u = 0.5f + Atan2Turn(m.x, m.y);
  const VF sine = hn::Sqrt(m.x * m.x + m.y * m.y);
  v = 2.0f * Atan2Turn(sine, m.z);
}

// Interpolates the map between texel centres, in full precision.
HWY_INLINE V3 InterpolateTexels(const EnvironmentView& map, VF u, VF v) {
  const VF x = u * float(map.width) - 0.5f;
  const VF y = v * float(map.height) - 0.5f;
  const VF x_floor = hn::Floor(x), y_floor = hn::Floor(y);
  const VF fx = x - x_floor, fy = y - y_floor;
  const float last_x = float(map.width - 1), last_y = float(map.height - 1);
  // Columns wrap at the seam; the rows at the poles repeat.
  const VF x_next = x_floor + 1.0f;
  const VU left = ToUnsigned(IfThen(hn::Lt(x_floor, hn::Zero(F())), Set(last_x), x_floor));
  const VU right = ToUnsigned(IfThen(hn::Gt(x_next, Set(last_x)), hn::Zero(F()), x_next));
  const VU top = ToUnsigned(Clamp(y_floor, 0.0f, last_y));
  const VU bottom = ToUnsigned(Clamp(y_floor + 1.0f, 0.0f, last_y));
  const VU width = SetU(map.width);
  const auto texel = [&](VU column, VU row) HWY_ATTR {
    const VU at = (row * width + column) * SetU(3);
    return V3{Gather(map.rgb, at), Gather(map.rgb, at + SetU(1)), Gather(map.rgb, at + SetU(2))};
  };
  const VF one = Set(1.0f);
  const auto across = [&](VU row) HWY_ATTR {
    return texel(left, row) * (one - fx) + texel(right, row) * fx;
  };
  return across(top) * (one - fy) + across(bottom) * fy;
}

// Returns the cell of a position in [0, 1] on a line of `count` cells.
HWY_INLINE VU CellOf(VF position, std::uint32_t count) {
  const VF scaled = hn::Max(position * float(count), hn::Zero(F()));
  return hn::Min(ToUnsigned(hn::Min(scaled, Set(float(count)))), SetU(count - 1));
}

// RowAreas holds a vector of each field of RowArea.
struct RowAreas {
  VF start, step;
};
HWY_INLINE RowAreas FetchAreas(const EnvironmentView& map, VU row) {
  const auto* areas = reinterpret_cast<const float*>(map.row_area);
  const VU at = hn::ShiftLeft<1>(row);
  return {Gather(areas, at), Gather(areas, at + SetU(1))};
}

// Writes rows `to` and on of `out`: directions inside texels at (fx, fy) in [0, 1)^2, uniform in
// solid angle, the texels' radiance and the given density. column and row must be inside the map.
HWY_INLINE void EmitTexels(const EnvironmentView& map, VU column, VU row, const RowAreas& area,
                           VF fx, VF fy, const V3& radiance, VF density, const LightColumns& out,
                           std::uint32_t to) {
  const VF w = area.start + area.step * fy;
  const VF sine = 2.0f * SafeSqrt(w * (1.0f - w));
  const VF up_north = 1.0f - 2.0f * w;
  const MU north = hn::Lt(row, SetU((map.height + 1) / 2));
  const VF up = IfThen(hn::RebindMask(F(), north), up_north, -up_north);
  // u = 1/2 looks forward: the turn from forward to right is u - 1/2.
  const VF u = (ToFloat(column) + fx) / float(map.width);
  VF sin_turn, cos_turn;
  SinCosTurn(u, sin_turn, cos_turn);
  const V3 direction = {-(sine * sin_turn), -(sine * cos_turn), up};
  Store3(WorldFromMap(map, direction), out.dir_x + to, out.dir_y + to, out.dir_z + to);
  Store3(radiance, out.r + to, out.g + to, out.b + to);
  Store(density, out.pdf + to);
}
HWY_INLINE void EmitTexels(const EnvironmentView& map, VU column, VU row, VF fx, VF fy, VF density,
                           const LightColumns& out, std::uint32_t to) {
  EmitTexels(map, column, row, FetchAreas(map, row), fx, fy, FetchTexels(map, column, row), density,
             out, to);
}

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
