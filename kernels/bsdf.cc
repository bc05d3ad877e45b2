#include "kernels/bsdf.h"

#include <array>

namespace skywave {

std::span<const BsdfKernels, kBsdfKinds> Bsdfs() {
  static const std::array<BsdfKernels, kBsdfKinds> table = {LambertKernels(), ConductorKernels(),
                                                            MetallicRoughnessKernels(),
                                                            MirrorKernels(), DielectricKernels()};
  return table;
}

}  // namespace skywave
