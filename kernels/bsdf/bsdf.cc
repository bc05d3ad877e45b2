#include "kernels/bsdf/bsdf.h"

#include <algorithm>
#include <array>
#include <iterator>

namespace skywave {

std::span<const MaterialParameter> ParametersOf(const BsdfTraits& traits) {
  const auto* const first = std::begin(traits.parameters);
  const auto* const end =
      std::find_if(first, std::end(traits.parameters),
                   [](const MaterialParameter& parameter) { return parameter.name.empty(); });
  return {first, end};
}

#define SKYWAVE_KERNELS(name) name##Kernels(),
std::span<const BsdfKernels, kBsdfKinds> Bsdfs() {
  static const std::array<BsdfKernels, kBsdfKinds> table = {
      SKYWAVE_DENSE_BSDFS(SKYWAVE_KERNELS) SKYWAVE_DELTA_BSDFS(SKYWAVE_KERNELS)};
  return table;
}
#undef SKYWAVE_KERNELS

}  // namespace skywave
