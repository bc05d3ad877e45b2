// This file holds the loops over rows that all BSDFs share, and the macros that make them the
// kernels of one BSDF (bsdf-inl.h).
#if defined(SKYWAVE_KERNELS_BSDF_KERNELS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SKYWAVE_KERNELS_BSDF_KERNELS_INL_H_
#undef SKYWAVE_KERNELS_BSDF_KERNELS_INL_H_
#else
#define SKYWAVE_KERNELS_BSDF_KERNELS_INL_H_
#endif

#include <limits>

#include "kernels/bsdf/bsdf-inl.h"
#include "kernels/lights/irradiance-inl.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

template <class Bsdf>
void EvaluateRows(const SurfaceColumns& s, const MaterialView& materials,
                  const LightColumns& lights, std::uint32_t n, const BsdfValueColumns& out) {
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    const ShadingLanes lanes(s, i);
    const Bsdf bsdf(s, materials, i, n);
    const V3 world = DirectionOf(lights, i);
    const V3 wi = ToLocal(lanes.frame, world);
    const BsdfValue result = bsdf.Evaluate(lanes.wo, wi);
    const MF connects = Connects<Bsdf>(lanes, world, wi);
    const VF zero = hn::Zero(F());
    Store3(IfThen(connects, result.value, V3{zero, zero, zero}), out.r + i, out.g + i, out.b + i);
    Store(IfThen(connects, result.pdf, zero), out.pdf + i);
  }
}

template <class Bsdf>
inline constexpr bool kOnlyDiffuse = requires {
  Bsdf::kOnlyDiffuse;
};
template <class Bsdf>
inline constexpr bool kDiffuseThrough = requires(const Bsdf& bsdf, const V3& wo) {
  bsdf.DiffuseThrough(wo);
};

// The part of the light of one vector of surfaces that is known analytically.
template <class Bsdf>
class DiffuseControl {
 public:
  HWY_INLINE DiffuseControl(const LightControl& control, const Bsdf& bsdf,
                            const ShadingLanes& lanes, std::uint32_t i, MU rows)
      : weight_(control.weight == nullptr ? Set(1.0f) : Load(control.weight + i)),
        diffuse_(bsdf.Diffuse(lanes.wo) * weight_),
        front_(control.irradiance, lanes.frame.n, rows),
        through_(diffuse_),
        back_(front_) {
    if constexpr (kDiffuseThrough<Bsdf>) {
      const VF zero = hn::Zero(F());
      through_ = bsdf.DiffuseThrough(lanes.wo) * weight_;
      back_ = IrradianceLanes(control.irradiance, V3{zero, zero, zero} - lanes.frame.n, rows);
    }
  }

  // Returns the value of the control in a direction, whose whole value is `value`.
  HWY_INLINE V3 Value(const V3& world, const V3& wi, const V3& value) const {
    MF counts = front_.Counts(world);
    V3 known = diffuse_ * wi.z;
    if constexpr (kDiffuseThrough<Bsdf>) {
      const MF through = back_.Counts(world);
      known = IfThen(through, through_ * (-wi.z), known);
      counts = hn::Or(counts, through);
    }
    if constexpr (kOnlyDiffuse<Bsdf>) known = value * weight_;
    return {hn::IfThenElseZero(counts, known.x), hn::IfThenElseZero(counts, known.y),
            hn::IfThenElseZero(counts, known.z)};
  }

  // Returns the integral of radiance times the control.
  HWY_INLINE V3 Integral() const {
    V3 integral = diffuse_ * front_.Integral();
    if constexpr (kDiffuseThrough<Bsdf>) {
      integral = integral + through_ * back_.Integral();
    }
    return integral;
  }

 private:
  VF weight_;
  V3 diffuse_;
  IrradianceLanes front_;
  V3 through_;  // this and the next one only for light from the other side
  IrradianceLanes back_;
};

template <class Bsdf>
inline constexpr bool kMayMirror = requires(const Bsdf& bsdf, const V3& wo, MF lanes) {
  bsdf.EvaluateWithoutMirrors(wo, wo, lanes);
};
// Returns the value of light samples. Lights without extent are not seen in what mirrors; others
// are, by lobes that BSDF samples find as well.
template <class Bsdf>
HWY_INLINE BsdfValue EvaluateLight(const Bsdf& bsdf, const V3& wo, const V3& wi, VF pdf) {
  if constexpr (kMayMirror<Bsdf>) {
    return bsdf.EvaluateWithoutMirrors(wo, wi, hn::Eq(pdf, Set(kPunctual)));
  } else {
    return bsdf.Evaluate(wo, wi);
  }
}

