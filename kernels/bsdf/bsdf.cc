#include "kernels/bsdf/bsdf.h"

#include <array>

namespace skywave {

#define SKYWAVE_KERNELS(name) name##Kernels(),
std::span<const BsdfKernels, kBsdfKinds> Bsdfs() {
  static const std::array<BsdfKernels, kBsdfKinds> table = {
      SKYWAVE_DENSE_BSDFS(SKYWAVE_KERNELS) SKYWAVE_DELTA_BSDFS(SKYWAVE_KERNELS)};
  return table;
}
#undef SKYWAVE_KERNELS

}  // namespace skywave
