#include "kernels/light_paths/bidirectional.h"

#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/light_paths/bidirectional.cc"
#include "hwy/foreach_target.h"
#include "hwy/highway.h"
#include "kernels/light_paths/heuristic-inl.h"
#include "kernels/simd/rows-inl.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

HWY_INLINE V3 Gather3(const float* x, const float* y, const float* z, VU row) {
  return {Gather(x, row), Gather(y, row), Gather(z, row)};
}
HWY_INLINE VF AbsDot(const V3& a, const V3& b) { return hn::Abs(Dot(a, b)); }
// Loads indices; those of rows beyond n may be anything and become 0.
HWY_INLINE VU LoadRows(const std::uint32_t* rows, std::uint32_t i, std::uint32_t n) {
  return hn::IfThenElseZero(RowsBelow(i, n), Load(rows + i));
}

// Stores lane k of the values at row[k] of the columns, for lanes below `count`.
HWY_INLINE void Scatter(const VF (&values)[2], const std::uint32_t* row, std::uint32_t count,
                        float* a, float* b) {
  alignas(kColumnAlignment) float lanes[2][kPadRows];
  Store(values[0], lanes[0]), Store(values[1], lanes[1]);
  for (std::uint32_t lane = 0; lane < count; ++lane) {
    a[row[lane]] = lanes[0][lane], b[row[lane]] = lanes[1][lane];
  }
}
HWY_INLINE std::uint32_t LanesLeft(std::uint32_t i, std::uint32_t n) {
  const auto lanes = static_cast<std::uint32_t>(hn::Lanes(F()));
  return n - i < lanes ? n - i : lanes;
}

void TurnSurfaces(const SurfaceColumns& s, const LightColumns& lights, std::uint32_t n,
                  const TurnedColumns& turned) {
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    const V3 ng = GeometricNormal(s, i), ns = ShadingNormal(s, i);
    const MF behind = hn::Lt(Dot(ng, DirectionOf(lights, i)), hn::Zero(F()));
    Store3(IfThen(behind, -ng, ng), turned.ng_x + i, turned.ng_y + i, turned.ng_z + i);
    Store3(IfThen(behind, -ns, ns), turned.ns_x + i, turned.ns_y + i, turned.ns_z + i);
    const VU other_side = hn::IfThenElseZero(hn::RebindMask(U(), behind), SetU(kBackFace));
    Store(hn::Xor(Load(s.material + i), other_side), turned.material + i);
  }
}

void ClearUnseen(const SurfaceColumns& s, std::uint32_t n, const BsdfValueColumns& values) {
  const VF zero = hn::Zero(F());
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    const V3 wo = Outgoing(s, i), ns = ShadingNormal(s, i);
    const MF seen =
        hn::And(hn::Gt(Dot(GeometricNormal(s, i), wo), zero), hn::Gt(Dot(ns, wo), zero));
    if (hn::AllTrue(F(), seen)) continue;
    for (float* const column : {values.r, values.g, values.b, values.pdf}) {
      Store(IfThen(seen, Load(column + i), zero), column + i);
    }
  }
}

// Combines the ratios of the techniques that connect at a vertex or farther back, against the one
// that reaches past it. Those farther back still lack the density `back` with which the vertex
// samples back.
HWY_INLINE VF SumTechniques(VF before, VF earlier, VF back, VF eta_vcm) {
  const VF farther = earlier * back;
  const VF combined = farther * farther + before * before;
  return hn::Sqrt(combined + eta_vcm * eta_vcm);
}

// Bounds a cosine that is divided by.
HWY_INLINE VF Divisor(VF cosine) { return hn::Max(cosine, Set(1e-9f)); }

void LeaveEye(const float* density, float light_paths, bool parallel, std::uint32_t n,
              const SubpathColumns& paths) {
  const VF sign = Set(parallel ? -1.0f : 1.0f);
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    const VF ratio = Bounded(light_paths / Load(density + i));
    Store(ratio * sign, paths.d_vcm + i);
    Store(hn::Zero(F()), paths.d_vc + i);
  }
}

