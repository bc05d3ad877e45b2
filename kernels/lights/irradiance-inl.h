// These functions evaluate the control variate of irradiance on vectors.
#if defined(SKYWAVE_KERNELS_IRRADIANCE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SKYWAVE_KERNELS_IRRADIANCE_INL_H_
#undef SKYWAVE_KERNELS_IRRADIANCE_INL_H_
#else
#define SKYWAVE_KERNELS_IRRADIANCE_INL_H_
#endif

#include "kernels/lights/irradiance.h"
#include "kernels/simd/math-inl.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

// One vector of normals and the nodes next to them.
class IrradianceLanes {
 public:
  // Rows beyond the last one, which are not among `rows`, may have any normal.
  HWY_INLINE IrradianceLanes(const IrradianceView& view, const V3& world_normal, MU rows)
      : nodes_(view.nodes) {
    const float* r = view.map_from_world;
    normal_ = {Dot(Set3(r), world_normal), Dot(Set3(r + 3), world_normal),
               Dot(Set3(r + 6), world_normal)};
    const VF sum = hn::Abs(normal_.x) + hn::Abs(normal_.y) + hn::Abs(normal_.z);
    const VF scale = 1.0f / hn::Max(sum, Set(1e-30f));
    V3 p = normal_ * scale;
    Fold(hn::Lt(p.z, hn::Zero(F())), p);
    constexpr float kHalf = 0.5f * (kIrradianceNodes - 1);
    const VF column = NodeOf(p.x), row = NodeOf(p.y);
    const VU node = ToUnsigned(row) * SetU(kIrradianceNodes) + ToUnsigned(column);
    const V3 size = {hn::Abs(normal_.x), hn::Abs(normal_.y), hn::Abs(normal_.z)};
    const VF largest = hn::Max(hn::Max(size.x, size.y), size.z);
    const MF on_axis = hn::Lt(sum - largest, Set(kOnAxis));
    const VU axis = IfThen(hn::RebindMask(U(), hn::Eq(size.x, largest)), Axis(normal_.x, 0),
                           IfThen(hn::RebindMask(U(), hn::Eq(size.y, largest)), Axis(normal_.y, 2),
                                  Axis(normal_.z, 4)));
    node_ = hn::IfThenElseZero(rows, IfThen(hn::RebindMask(U(), on_axis), axis, node));
    horizon_ = IfThen(on_axis, hn::Zero(F()), Set(kHorizonSine));

    V3 q = {column * (1 / kHalf) - 1.0f, row * (1 / kHalf) - 1.0f, hn::Zero(F())};
    q.z = 1.0f - (hn::Abs(q.x) + hn::Abs(q.y));
    Fold(hn::Lt(q.z, hn::Zero(F())), q);
    const V3 tabulated = Normalize(q);
    tabulated_ = Set3(r) * tabulated.x + Set3(r + 3) * tabulated.y + Set3(r + 6) * tabulated.z;
  }

  // Returns the lanes where the integral counts the light from direction `world`.
  HWY_INLINE MF Counts(const V3& world) const { return hn::Gt(Dot(tabulated_, world), horizon_); }

  // Returns the integral of radiance times the cosine at the normal over the directions that count.
  HWY_INLINE V3 Integral() const {
    static_assert(kIrradianceWords == 9);
    const VU first = hn::ShiftLeft<3>(node_) + node_;
    const auto channel = [&](std::uint32_t word) HWY_ATTR {
      const V3 vector = {Gather(nodes_, first + SetU(word)), Gather(nodes_, first + SetU(word + 1)),
                         Gather(nodes_, first + SetU(word + 2))};
      return Dot(vector, normal_);
    };
    return {channel(0), channel(3), channel(6)};
  }

 private:
  // Folds points of the lower half of the octahedron to the corners of the square, and back.
  static HWY_INLINE void Fold(MF below, V3& p) {
    const VF one = Set(1.0f);
    const VF x = hn::CopySign(one - hn::Abs(p.y), p.x);
    const VF y = hn::CopySign(one - hn::Abs(p.x), p.y);
    p.x = IfThen(below, x, p.x), p.y = IfThen(below, y, p.y);
  }
  // Returns the entry of an axis, or of the opposite one, which follows it.
  static HWY_INLINE VU Axis(VF coordinate, std::uint32_t axis) {
    constexpr std::uint32_t kFirst = kIrradianceNodes * kIrradianceNodes;
    const MU negative = hn::RebindMask(U(), hn::Lt(coordinate, hn::Zero(F())));
    return IfThen(negative, SetU(kFirst + axis + 1), SetU(kFirst + axis));
  }
  static HWY_INLINE VF NodeOf(VF coordinate) {
    constexpr float kHalf = 0.5f * (kIrradianceNodes - 1);
    const VF position = (coordinate + 1.0f) * kHalf;
    return Clamp(hn::Floor(position + 0.5f), 0.0f, float(kIrradianceNodes - 1));
  }

  const float* nodes_;
  V3 normal_;     // in map space
  V3 tabulated_;  // in world space
  VF horizon_;    // sine
  VU node_;
};

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
