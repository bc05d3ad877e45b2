// Takes normals and directions from the space of an object to the world, one instance per lane.
#if defined(SKYWAVE_KERNELS_INSTANCES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SKYWAVE_KERNELS_INSTANCES_INL_H_
#undef SKYWAVE_KERNELS_INSTANCES_INL_H_
#else
#define SKYWAVE_KERNELS_INSTANCES_INL_H_
#endif

#include "kernels/simd/simd-inl.h"
#include "kernels/surface/instances.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

// Reads the records of the instances of rows i and on of `surfaces`; lanes that are not in `rows`
// have the one of the world.
class InstanceLanes {
 public:
  HWY_INLINE InstanceLanes(const InstanceRecord* records, const SurfaceColumns& surfaces,
                           std::uint32_t i, MU rows)
      : words_(reinterpret_cast<const float*>(records)),
        at_(hn::ShiftLeft<kLogInstanceWords>(
            hn::IfThenElseZero(rows, Load(surfaces.instance + i)))) {}

  HWY_INLINE VF Word(std::size_t word) const {
    return Gather(words_, at_ + SetU(std::uint32_t(word)));
  }
  // Returns row 0, 1 or 2 of the inverse transpose of the matrix.
  HWY_INLINE V3 Row(std::size_t row) const {
    const std::size_t first = SKYWAVE_WORD(InstanceRecord, normal) + 3 * row;
    return {Word(first), Word(first + 1), Word(first + 2)};
  }
  // Returns a normal of the object in the world, of another length.
  HWY_INLINE V3 Normal(const V3& n) const {
    return {Dot(Row(0), n), Dot(Row(1), n), Dot(Row(2), n)};
  }
  // Returns a direction in the object as a unit vector of the world, reversed if the instance
  // mirrors: no BSDF depends on that, and objects with normal maps have no such instance
  // (scene/instances.h).
  HWY_INLINE V3 Direction(const V3& d) const {
    const Rows m = Matrix();
    return Normalize({Dot(m.r0, d), Dot(m.r1, d), Dot(m.r2, d)});
  }
  // Returns the area in the object of an area of 1 in the world with the unit normal n, which is
  // |M^T n| / |det M| (Nanson's formula).
  HWY_INLINE VF AreaInObject(const V3& n) const {
    const Rows m = Matrix();
    const V3 back = m.r0 * n.x + m.r1 * n.y + m.r2 * n.z;
    return hn::Sqrt(Dot(back, back));
  }

 private:
  struct Rows {
    V3 r0, r1, r2;
  };
  // Returns the matrix over its determinant: the cofactors of its inverse transpose.
  HWY_INLINE Rows Matrix() const {
    const V3 r0 = Row(0), r1 = Row(1), r2 = Row(2);
    return {Cross(r1, r2), Cross(r2, r0), Cross(r0, r1)};
  }
  const float* words_;
  VU at_;
};

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