template <class Bsdf, bool kControlled = false>
void EvaluateLightRows(const SurfaceColumns& s, const MaterialView& materials, std::uint32_t n,
                       const MisPolicy& mis, const LightColumns& lights,
                       const LightControl* control = nullptr) {
  const VF zero = hn::Zero(F());
  const VF one = Set(1.0f);
  const VF open = Set(std::numeric_limits<float>::infinity()), closed = Set(-1.0f);
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    const ShadingLanes lanes(s, i);
    const Bsdf bsdf(s, materials, i, n);
    const V3 world = DirectionOf(lights, i);
    const V3 wi = ToLocal(lanes.frame, world);
    const VF pdf = Load(lights.pdf + i);
    const BsdfValue result = EvaluateLight(bsdf, lanes.wo, wi, pdf);
    VF factor = one / pdf;
    if (mis.enabled) {
      // p / (p^2 + q^2) is the weight p^2 / (p^2 + q^2) over p.
      const VF q = result.pdf * mis.bsdf_samples;
      const VF p2 = pdf * pdf, q2 = q * q;
      factor = pdf / (p2 + q2);
    }
    factor = IfThen(hn::Ge(pdf, Set(kPunctual)), one, factor);
    const V3 throughput = Load3(s.throughput_r + i, s.throughput_g + i, s.throughput_b + i);
    const V3 radiance = Load3(lights.r + i, lights.g + i, lights.b + i);
    const V3 gain = throughput * result.value * radiance * factor;
    const MF counts = hn::And(hn::And(Connects<Bsdf>(lanes, world, wi), hn::Gt(pdf, zero)),
                              hn::Gt(MaxComponent(gain), zero));
    StoreBelow(IfThen(counts, gain.x, zero), lights.r, i, n);
    StoreBelow(IfThen(counts, gain.y, zero), lights.g, i, n);
    StoreBelow(IfThen(counts, gain.z, zero), lights.b, i, n);
    StoreBelow(IfThen(counts, open, closed), lights.t_far, i, n);
    if constexpr (kControlled) {
      const DiffuseControl<Bsdf> diffuse(*control, bsdf, lanes, i, RowsBelow(i, n));
      MF sampled = hn::And(hn::Gt(pdf, zero), hn::Lt(pdf, Set(kPunctual)));
      if (control->reach != nullptr) {
        sampled = hn::And(sampled, hn::Eq(Load(control->reach + i), open));
      }
      const V3 known = throughput * diffuse.Value(world, wi, result.value) * radiance;
      V3 subtracted = IfThen(sampled, known * factor, V3{zero, zero, zero});
      if (control->with_integral) {
        subtracted = subtracted - throughput * diffuse.Integral();
      }
      Store3(subtracted, control->out.r + i, control->out.g + i, control->out.b + i);
    }
    if constexpr (kTransmits<Bsdf>) MoveOrigins(s, lanes, world, i, n);
  }
}

HWY_INLINE void ClearControls(const ControlColumns& control, std::uint32_t begin,
                              std::uint32_t end) {
  const VF zero = hn::Zero(F());
  for (std::uint32_t i = begin; i < end; i += hn::Lanes(F())) {
    Store3(V3{zero, zero, zero}, control.r + i, control.g + i, control.b + i);
  }
}

// Only a diffuse part can be known on average: other BSDFs have no such kernel.
template <class Bsdf>
void EvaluateControlledRows(const SurfaceColumns& s, const MaterialView& materials, std::uint32_t n,
                            const MisPolicy& mis, const LightControl& control,
                            const LightColumns& lights) {
  if constexpr (kDiffuse<Bsdf>) {
    EvaluateLightRows<Bsdf, true>(s, materials, n, mis, lights, &control);
  }
}

