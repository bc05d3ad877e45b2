// A comparison of strategies and integrators from the request to its report: tables, reference,
// measurement, summary. The subcommand converge and the library run it.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "job/option.h"
#include "job/request.h"
#include "job/watch.h"
#include "measure/converge/report.h"

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
};

// The options of a comparison besides those of its job.
std::vector<OptionOf<ConvergeRequest>> ConvergeOptions();

// True for an option of a job that has another form in ConvergeOptions, or none.
bool HasOwnFormInConverge(const OptionInfo& option);

// Runs `work` (see Watch); `what` is half a sentence that says what it does.
using Watcher =
    std::function<void(const std::string& what, std::uint64_t total, const WatchedWork& work)>;

// Compares. `job` is that of `request.job`. Throws InputError.
ConvergeReport RunConverge(const RenderJob& job, ConvergeRequest request, const Watcher& watch);

}  // namespace skywave
