#include "kernels/lights/bounce_guide.h"

#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/lights/bounce_guide.cc"
#include "hwy/cache_control.h"
#include "hwy/foreach_target.h"
#include "hwy/highway.h"
#include "kernels/bsdf/bsdf-inl.h"
#include "kernels/lights/search_tree-inl.h"
#include "kernels/simd/rows-inl.h"
#include "kernels/simd/sphere-inl.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

// Returns the places of one vector of rows; rows beyond n get place 0.
HWY_INLINE VU PlacesOf(const GuideColumns& rows, std::uint32_t i, std::uint32_t n) {
  const MF used = hn::RebindMask(F(), RowsBelow(i, n));
  return ToUnsigned(hn::IfThenElseZero(used, Load(rows.place + i)));
}
HWY_INLINE VF PlaceField(const BounceGuideView& guide, VU place, std::uint32_t field) {
  return Gather(guide.place->axis, hn::ShiftLeft<kLogGuidePlaceWords>(place) + SetU(field));
}
HWY_INLINE Frame PlaceFrame(const BounceGuideView& guide, VU place) {
  return MakeFrame(
      {PlaceField(guide, place, 0), PlaceField(guide, place, 1), PlaceField(guide, place, 2)});
}

void FindGuideShares(const BounceGuideView& guide, std::uint32_t n, const GuideColumns& rows) {
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    Store(PlaceField(guide, PlacesOf(rows, i, n), SKYWAVE_WORD(GuidePlace, share)), rows.share + i);
  }
}

// Returns the cells of directions in the frame of their axis; those below it get any cell.
HWY_INLINE VU CellsOf(const V3& local, MF above) {
  const VF zero = hn::Zero(F()), side = Set(float(kBounceSide)), last = Set(float(kBounceSide - 1));
  VF u, v;
  DiscUniforms(hn::IfThenElseZero(above, local.x), hn::IfThenElseZero(above, local.y), u, v);
  const auto step = [&](VF x)
                        HWY_ATTR { return ToUnsigned(hn::Min(hn::Max(x * side, zero), last)); };
  return step(v) * SetU(kBounceSide) + step(u);
}

// Returns the direction at (x, y) of the unit square.
HWY_INLINE V3 DirectionAt(VF x, VF y) {
  V3 local;
  SampleDisc(x, y, local.x, local.y);
  local.z = SafeSqrt(1.0f - (local.x * local.x + local.y * local.y));
  return local;
}

void FindGuideCells(const float* axis, std::uint32_t n, const LightColumns& directions,
                    std::uint32_t* cell) {
  const Frame frame = MakeFrame(Set3(axis));
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    const V3 local = ToLocal(frame, DirectionOf(directions, i));
    const MF above = hn::Gt(local.z, hn::Zero(F()));
    Store(IfThen(hn::RebindMask(U(), above), CellsOf(local, above), SetU(kBounceCells)), cell + i);
  }
}

void FindCellCentres(const float* axis, const LightColumns& directions) {
  const Frame frame = MakeFrame(Set3(axis));
  const VF step = Set(1.0f / float(kBounceSide)), half = Set(0.5f);
  for (std::uint32_t i = 0; i < kBounceCells; i += hn::Lanes(F())) {
    const VU cell = hn::Iota(U(), i);
    const VF x = ToFloat(hn::And(cell, SetU(kBounceSide - 1)));
    const VF y = ToFloat(hn::ShiftRight<kLogBounceSide>(cell));
    const V3 local = DirectionAt((x + half) * step, (y + half) * step);
    const V3 world = ToWorld(frame, local);
    Store3(world, directions.dir_x + i, directions.dir_y + i, directions.dir_z + i);
  }
}

void LeaveGlossToBsdf(const SurfaceColumns& s, std::uint32_t n, const GuideColumns& rows) {
  constexpr float kSharp = 0.2f, kRough = 0.6f;  // GGX widths
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    const VF width = Load(s.varying_0 + i), metal = Load(s.varying_1 + i);
    const VF rough = Clamp((width - kSharp) * (1 / (kRough - kSharp)), 0.0f, 1.0f);
    const VF diffuse = Clamp(1.0f - metal, 0.0f, 1.0f);
    StoreBelow(Load(rows.share + i) * (rough * diffuse), rows.share, i, n);
  }
}

void FindGuideDensities(const BounceGuideView& guide, std::uint32_t n,
                        const LightColumns& directions, const GuideColumns& rows) {
  const VF zero = hn::Zero(F());
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    const VU place = PlacesOf(rows, i, n);
    const V3 local = ToLocal(PlaceFrame(guide, place), DirectionOf(directions, i));
    const MF above = hn::And(hn::Gt(local.z, zero), hn::RebindMask(F(), RowsBelow(i, n)));
    const VU cell = CellsOf(local, above);
    const VF density = Gather(guide.density, place * SetU(kBounceCells) + cell);
    const VF pdf = density * (local.z * kInvPi);
    Store(hn::IfThenElseZero(above, pdf), rows.pdf + i);
  }
}

