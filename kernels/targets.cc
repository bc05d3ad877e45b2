#include "kernels/targets.h"

#include <stdexcept>

#include "hwy/highway.h"
#include "kernels/columns.h"

namespace skywave {
namespace {

// The better target has the smaller number.
std::int64_t BestTarget() {
  const std::int64_t targets = hwy::SupportedTargets() & HWY_TARGETS;
  return targets & -targets;
}

}  // namespace

void RequireKernelTarget() {
  if (BestTarget() != 0) return;
  throw std::runtime_error(
      "this processor has no AVX2, which Skywave needs; -DSKYWAVE_ALL_TARGETS=ON builds it for all "
      "processors");
}

std::string KernelTarget() { return hwy::TargetName(BestTarget()); }

std::uint32_t KernelLanes() {
  const std::int64_t target = BestTarget();
  if (target < HWY_AVX2) return kPadRows;
  return target == HWY_AVX2 ? 8 : target < HWY_EMU128 ? 4 : 1;
}

std::string HighwayVersion() {
  return std::to_string(HWY_MAJOR) + "." + std::to_string(HWY_MINOR) + "." +
         std::to_string(HWY_PATCH);
}

}  // namespace skywave