// A vector of surfaces, and the weights that cells of the map have for it (BsdfKernels).
template <class Bsdf>
struct CellWeights {
  HWY_INLINE CellWeights(const SurfaceColumns& s, const MaterialView& materials, std::uint32_t i,
                         std::uint32_t n)
      : lanes(s, i), bsdf(s, materials, i, n) {
    // The least weight is a tenth of the mean over the hemisphere of a diffuse surface of this
    // colour, or of one of 4 %.
    least = (0.05f * kInvPi) * hn::Max(Luminance(ColorOf(s, i)), Set(0.04f));
  }

  HWY_INLINE VF Weight(const V3& dir, VF energy, VF radius, VF reach) const {
    const VF zero = hn::Zero(F()), one = Set(1.0f);
    const V3 wi = ToLocal(lanes.frame, dir);
    const VF height = hn::Min(Dot(lanes.ng, dir), wi.z);
    VF value;
    if constexpr (kBlurs<Bsdf>) {
      value = bsdf.Blurred(lanes.wo, wi, radius);
    } else {
      value = Luminance(bsdf.Evaluate(lanes.wo, wi).value);
    }
    if constexpr (kTransmits<Bsdf>) {
      value = IfThen(Connects<Bsdf>(lanes, dir, wi), value, zero);
      return hn::Max(value, least) * energy;
    }
    value = hn::Max(IfThen(hn::Gt(height, zero), value, zero), least);
    // A cell that is mostly below the horizon has little light above it, and that is grazing.
    const VF above = Clamp(one + height / reach, 0.0f, 1.0f);
    return value * energy * (above * above);
  }

  ShadingLanes lanes;
  Bsdf bsdf;
  VF least;
};

template <class Bsdf>
void WeighCellsRows(const SurfaceColumns& s, const MaterialView& materials, std::uint32_t n,
                    const LightCell* cells, std::uint32_t count, float* sums,
                    std::uint32_t stride) {
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    const CellWeights<Bsdf> weights(s, materials, i, n);
    VF sum = hn::Zero(F());
    for (std::uint32_t k = 0; k < count; ++k) {
      const LightCell& cell = cells[k];
      sum =
          sum + weights.Weight(Set3(cell.dir), Set(cell.energy), Set(cell.radius), Set(cell.reach));
      Store(sum, sums + std::size_t(k) * stride + i);
    }
  }
}

template <class Bsdf>
void WeighCellRows(const SurfaceColumns& s, const MaterialView& materials, std::uint32_t n,
                   const LightCell* cells, const std::uint32_t* cell, float* weight) {
  const auto* fields = reinterpret_cast<const float*>(cells);
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    const CellWeights<Bsdf> weights(s, materials, i, n);
    const VU at = hn::ShiftLeft<kLogCellWords>(hn::IfThenElseZero(RowsBelow(i, n), Load(cell + i)));
    const auto field = [&](std::uint32_t f) HWY_ATTR { return Gather(fields, at + SetU(f)); };
    const V3 dir = {field(SKYWAVE_WORD(LightCell, dir[0])), field(SKYWAVE_WORD(LightCell, dir[1])),
                    field(SKYWAVE_WORD(LightCell, dir[2]))};
    Store(weights.Weight(dir, field(SKYWAVE_WORD(LightCell, energy)),
                         field(SKYWAVE_WORD(LightCell, radius)),
                         field(SKYWAVE_WORD(LightCell, reach))),
          weight + i);
  }
}

template <class Bsdf>
void DrawRows(const SurfaceColumns& s, const MaterialView& materials,
              const ScatterUniforms& uniforms, std::uint32_t n, const LightColumns& directions) {
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    const ShadingLanes lanes(s, i);
    const Bsdf bsdf(s, materials, i, n);
    const BsdfSample sample = bsdf.Draw(lanes.wo, Load(uniforms.direction.u + i),
                                        Load(uniforms.direction.v + i), Load(uniforms.lobe.u + i));
    Store3(ToWorld(lanes.frame, sample.wi), directions.dir_x + i, directions.dir_y + i,
           directions.dir_z + i);
  }
}

