// A search finds rows of a table in runs, since the points of a leaf lie next to each other. One
// load from the first row of a run and a permutation fetch the others, where a gather would load
// every lane by itself.
#if defined(SKYWAVE_KERNELS_RUNS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SKYWAVE_KERNELS_RUNS_INL_H_
#undef SKYWAVE_KERNELS_RUNS_INL_H_
#else
#define SKYWAVE_KERNELS_RUNS_INL_H_
#endif

#include "kernels/simd/simd-inl.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

class RowRun {
 public:
  // Takes rows[i], rows[i + 1], ... as far as they lie within a vector from rows[i] on and before
  // rows[n]; `rows` is padded.
  HWY_INLINE RowRun(const std::uint32_t* rows, std::uint32_t i, std::uint32_t n) : first_(rows[i]) {
    const auto lanes = static_cast<std::uint32_t>(hn::Lanes(U()));
    const VU lane = Load(rows + i) - SetU(first_);
    const MU near = hn::And(hn::Lt(lane, SetU(lanes)), RowsBelow(i, n));
    const std::intptr_t end = hn::FindFirstTrue(U(), hn::Not(near));
    count_ = end < 0 ? lanes : static_cast<std::uint32_t>(end);
    lane_ = hn::And(lane, SetU(lanes - 1));
  }
  std::uint32_t count() const { return count_; }
  // Returns their values of a padded column in the first `count` lanes.
  HWY_INLINE VU Take(const std::uint32_t* column) const {
    return hn::TableLookupLanes(Load(column + first_), hn::IndicesFromVec(U(), lane_));
  }
  HWY_INLINE VF Take(const float* column) const {
    return AsFloat(
        hn::TableLookupLanes(AsBits(Load(column + first_)), hn::IndicesFromVec(U(), lane_)));
  }

 private:
  std::uint32_t first_, count_;
  VU lane_;
};

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
