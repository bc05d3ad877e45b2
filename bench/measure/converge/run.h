// Runs a comparison of strategies and integrators from the request to its report: tables,
// reference, measurement, summary. The subcommand converge and the library call it.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "bench/measure/converge/report.h"
#include "job/request.h"
#include "job/watch.h"
#include "wavefront/option.h"

namespace skywave {

struct ConvergeRequest {
  JobRequest job;
  std::vector<std::string> strategies = {"importance"};
  std::vector<Integrator> integrators;  // empty: that of the job
  std::vector<std::uint32_t> budgets;   // empty: 1, 2, 4, ... 64
  double seconds = 0;                   // 0: budgets determine the samples
  ConvergeSettings settings;
  std::optional<double> target;
  std::string reference = "auto";                  // or a file
  std::optional<Integrator> reference_integrator;  // unset: derived from the contestants
  std::uint32_t reference_samples = 0;             // 0: derived from the budgets
  std::string save_reference;                      // file for it; empty: none
  bool repeatable = true;  // whether a command can make the job: not if its scene was changed
};

// Returns the options of a comparison, without those of its job.
std::vector<OptionOf<ConvergeRequest>> ConvergeOptions();

// Returns whether an option of a job has another form in ConvergeOptions, or none there.
bool HasOwnFormInConverge(const OptionInfo& option);

// Throws InputError if `request` would keep a reference that is not computed, or would keep it in a
// file that is not an EXR, is an input or cannot be written.
void CheckSavedReference(const ConvergeRequest& request);

// A watcher runs `work` (see Watch); `what` is half a sentence that says what the work does.
using Watcher =
    std::function<void(const std::string& what, std::uint64_t total, const WatchedWork& work)>;

// Measures and summarizes. `job` has been made of `request.job` and has to outlive the report,
// which points to it. Throws InputError, and what `watch` throws.
ConvergeReport RunConverge(const RenderJob& job, ConvergeRequest request, const Watcher& watch);

}  // namespace skywave
