#include "wavefront/worker.h"

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

Worker::~Worker() = default;

std::unique_ptr<Worker> MakeWorker(const RenderOptions& options) {
  auto worker = std::make_unique<Worker>(options.wave);
  const IntegratorDescriptor& integrator = Describe(options.integrator);
  if (integrator.has_light_paths()) worker->light.emplace(options.wave);
  if (Sums(options.aovs, AovSum::kLightGroups)) worker->groups.emplace(options.wave);
  if (integrator.add_tables != nullptr) integrator.add_tables(options, *worker);
  if (options.control != ControlVariate::kNone) {
    worker->control.emplace(options.wave);
    if (worker->continuations) worker->continuations->wave.control.emplace(options.wave);
  }
  return worker;
}

}  // namespace skywave
