// Implements Converge, the comparison of strategies and integrators.
#include <memory>

#include "api/errors.h"
#include "api/state.h"
#include "bench/measure/converge/run.h"
#include "job/options.h"

namespace skywave::api {

std::string Converge(Scene scene, const Options& options, const ProgressCallback& progress) {
  return Translated([&] {
    const auto request = std::make_shared<ConvergeRequest>();
    std::vector<BoundOption> bound;
    for (BoundOption& option :
         BindJobOptions(std::shared_ptr<JobRequest>(request, &request->job))) {
      if (!HasOwnFormInConverge(option.info)) bound.push_back(std::move(option));
    }
    for (const OptionOf<ConvergeRequest>& option : ConvergeOptions()) {
      bound.push_back(Bind(option, request));
    }
    SetOptions(bound, options);
    request->job.scene = scene.state().name();
    request->repeatable = !scene.state().changed;
    CheckSavedReference(*request);
    const RenderJob job = MakeJob(std::move(scene.state()), request->job);
    const ConvergeReport report = RunConverge(
        job, *request, [&](const std::string&, std::uint64_t total, const WatchedWork& work) {
          Watch(total, work, progress);
        });
    return JsonText(report);
  });
}

}  // namespace skywave::api