void LeaveLights(const EmissionColumns& emission, std::uint32_t n, const SubpathColumns& paths) {
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    const VF inverse = 1.0f / Load(emission.pdf + i);
    const VU delta = Load(emission.delta + i);
    const MU distant = hn::Or(hn::TestBit(delta, SetU(kDeltaDirection)),
                              hn::Eq(Load(emission.light + i), SetU(kNoLight)));
    const VF before = Bounded(Load(emission.light_pdf + i) * inverse);
    Store(IfThen(hn::RebindMask(F(), distant), -before, before), paths.d_vcm + i);
    // Nothing hits a light without extent by chance.
    const MF hittable = hn::RebindMask(F(), hn::Eq(delta, SetU(0)));
    const VF earlier = Bounded(Load(emission.cosine + i) * inverse);
    Store(hn::IfThenElseZero(hittable, earlier), paths.d_vc + i);
  }
}

void ArriveAtSurfaces(const SurfaceColumns& s, std::uint32_t n, const SubpathColumns& paths,
                      const SubpathColumns& at) {
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    const VU path = LoadRows(s.path, i, n);
    const VF before = Gather(paths.d_vcm, path);
    const VF earlier = Gather(paths.d_vc, path);
    const VF cosine = Divisor(AbsDot(GeometricNormal(s, i), Outgoing(s, i)));
    const VF t = Load(s.t + i);
    const MF far = hn::Lt(before, hn::Zero(F()));
    const VF distance2 = IfThen(far, Set(1.0f), t * t);
    Store(Bounded(hn::Abs(before) * distance2 / cosine), at.d_vcm + i);
    Store(Bounded(earlier / cosine), at.d_vc + i);
  }
}

void LeaveSurfaces(const SurfaceColumns& s, const SubpathColumns& at, const float* back_pdf,
                   const MisTechniques& techniques, const RayColumns& rays, std::uint32_t n,
                   const SubpathColumns& paths) {
  const VF zero = hn::Zero(F()), one = Set(1.0f), eta_vcm = Set(techniques.eta_vcm);
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    const VU from = LoadRows(rays.from, i, n);
    const V3 dir = Load3(rays.dir_x + i, rays.dir_y + i, rays.dir_z + i);
    const VF cosine = AbsDot(Gather3(s.ng_x, s.ng_y, s.ng_z, from), dir);
    const VF before = Gather(at.d_vcm, from), earlier = Gather(at.d_vc, from);
    const VF pdf = Load(rays.pdf + i);
    const MF delta = hn::Eq(pdf, zero);
    const VF density = IfThen(delta, one, pdf);
    const VF combined = SumTechniques(before, earlier, Gather(back_pdf, from), eta_vcm);
    const VF farther = cosine / density * IfThen(delta, earlier, combined);
    const VF here = IfThen(delta, zero, one / density);
    Scatter({Bounded(here), Bounded(farther)}, rays.path + i, LanesLeft(i, n), paths.d_vcm,
            paths.d_vc);
  }
}

void MarkPartners(const SubpathColumns& paths, std::uint32_t n, const EscapeColumns& rows) {
  const VF zero = hn::Zero(F());
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    const VU path = LoadRows(rows.path, i, n);
    const VF other = hn::Max(Gather(paths.d_vcm, path), Gather(paths.d_vc, path));
    Store(IfThen(hn::Gt(other, zero), Set(1.0f), zero), rows.pdf + i);
  }
}

