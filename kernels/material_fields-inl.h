// The material of each row: a field of its record, gathered.
#if defined(SKYWAVE_KERNELS_MATERIAL_FIELDS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SKYWAVE_KERNELS_MATERIAL_FIELDS_INL_H_
#undef SKYWAVE_KERNELS_MATERIAL_FIELDS_INL_H_
#else
#define SKYWAVE_KERNELS_MATERIAL_FIELDS_INL_H_
#endif

#include "kernels/columns.h"
#include "kernels/simd/simd-inl.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

// Returns the index of the first word of the material of each row; rows beyond n get material 0.
HWY_INLINE VU MaterialFields(const SurfaceColumns& s, std::uint32_t i, std::uint32_t n) {
  const VU material = hn::And(Load(s.material + i), SetU(kMaterialMask));
  return hn::ShiftLeft<kLogMaterialWords>(hn::IfThenElseZero(RowsBelow(i, n), material));
}
// These gather a field of each row's material; MaterialFields returns `fields`.
HWY_INLINE VF Field(const MaterialRecord* records, VU fields, MaterialField field) {
  return Gather(reinterpret_cast<const float*>(records), fields + SetU(std::uint32_t(field)));
}
HWY_INLINE VF Field(const MaterialRecord* records, VU fields, MaterialField field,
                    std::uint32_t channel) {
  return Field(records, fields, MaterialField(std::uint32_t(field) + channel));
}

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
