#include "wavefront/worker.h"

namespace skywave {

Worker::Worker(std::uint32_t wave)
    : paths(wave),
      rays{soa::Table<RayColumns>(wave), soa::Table<RayColumns>(wave)},
      hits(wave),
      escaped(wave),
      surfaces(wave),
      lights(wave),
      scratch(wave) {}

Worker::~Worker() = default;

std::unique_ptr<Worker> MakeWorker(const RenderOptions& options) {
  auto worker = std::make_unique<Worker>(options.wave);
  if (HasLightPaths(options.integrator)) worker->light.emplace(options.wave);
  if (ConnectsSubpaths(options.integrator)) {
    worker->bidirectional.emplace(options.wave, options.max_depth);
  }
  if (options.integrator == Integrator::kVcm) worker->merging.emplace();
  if (options.integrator == Integrator::kPhoton) {
    worker->photon.emplace(options.wave, options.photons.neighbors);
  }
  if (Sums(options.aovs, AovSum::kLightGroups)) worker->groups.emplace(options.wave);
  if (options.split > 0) worker->continuations = std::make_unique<Continuations>(options.wave);
  return worker;
}

}  // namespace skywave