void WeighHitLight(const SubpathColumns& paths, const float* arrival, std::uint32_t n,
                   const MisPolicy& mis, const EscapeColumns& rows) {
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    const VU path = LoadRows(rows.path, i, n);
    const VF earlier = Gather(paths.d_vc, path) * Load(arrival + i);
    const VF combined = Join(Gather(paths.d_vcm, path), earlier);
    const MF partner = hn::Gt(Load(rows.pdf + i), hn::Zero(F()));
    const VF others = hn::IfThenElseZero(partner, combined * Load(rows.light_pdf + i));
    const V3 throughput =
        Load3(rows.throughput_r + i, rows.throughput_g + i, rows.throughput_b + i);
    Store3(throughput * HeuristicWeight(mis, others, hn::Zero(F())), rows.throughput_r + i,
           rows.throughput_g + i, rows.throughput_b + i);
    Store(hn::Zero(F()), rows.pdf + i);
  }
}

void WeighLightSamples(const SurfaceColumns& s, const SubpathColumns& at,
                       const BsdfValueColumns& forward, const BsdfValueColumns& backward,
                       const float* arrival, std::uint32_t n, const MisTechniques& techniques,
                       const LightColumns& lights) {
  const VF zero = hn::Zero(F()), one = Set(1.0f),
           infinity = Set(std::numeric_limits<float>::infinity());
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    const V3 dir = DirectionOf(lights, i);
    const VF pdf = Load(lights.pdf + i);
    // A light without extent has an irradiance in place of radiance, and nothing can hit it.
    const MF extended = hn::Lt(pdf, Set(kPunctual));
    const VF density = IfThen(hn::And(extended, hn::Gt(pdf, zero)), pdf, one);
    const VF by_bsdf = hn::IfThenElseZero(extended, Load(forward.pdf + i) / density);
    const VF from_light = Load(arrival + i) * AbsDot(GeometricNormal(s, i), dir);
    const VF combined = SumTechniques(Load(at.d_vcm + i), Load(at.d_vc + i), Load(backward.pdf + i),
                                      Set(techniques.eta_vcm));
    const VF weight = HeuristicWeight(techniques.mis, by_bsdf, from_light * combined);
    const VF factor = weight / density;
    const V3 gain = Load3(s.throughput_r + i, s.throughput_g + i, s.throughput_b + i) *
                    Load3(forward.r + i, forward.g + i, forward.b + i) *
                    Load3(lights.r + i, lights.g + i, lights.b + i) * factor;
    const MF counts = hn::And(hn::Gt(pdf, zero), hn::Gt(MaxComponent(gain), zero));
    Store3(IfThen(counts, gain, V3{zero, zero, zero}), lights.r + i, lights.g + i, lights.b + i);
    Store(IfThen(counts, infinity, Set(-1.0f)), lights.t_far + i);
  }
}

void WeighSplats(const SurfaceColumns& s, const SubpathColumns& at, const float* back_pdf,
                 const float* arrival, float light_paths, std::uint32_t n,
                 const MisTechniques& techniques, const LightColumns& to_eye) {
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    const VF cosine = AbsDot(GeometricNormal(s, i), DirectionOf(to_eye, i));
    const VF combined = SumTechniques(Load(at.d_vcm + i), Load(at.d_vc + i), Load(back_pdf + i),
                                      Set(techniques.eta_vcm));
    const VF others = Load(arrival + i) * cosine / light_paths * combined;
    const VF weight = HeuristicWeight(techniques.mis, others, hn::Zero(F()));
    const V3 gain = Load3(to_eye.r + i, to_eye.g + i, to_eye.b + i);
    Store3(gain * weight, to_eye.r + i, to_eye.g + i, to_eye.b + i);
  }
}

// Returns the point on the surface, without the lift of the origin.
HWY_INLINE V3 HitOf(const V3& org, const V3& ng, VF lift) { return org - ng * lift; }

