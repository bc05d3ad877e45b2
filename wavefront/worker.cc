#include "wavefront/worker.h"

#include "wavefront/film/light_groups.h"
#include "wavefront/policy.h"

namespace skywave {

Worker::Worker(std::uint32_t wave)
    : paths(wave),
      rays{soa::Table<RayColumns>(wave), soa::Table<RayColumns>(wave)},
      hits(wave),
      escaped(wave),
      surfaces(wave),
      lights(wave),
      history(wave),
      scratch(wave) {}

std::unique_ptr<Worker> MakeWorker(const RenderOptions& options) {
  auto worker = std::make_unique<Worker>(options.wave);
  const IntegratorDescriptor& integrator = Describe(options.integrator);
  if (Sums(options.aovs, AovSum::kLightGroups)) worker->tables.Add<GroupTables>(options.wave);
  if (integrator.add_tables != nullptr) integrator.add_tables(options, *worker);
  AddPolicyTables(options, *worker);
  return worker;
}

}  // namespace skywave