std::uint32_t ChooseGuided(const GuideColumns& rows, std::uint32_t n,
                           const UniformColumns& direction, std::uint32_t* guided) {
  std::uint32_t count = 0;
  const VF one = Set(1.0f), below_one = Set(0x1.fffffep-1f);
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    const VF u = Load(direction.u + i), share = Load(rows.share + i);
    const MF picked = hn::Lt(u, share);
    const VF rest = IfThen(picked, u, u - share) / IfThen(picked, share, one - share);
    StoreBelow(hn::Min(rest, below_one), direction.u, i, n);
    const RowCompressor append(hn::And(hn::RebindMask(U(), picked), RowsBelow(i, n)));
    append.Append(hn::Iota(U(), i), guided + count);
    count += append.count();
  }
  return count;
}

void DrawGuided(const BounceGuideView& guide, const GuideColumns& rows,
                const UniformColumns& direction, const std::uint32_t* guided, std::uint32_t count,
                const LightColumns& directions) {
  SearchColumns line, column;
  alignas(64) std::uint32_t place[kChunk + kPadRows], tree[kChunk + kPadRows];
  alignas(64) float u[kChunk + kPadRows], v[kChunk + kPadRows];
  for (std::uint32_t begin = 0; begin < count; begin += kChunk) {
    const std::uint32_t n = std::min(kChunk, count - begin);
    const std::uint32_t* const row = guided + begin;
    for (std::uint32_t i = 0; i < n; ++i) {
      place[i] = std::uint32_t(rows.place[row[i]]);
      u[i] = direction.u[row[i]], v[i] = direction.v[row[i]];
      hwy::Prefetch(guide.lines.level[0] + place[i]);
      hwy::Prefetch(guide.place + place[i]);
    }
    // Rows beyond the last one are searched with its vector.
    for (std::uint32_t i = n; i % kPadRows != 0; ++i) place[i] = 0, u[i] = v[i] = 0;
    Search(guide.lines, place, v, n, line, [&](std::uint32_t i, std::uint32_t found) {
      tree[i] = place[i] * kBounceSide + found;
      hwy::Prefetch(guide.columns.level[0] + tree[i]);
    });
    for (std::uint32_t i = n; i % kPadRows != 0; ++i) tree[i] = 0;
    Search(guide.columns, tree, u, n, column, [](std::uint32_t, std::uint32_t) {});
    for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
      const auto position = [&](const SearchColumns& found) HWY_ATTR {
        const VF inside = Clamp(Load(found.x + i), 0.0f, 0x1.fffffep-1f);
        return (ToFloat(Load(found.item + i)) + inside) * (1.0f / float(kBounceSide));
      };
      const VF x = position(column), y = position(line);
      const V3 world = ToWorld(PlaceFrame(guide, Load(place + i)), DirectionAt(x, y));
      alignas(64) float drawn[3][kPadRows];
      Store3(world, drawn[0], drawn[1], drawn[2]);
      for (std::uint32_t lane = 0; lane < std::min<std::uint32_t>(hn::Lanes(F()), n - i); ++lane) {
        const std::uint32_t to = row[i + lane];
        directions.dir_x[to] = drawn[0][lane];
        directions.dir_y[to] = drawn[1][lane];
        directions.dir_z[to] = drawn[2][lane];
      }
    }
  }
}

// Returns the density of the mixture of BSDF and guide.
HWY_INLINE VF MixtureDensity(const GuideColumns& rows, const BsdfValueColumns& values,
                             std::uint32_t i) {
  const VF share = Load(rows.share + i);
  return (1.0f - share) * Load(values.pdf + i) + share * Load(rows.pdf + i);
}

void LightGuided(const SurfaceColumns& s, const GuideColumns& rows, const BsdfValueColumns& values,
                 std::uint32_t n, const MisPolicy& mis, const LightColumns& lights) {
  const VF zero = hn::Zero(F()), one = Set(1.0f);
  const VF open = Set(std::numeric_limits<float>::infinity()), closed = Set(-1.0f);
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    const VF pdf = Load(lights.pdf + i);
    VF factor = one / pdf;
    if (mis.enabled) {
      const VF q = MixtureDensity(rows, values, i) * mis.bsdf_samples;
      factor = pdf / (pdf * pdf + q * q);
    }
    factor = IfThen(hn::Ge(pdf, Set(kPunctual)), one, factor);
    const V3 throughput = Load3(s.throughput_r + i, s.throughput_g + i, s.throughput_b + i);
    const V3 value = Load3(values.r + i, values.g + i, values.b + i);
    const V3 radiance = Load3(lights.r + i, lights.g + i, lights.b + i);
    const V3 gain = throughput * value * radiance * factor;
    const MF counts = hn::And(hn::Gt(pdf, zero), hn::Gt(MaxComponent(gain), zero));
    StoreBelow(IfThen(counts, gain.x, zero), lights.r, i, n);
    StoreBelow(IfThen(counts, gain.y, zero), lights.g, i, n);
    StoreBelow(IfThen(counts, gain.z, zero), lights.b, i, n);
    StoreBelow(IfThen(counts, open, closed), lights.t_far, i, n);
  }
}