// Appends the rays of one vector of surfaces that scatter towards `world` with the given weight.
// With `kMoved`, origins may lie behind the surface (MoveOrigins). `control`, where it is not null,
// is the weight of what is known analytically.
template <bool kMoved = false>
HWY_INLINE std::uint32_t AppendScattered(const SurfaceColumns& s, const ShadingLanes& lanes,
                                         std::uint32_t i, std::uint32_t n, const V3& world,
                                         const V3& weight, VF pdf, MF alive, VF roulette,
                                         const ScatterPolicy& policy, const RayColumns& rays,
                                         std::uint32_t to, const V3* control = nullptr) {
  const VF zero = hn::Zero(F());
  V3 throughput = Load3(s.throughput_r + i, s.throughput_g + i, s.throughput_b + i) * weight;
  VF largest = MaxComponent(throughput);
  V3 known = throughput;
  if (control != nullptr) {
    known = Load3(s.throughput_r + i, s.throughput_g + i, s.throughput_b + i) * (*control);
    largest = hn::Max(largest, MaxComponent(known));
  }
  alive = hn::And(alive, hn::Gt(largest, zero));
  if (policy.roulette) {
    if (policy.transport == Transport::kFlux) {
      largest =
          largest / MaxComponent(Load3(s.throughput_r + i, s.throughput_g + i, s.throughput_b + i));
    }
    const VF survival = hn::Min(largest, Set(1.0f));
    alive = hn::And(alive, hn::Lt(roulette, survival));
    throughput = throughput * (1.0f / survival);
    if (control != nullptr) known = known * (1.0f / survival);
  }
  const MU rows = hn::And(hn::RebindMask(U(), alive), RowsBelow(i, n));
  const RowCompressor append(rows);
  if (append.count() == 0) return to;

  const V3 front = Load3(s.org_x + i, s.org_y + i, s.org_z + i);
  const VF thickness = 2.0f * Load(s.lift + i);
  MF through = hn::Lt(Dot(lanes.ng, world), zero);
  if constexpr (kMoved) through = hn::Xor(through, hn::Lt(thickness, zero));
  const V3 origin = IfThen(through, front - lanes.ng * thickness, front);
  append.Append(origin.x, rays.org_x + to);
  append.Append(origin.y, rays.org_y + to);
  append.Append(origin.z, rays.org_z + to);
  append.Append(world.x, rays.dir_x + to);
  append.Append(world.y, rays.dir_y + to);
  append.Append(world.z, rays.dir_z + to);
  append.Append(throughput.x, rays.throughput_r + to);
  append.Append(throughput.y, rays.throughput_g + to);
  append.Append(throughput.z, rays.throughput_b + to);
  append.Append(pdf, rays.pdf + to);
  append.Move(s.path + i, rays.path + to);
  if (control != nullptr) {
    append.Append(known.x, policy.control->out.r + to);
    append.Append(known.y, policy.control->out.g + to);
    append.Append(known.z, policy.control->out.b + to);
  }
  append.Append(hn::Iota(U(), policy.first_row + i), rays.from + to);
  Store(Set(std::numeric_limits<float>::infinity()), rays.t_far + to);
  return to + append.count();
}

template <class Bsdf, bool kControlled>
std::uint32_t ScatterControlledRows(const SurfaceColumns& s, const MaterialView& materials,
                                    const ScatterUniforms& uniforms, std::uint32_t n,
                                    const ScatterPolicy& policy, const RayColumns& rays,
                                    std::uint32_t appended) {
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    const ShadingLanes lanes(s, i);
    const Bsdf bsdf(s, materials, i, n);
    const BsdfSample sample = bsdf.Draw(lanes.wo, Load(uniforms.direction.u + i),
                                        Load(uniforms.direction.v + i), Load(uniforms.lobe.u + i));
    const V3 world = ToWorld(lanes.frame, sample.wi);
    V3 weight = sample.weight;
    if (policy.transport == Transport::kFlux) {
      const V3 wo = Outgoing(s, i);
      VF factor = ShadingNormalFactor(lanes.frame.n, lanes.ng, wo, world);
      if constexpr (kRefracts<Bsdf>) {
        const MF through = hn::Lt(sample.wi.z, hn::Zero(F()));
        const VF ratio = RatioOf(bsdf);
        factor = IfThen(through, factor / (ratio * ratio), factor);
      }
      weight = weight * factor;
    }
    const MF connects = Connects<Bsdf>(lanes, world, sample.wi);
    const VF zero = hn::Zero(F()), roulette = Load(uniforms.lobe.v + i);
    MF alive = hn::Gt(sample.pdf, zero);
    if constexpr (kControlled) {
      // What is known does not depend on which side of the triangle the direction is.
      const DiffuseControl<Bsdf> diffuse(*policy.control, bsdf, lanes, i, RowsBelow(i, n));
      V3 control = weight;
      if constexpr (!kOnlyDiffuse<Bsdf>) {
        control = sample.wi * (1.0f / hn::Max(sample.pdf, Set(1e-30f)));
      }
      control = diffuse.Value(world, control, weight);
      weight = IfThen(connects, weight, V3{zero, zero, zero});
      appended = AppendScattered<kTransmits<Bsdf>>(s, lanes, i, n, world, weight, sample.pdf, alive,
                                                   roulette, policy, rays, appended, &control);
    } else {
      alive = hn::And(connects, alive);
      appended = AppendScattered<kTransmits<Bsdf>>(s, lanes, i, n, world, weight, sample.pdf, alive,
                                                   roulette, policy, rays, appended);
    }
  }
  return appended;
}

