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
  // Returns row 0, 1 or 2 of the matrix.
  HWY_INLINE V3 Row(std::size_t row) const {
    const std::size_t first = SKYWAVE_WORD(InstanceRecord, linear) + 3 * row;
    return {Word(first), Word(first + 1), Word(first + 2)};
  }
  // Returns a vector of the object in the world.
  HWY_INLINE V3 Vector(const V3& d) const {
    return {Dot(Row(0), d), Dot(Row(1), d), Dot(Row(2), d)};
  }
  // Returns a point of the object in the world.
  HWY_INLINE V3 Point(const V3& p) const {
    const std::size_t first = SKYWAVE_WORD(InstanceRecord, translation);
    return Vector(p) + V3{Word(first), Word(first + 1), Word(first + 2)};
  }
  // Returns a normal of the object in the world, of another length (NormalInWorld).
  HWY_INLINE V3 Normal(const V3& n) const {
    const V3 r0 = Row(0), r1 = Row(1), r2 = Row(2);
    const VF factor = Word(SKYWAVE_WORD(InstanceRecord, cofactors));
    return V3{Dot(Cross(r1, r2), n), Dot(Cross(r2, r0), n), Dot(Cross(r0, r1), n)} * factor;
  }
  // Returns a direction in the object as a unit vector of the world.
  HWY_INLINE V3 Direction(const V3& d) const { return Normalize(Vector(d)); }
  // Returns the area in the object of an area of 1 in the world with the unit normal n, which is
  // |M^T n| / |det M| (Nanson's formula).
  HWY_INLINE VF AreaInObject(const V3& n) const {
    const V3 r0 = Row(0), r1 = Row(1), r2 = Row(2);
    const V3 back = r0 * n.x + r1 * n.y + r2 * n.z;
    return hn::Sqrt(Dot(back, back)) / hn::Abs(Dot(r0, Cross(r1, r2)));
  }

 private:
  const float* words_;
  VU at_;
};

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
