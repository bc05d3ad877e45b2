#include "wavefront/integrator.h"

namespace skywave {

#define SKYWAVE_DESCRIPTOR(integrator, name) integrator##Integrator(),
const IntegratorDescriptor& Describe(Integrator integrator) {
  static const IntegratorDescriptor table[] = {SKYWAVE_INTEGRATORS(SKYWAVE_DESCRIPTOR)};
  return table[static_cast<std::uint32_t>(integrator)];
}
#undef SKYWAVE_DESCRIPTOR

}  // namespace skywave