void AimAtVertices(const SurfaceColumns& s, std::uint32_t n, const VertexView& vertices,
                   std::uint32_t* partner, const LightColumns& to_light,
                   const LightColumns& to_eye) {
  const SurfaceColumns& v = vertices.surfaces;
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    const VU found = Gather(vertices.row_of_path, LoadRows(s.path, i, n));
    MU connected = hn::And(RowsBelow(i, n), hn::Ne(found, SetU(kNoRow)));
    const VU row = hn::IfThenElseZero(connected, found);
    const V3 here = HitOf(Load3(s.org_x + i, s.org_y + i, s.org_z + i), GeometricNormal(s, i),
                          Load(s.lift + i));
    const V3 there = HitOf(Gather3(v.org_x, v.org_y, v.org_z, row),
                           Gather3(v.ng_x, v.ng_y, v.ng_z, row), Gather(v.lift, row));
    const V3 offset = there - here;
    const VF distance2 = Dot(offset, offset);
    connected = hn::And(connected, hn::RebindMask(U(), hn::Gt(distance2, Set(1e-30f))));
    const VF distance = hn::Sqrt(hn::Max(distance2, Set(1e-30f)));
    const V3 dir = offset * (1.0f / distance);
    Store3(dir, to_light.dir_x + i, to_light.dir_y + i, to_light.dir_z + i);
    Store(IfThen(hn::RebindMask(F(), connected), distance, Set(-1.0f)), to_light.t_far + i);
    Store(IfThen(connected, row, SetU(kNoRow)), partner + i);
    for (std::uint32_t lane = i; lane < i + LanesLeft(i, n); ++lane) {
      if (partner[lane] == kNoRow) continue;
      to_eye.dir_x[partner[lane]] = -to_light.dir_x[lane];
      to_eye.dir_y[partner[lane]] = -to_light.dir_y[lane];
      to_eye.dir_z[partner[lane]] = -to_light.dir_z[lane];
    }
  }
}

void JoinVertices(const SurfaceColumns& s, const SubpathColumns& at, std::uint32_t n,
                  const MisTechniques& techniques, const VertexView& vertices,
                  const std::uint32_t* partner, const ConnectionEnds& ends,
                  const LightColumns& to_light) {
  const VF zero = hn::Zero(F()), eta_vcm = Set(techniques.eta_vcm);
  const SurfaceColumns& v = vertices.surfaces;
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    const VU found = LoadRows(partner, i, n);
    const MU connected = hn::And(RowsBelow(i, n), hn::Ne(found, SetU(kNoRow)));
    const VU row = hn::IfThenElseZero(connected, found);
    const V3 dir = DirectionOf(to_light, i), ng = GeometricNormal(s, i);
    const V3 there_ng = Gather3(v.ng_x, v.ng_y, v.ng_z, row);
    const V3 there_wo = Gather3(v.wo_x, v.wo_y, v.wo_z, row);
    const VF distance = Load(to_light.t_far + i);
    const VF inverse2 = 1.0f / (distance * distance);
    const VF eye_cosine = AbsDot(ng, dir), light_cosine = AbsDot(there_ng, dir);

    // The value at the light's end has the cosine of the shading normal to where light came from in
    // place of the geometric one, which flux has (Veach 1997, 5.3.2).
    const VF geometry = light_cosine * inverse2 / Divisor(AbsDot(there_ng, there_wo));
    const V3 light_value =
        Gather3(ends.light_backward.r, ends.light_backward.g, ends.light_backward.b, row);
    const V3 eye_value =
        Load3(ends.eye_forward.r + i, ends.eye_forward.g + i, ends.eye_forward.b + i);
    const V3 eye = Load3(s.throughput_r + i, s.throughput_g + i, s.throughput_b + i) * eye_value;
    const V3 light = Gather3(v.throughput_r, v.throughput_g, v.throughput_b, row) * light_value;

    // The density of each end as sampled from the other one is set against how it was sampled.
    const VF to_there = Load(ends.eye_forward.pdf + i) * light_cosine * inverse2;
    const VF to_here = Gather(ends.light_forward.pdf, row) * eye_cosine * inverse2;
    const VF of_light = SumTechniques(Gather(vertices.at.d_vcm, row), Gather(vertices.at.d_vc, row),
                                      Gather(ends.light_backward.pdf, row), eta_vcm);
    const VF of_eye = SumTechniques(Load(at.d_vcm + i), Load(at.d_vc + i),
                                    Load(ends.eye_backward.pdf + i), eta_vcm);
    const VF weight = HeuristicWeight(techniques.mis, to_there * of_light, to_here * of_eye);
    const V3 gain = eye * light * (geometry * weight);
    const MF counts = hn::And(hn::RebindMask(F(), connected), hn::Gt(MaxComponent(gain), zero));
    Store3(IfThen(counts, gain, V3{zero, zero, zero}), to_light.r + i, to_light.g + i,
           to_light.b + i);

    const V3 offset =
        Gather3(v.org_x, v.org_y, v.org_z, row) - Load3(s.org_x + i, s.org_y + i, s.org_z + i);
    const VF reach = hn::Sqrt(hn::Max(Dot(offset, offset), Set(1e-30f)));
    Store3(offset * (1.0f / reach), to_light.dir_x + i, to_light.dir_y + i, to_light.dir_z + i);
    // A ray is shorter by its own error, so that it does not meet the surface that it ends at.
    Store(IfThen(counts, reach * (1 - 0x1p-20f), Set(-1.0f)), to_light.t_far + i);
  }
}