template <class Bsdf>
std::uint32_t ScatterRows(const SurfaceColumns& s, const MaterialView& materials,
                          const ScatterUniforms& uniforms, std::uint32_t n,
                          const ScatterPolicy& policy, const RayColumns& rays,
                          std::uint32_t appended) {
  if constexpr (kDiffuse<Bsdf>) {
    if (policy.control != nullptr) {
      return ScatterControlledRows<Bsdf, true>(s, materials, uniforms, n, policy, rays, appended);
    }
  }
  const std::uint32_t end =
      ScatterControlledRows<Bsdf, false>(s, materials, uniforms, n, policy, rays, appended);
  if (policy.control != nullptr) ClearControls(policy.control->out, appended, end);
  return end;
}

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

// The entry points of a BSDF: SKYWAVE_BSDF_KERNELS(Name) inside HWY_NAMESPACE compiles them for
// every target, and SKYWAVE_BSDF_TABLE(Name) under HWY_ONCE defines NameKernels(), which dispatches
// and carries NameTraits. They are macros because dispatch works on names of functions.
#define SKYWAVE_BSDF_KERNELS(Bsdf)                                                                 \
  void Evaluate##Bsdf(const SurfaceColumns& s, const MaterialView& m, const LightColumns& lights,  \
                      std::uint32_t n, const BsdfValueColumns& out) {                              \
    EvaluateRows<Bsdf>(s, m, lights, n, out);                                                      \
  }                                                                                                \
  void Evaluate##Bsdf##Lights(const SurfaceColumns& s, const MaterialView& m, std::uint32_t n,     \
                              const MisPolicy& mis, const LightColumns& lights) {                  \
    EvaluateLightRows<Bsdf>(s, m, n, mis, lights);                                                 \
  }                                                                                                \
  void EvaluateControlled##Bsdf##Lights(const SurfaceColumns& s, const MaterialView& m,            \
                                        std::uint32_t n, const MisPolicy& mis,                     \
                                        const LightControl& control, const LightColumns& lights) { \
    EvaluateControlledRows<Bsdf>(s, m, n, mis, control, lights);                                   \
  }                                                                                                \
  void WeighCells##Bsdf(const SurfaceColumns& s, const MaterialView& m, std::uint32_t n,           \
                        const LightCell* cells, std::uint32_t count, float* sums,                  \
                        std::uint32_t stride) {                                                    \
    WeighCellsRows<Bsdf>(s, m, n, cells, count, sums, stride);                                     \
  }                                                                                                \
  void WeighCell##Bsdf(const SurfaceColumns& s, const MaterialView& m, std::uint32_t n,            \
                       const LightCell* cells, const std::uint32_t* cell, float* weight) {         \
    WeighCellRows<Bsdf>(s, m, n, cells, cell, weight);                                             \
  }                                                                                                \
  void Draw##Bsdf(const SurfaceColumns& s, const MaterialView& m, const ScatterUniforms& uniforms, \
                  std::uint32_t n, const LightColumns& directions) {                               \
    DrawRows<Bsdf>(s, m, uniforms, n, directions);                                                 \
  }                                                                                                \
  std::uint32_t Scatter##Bsdf(const SurfaceColumns& s, const MaterialView& m,                      \
                              const ScatterUniforms& uniforms, std::uint32_t n,                    \
                              const ScatterPolicy& policy, const RayColumns& rays,                 \
                              std::uint32_t appended) {                                            \
    return ScatterRows<Bsdf>(s, m, uniforms, n, policy, rays, appended);                           \
  }

