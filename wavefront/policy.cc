#include "wavefront/policy.h"

namespace skywave {

#define SKYWAVE_DESCRIPTOR(policy) policy##Policy(),
std::span<const PolicyDescriptor> Policies() {
  static const PolicyDescriptor table[] = {SKYWAVE_POLICIES(SKYWAVE_DESCRIPTOR)};
  return table;
}
#undef SKYWAVE_DESCRIPTOR

void AddPolicyTables(const RenderOptions& options, Worker& worker) {
  for (const PolicyDescriptor& policy : Policies()) {
    if (policy.add_tables != nullptr) policy.add_tables(options, worker);
  }
}

}  // namespace skywave