void MergeVertices(const SurfaceColumns& s, const SubpathColumns& at,
                   const BsdfValueColumns& forward, const float* backward,
                   const SubpathColumns& light, const std::uint32_t* vertex, std::uint32_t n,
                   const MisTechniques& techniques, const LightColumns& lights) {
  const VF zero = hn::Zero(F()), per_merge = Set(1 / techniques.eta_vcm);
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    const VU row = LoadRows(vertex, i, n);
    // Both sub-paths end here, so each could have gone on along the other one.
    const VF of_light =
        Join(Gather(light.d_vc, row) * Load(forward.pdf + i), Gather(light.d_vcm, row));
    const VF of_eye = Join(Load(at.d_vc + i) * Load(backward + i), Load(at.d_vcm + i));
    const VF weight = HeuristicWeight(techniques.mis, of_light * per_merge, of_eye * per_merge);
    const V3 throughput = Load3(s.throughput_r + i, s.throughput_g + i, s.throughput_b + i);
    const V3 value = Load3(forward.r + i, forward.g + i, forward.b + i);
    const V3 arriving = Load3(lights.r + i, lights.g + i, lights.b + i);
    const V3 gain = throughput * value * arriving * weight;
    Store3(gain, lights.r + i, lights.g + i, lights.b + i);
    const MF counts = hn::Gt(MaxComponent(gain), zero);
    Store(IfThen(counts, zero, Set(-1.0f)), lights.t_far + i);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace skywave {

HWY_EXPORT(TurnSurfaces);
HWY_EXPORT(ClearUnseen);
HWY_EXPORT(LeaveEye);
HWY_EXPORT(LeaveLights);
HWY_EXPORT(ArriveAtSurfaces);
HWY_EXPORT(LeaveSurfaces);
HWY_EXPORT(MarkPartners);
HWY_EXPORT(WeighHitLight);
HWY_EXPORT(WeighLightSamples);
HWY_EXPORT(WeighSplats);
HWY_EXPORT(AimAtVertices);
HWY_EXPORT(JoinVertices);
HWY_EXPORT(MergeVertices);

void TurnSurfaces(const SurfaceColumns& surfaces, const LightColumns& lights, std::uint32_t n,
                  const TurnedColumns& turned) {
  HWY_DYNAMIC_DISPATCH(TurnSurfaces)(surfaces, lights, n, turned);
}
void ClearUnseen(const SurfaceColumns& surfaces, std::uint32_t n, const BsdfValueColumns& values) {
  HWY_DYNAMIC_DISPATCH(ClearUnseen)(surfaces, n, values);
}
void LeaveEye(const float* density, float light_paths, bool parallel, std::uint32_t n,
              const SubpathColumns& paths) {
  HWY_DYNAMIC_DISPATCH(LeaveEye)(density, light_paths, parallel, n, paths);
}
void LeaveLights(const EmissionColumns& emission, std::uint32_t n, const SubpathColumns& paths) {
  HWY_DYNAMIC_DISPATCH(LeaveLights)(emission, n, paths);
}
void ArriveAtSurfaces(const SurfaceColumns& surfaces, std::uint32_t n, const SubpathColumns& paths,
                      const SubpathColumns& at) {
  HWY_DYNAMIC_DISPATCH(ArriveAtSurfaces)(surfaces, n, paths, at);
}
void LeaveSurfaces(const SurfaceColumns& surfaces, const SubpathColumns& at, const float* back_pdf,
                   const MisTechniques& techniques, const RayColumns& rays, std::uint32_t n,
                   const SubpathColumns& paths) {
  HWY_DYNAMIC_DISPATCH(LeaveSurfaces)(surfaces, at, back_pdf, techniques, rays, n, paths);
}
void MarkPartners(const SubpathColumns& paths, std::uint32_t n, const EscapeColumns& rows) {
  HWY_DYNAMIC_DISPATCH(MarkPartners)(paths, n, rows);
}
void WeighHitLight(const SubpathColumns& paths, const float* arrival, std::uint32_t n,
                   const MisPolicy& mis, const EscapeColumns& rows) {
  HWY_DYNAMIC_DISPATCH(WeighHitLight)(paths, arrival, n, mis, rows);
}
void WeighLightSamples(const SurfaceColumns& surfaces, const SubpathColumns& at,
                       const BsdfValueColumns& forward, const BsdfValueColumns& backward,
                       const float* arrival, std::uint32_t n, const MisTechniques& techniques,
                       const LightColumns& lights) {
  HWY_DYNAMIC_DISPATCH(WeighLightSamples)
  (surfaces, at, forward, backward, arrival, n, techniques, lights);
}
void WeighSplats(const SurfaceColumns& surfaces, const SubpathColumns& at, const float* back_pdf,
                 const float* arrival, float light_paths, std::uint32_t n,
                 const MisTechniques& techniques, const LightColumns& to_eye) {
  HWY_DYNAMIC_DISPATCH(WeighSplats)
  (surfaces, at, back_pdf, arrival, light_paths, n, techniques, to_eye);
}
void AimAtVertices(const SurfaceColumns& surfaces, std::uint32_t n, const VertexView& vertices,
                   std::uint32_t* partner, const LightColumns& to_light,
                   const LightColumns& to_eye) {
  HWY_DYNAMIC_DISPATCH(AimAtVertices)(surfaces, n, vertices, partner, to_light, to_eye);
}
void JoinVertices(const SurfaceColumns& surfaces, const SubpathColumns& at, std::uint32_t n,
                  const MisTechniques& techniques, const VertexView& vertices,
                  const std::uint32_t* partner, const ConnectionEnds& ends,
                  const LightColumns& to_light) {
  HWY_DYNAMIC_DISPATCH(JoinVertices)
  (surfaces, at, n, techniques, vertices, partner, ends, to_light);
}
void MergeVertices(const SurfaceColumns& surfaces, const SubpathColumns& at,
                   const BsdfValueColumns& forward, const float* backward,
                   const SubpathColumns& light, const std::uint32_t* vertex, std::uint32_t n,
                   const MisTechniques& techniques, const LightColumns& lights) {
  HWY_DYNAMIC_DISPATCH(MergeVertices)
  (surfaces, at, forward, backward, light, vertex, n, techniques, lights);
}

}  // namespace skywave
#endif  // HWY_ONCE