std::uint32_t ScatterGuided(const SurfaceColumns& s, const GuideColumns& rows,
                            const BsdfValueColumns& values, const LightColumns& directions,
                            const float* roulette, std::uint32_t n, const ScatterPolicy& policy,
                            const RayColumns& rays, std::uint32_t appended) {
  const VF zero = hn::Zero(F()), one = Set(1.0f);
  // Roulette is done with here. A guided path has found light more likely than others.
  constexpr float kSurvival = 4;
  ScatterPolicy decided = policy;
  decided.roulette = false;
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    const ShadingLanes lanes(s, i);
    const VF pdf = MixtureDensity(rows, values, i);
    const V3 value = Load3(values.r + i, values.g + i, values.b + i);
    V3 weight = value * (one / hn::Max(pdf, Set(1e-30f)));
    MF alive = hn::Gt(pdf, zero);
    if (policy.roulette) {
      const V3 throughput = Load3(s.throughput_r + i, s.throughput_g + i, s.throughput_b + i);
      const VF largest = MaxComponent(throughput * weight);
      const VF survival = hn::Min(largest * kSurvival, one);
      alive = hn::And(alive, hn::Lt(Load(roulette + i), survival));
      weight = weight * (one / hn::Max(survival, Set(1e-30f)));
    }
    appended = AppendScattered(s, lanes, i, n, DirectionOf(directions, i), weight, pdf, alive, zero,
                               decided, rays, appended);
  }
  return appended;
}

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace skywave {

HWY_EXPORT(FindGuideCells);
HWY_EXPORT(FindCellCentres);
HWY_EXPORT(FindGuideShares);
HWY_EXPORT(LeaveGlossToBsdf);
HWY_EXPORT(FindGuideDensities);
HWY_EXPORT(ChooseGuided);
HWY_EXPORT(DrawGuided);
HWY_EXPORT(LightGuided);
HWY_EXPORT(ScatterGuided);

void FindGuideCells(const float* axis, std::uint32_t n, const LightColumns& directions,
                    std::uint32_t* cell) {
  HWY_DYNAMIC_DISPATCH(FindGuideCells)(axis, n, directions, cell);
}
void FindCellCentres(const float* axis, const LightColumns& directions) {
  HWY_DYNAMIC_DISPATCH(FindCellCentres)(axis, directions);
}
void FindGuideShares(const BounceGuideView& guide, std::uint32_t n, const GuideColumns& rows) {
  HWY_DYNAMIC_DISPATCH(FindGuideShares)(guide, n, rows);
}
void LeaveGlossToBsdf(const SurfaceColumns& surfaces, std::uint32_t n, const GuideColumns& rows) {
  HWY_DYNAMIC_DISPATCH(LeaveGlossToBsdf)(surfaces, n, rows);
}
void FindGuideDensities(const BounceGuideView& guide, std::uint32_t n,
                        const LightColumns& directions, const GuideColumns& rows) {
  HWY_DYNAMIC_DISPATCH(FindGuideDensities)(guide, n, directions, rows);
}
std::uint32_t ChooseGuided(const GuideColumns& rows, std::uint32_t n,
                           const UniformColumns& direction, std::uint32_t* guided) {
  return HWY_DYNAMIC_DISPATCH(ChooseGuided)(rows, n, direction, guided);
}
void DrawGuided(const BounceGuideView& guide, const GuideColumns& rows,
                const UniformColumns& direction, const std::uint32_t* guided, std::uint32_t count,
                const LightColumns& directions) {
  HWY_DYNAMIC_DISPATCH(DrawGuided)(guide, rows, direction, guided, count, directions);
}
void LightGuided(const SurfaceColumns& surfaces, const GuideColumns& rows,
                 const BsdfValueColumns& values, std::uint32_t n, const MisPolicy& mis,
                 const LightColumns& lights) {
  HWY_DYNAMIC_DISPATCH(LightGuided)(surfaces, rows, values, n, mis, lights);
}
std::uint32_t ScatterGuided(const SurfaceColumns& surfaces, const GuideColumns& rows,
                            const BsdfValueColumns& values, const LightColumns& directions,
                            const float* roulette, std::uint32_t n, const ScatterPolicy& policy,
                            const RayColumns& rays, std::uint32_t appended) {
  return HWY_DYNAMIC_DISPATCH(ScatterGuided)(surfaces, rows, values, directions, roulette, n,
                                             policy, rays, appended);
}

}  // namespace skywave
#endif  // HWY_ONCE