#define SKYWAVE_BSDF_TABLE(Bsdf)                                                                   \
  HWY_EXPORT(Evaluate##Bsdf);                                                                      \
  HWY_EXPORT(Evaluate##Bsdf##Lights);                                                              \
  HWY_EXPORT(EvaluateControlled##Bsdf##Lights);                                                    \
  HWY_EXPORT(WeighCells##Bsdf);                                                                    \
  HWY_EXPORT(WeighCell##Bsdf);                                                                     \
  HWY_EXPORT(Draw##Bsdf);                                                                          \
  HWY_EXPORT(Scatter##Bsdf);                                                                       \
  BsdfKernels Bsdf##Kernels() {                                                                    \
    BsdfKernels kernels{Bsdf##Traits};                                                             \
    kernels.evaluate = SKYWAVE_EVALUATE(Evaluate##Bsdf);                                           \
    kernels.evaluate_lights = [](const SurfaceColumns& s, const MaterialView& m, std::uint32_t n,  \
                                 const MisPolicy& mis, const LightColumns& lights) {               \
      HWY_DYNAMIC_DISPATCH(Evaluate##Bsdf##Lights)(s, m, n, mis, lights);                          \
    };                                                                                             \
    kernels.evaluate_controlled_lights =                                                           \
        [](const SurfaceColumns& s, const MaterialView& m, std::uint32_t n, const MisPolicy& mis,  \
           const LightControl& control, const LightColumns& lights) {                              \
          if constexpr (HWY_NAMESPACE::kDiffuse<HWY_NAMESPACE::Bsdf>) {                            \
            HWY_DYNAMIC_DISPATCH(EvaluateControlled##Bsdf##Lights)(s, m, n, mis, control, lights); \
          } else {                                                                                 \
            HWY_DYNAMIC_DISPATCH(Evaluate##Bsdf##Lights)(s, m, n, mis, lights);                    \
            ClearControls(control.out, n);                                                         \
          }                                                                                        \
        };                                                                                         \
    kernels.weigh_cells = [](const SurfaceColumns& s, const MaterialView& m, std::uint32_t n,      \
                             const LightCell* cells, std::uint32_t count, float* sums,             \
                             std::uint32_t stride) {                                               \
      HWY_DYNAMIC_DISPATCH(WeighCells##Bsdf)(s, m, n, cells, count, sums, stride);                 \
    };                                                                                             \
    kernels.weigh_cell = [](const SurfaceColumns& s, const MaterialView& m, std::uint32_t n,       \
                            const LightCell* cells, const std::uint32_t* cell, float* weight) {    \
      HWY_DYNAMIC_DISPATCH(WeighCell##Bsdf)(s, m, n, cells, cell, weight);                         \
    };                                                                                             \
    kernels.draw = [](const SurfaceColumns& s, const MaterialView& m,                              \
                      const ScatterUniforms& uniforms, std::uint32_t n,                            \
                      const LightColumns& directions) {                                            \
      HWY_DYNAMIC_DISPATCH(Draw##Bsdf)(s, m, uniforms, n, directions);                             \
    };                                                                                             \
    kernels.scatter = SKYWAVE_SCATTER(Scatter##Bsdf);                                              \
    return kernels;                                                                                \
  }

#define SKYWAVE_EVALUATE(function)                                                                \
  [](const SurfaceColumns& s, const MaterialView& m, const LightColumns& lights, std::uint32_t n, \
     const BsdfValueColumns& out) {                                                               \
    HWY_DYNAMIC_DISPATCH(function)                                                                \
    (s, m, lights, n, out);                                                                       \
  }
#define SKYWAVE_SCATTER(function)                                                     \
  [](const SurfaceColumns& s, const MaterialView& m, const ScatterUniforms& uniforms, \
     std::uint32_t n, const ScatterPolicy& policy, const RayColumns& rays,            \
     std::uint32_t appended) {                                                        \
    return HWY_DYNAMIC_DISPATCH(function)(s, m, uniforms, n, policy, rays, appended); \
  }

#endif  // per-target include guard
