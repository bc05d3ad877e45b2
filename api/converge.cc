// Implements Converge, the comparison of strategies and integrators.
#include <memory>

#include "api/errors.h"
#include "api/state.h"
#include "bench/measure/converge/run.h"
#include "job/options.h"

namespace skywave::api {

std::string Converge(const Scene& scene, const Options& options, const ProgressCallback& progress) {
  return Translated([&] {
    const auto request = std::make_shared<ConvergeRequest>();
    std::vector<BoundOption> bound;
    const std::shared_ptr<JobRequest> of_job(request, &request->job);
    for (const JobOption& option : JobOptions()) {
      const bool of_scene = option.positional || option.of_reading;
      if (!of_scene && !HasOwnFormInConverge(option)) bound.push_back(Bind(option, of_job));
    }
    for (const OptionOf<ConvergeRequest>& option : ConvergeOptions()) {
      bound.push_back(Bind(option, request));
    }
    SetOptions(bound, options);
    request->job.scene = scene.state_->name();
    request->repeatable = !scene.state_->changed;
    CheckSavedReference(*request);
    const RenderJob job = MakeJob(*scene.state_, request->job);
    const ConvergeReport report = RunConverge(
        job, *request, [&](const std::string&, std::uint64_t total, const WatchedWork& work) {
          Watch(total, work, progress);
        });
    return JsonText(report);
  });
}

}  // namespace skywave::api
