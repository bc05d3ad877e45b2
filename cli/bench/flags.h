// The flags of skywave bench, and what it does for each kind of measurement.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "bench/measure/baseline.h"
#include "bench/measure/bench_export.h"
#include "bench/measure/suite.h"
#include "cli/progress.h"
#include "job/request.h"

namespace skywave {

struct BenchFlags {
  JobRequest request;
  std::optional<int> repetitions;
  std::optional<double> deviation_percent;
  std::string json, report;
  std::vector<std::string> history;
  std::optional<ExportFormat> export_as;
  bool full = false, counters = false, instructions = false, renders_only = false;
  std::optional<double> sustain_seconds;
  std::optional<int> copies;
  bool rotate = false;
  std::vector<std::string> compare;
  std::string baseline;
  std::optional<std::string> new_baseline_reason;
  std::vector<BaselineGate> gates = {BaselineGate::kCounters, BaselineGate::kInstructions,
                                     BaselineGate::kTime};
  double threshold_percent = 5;
  ProgressFlags progress;

  bool has_scene() const { return !request.scene.empty(); }
};

inline constexpr int kExitWrongPicture = 1, kExitSlower = 1, kExitCannotTell = 2;
inline constexpr int kExitSkipped = 77;  // as the checks of automake report it

// The number of repetitions: what was asked for, else that of a scene or a suite.
int RepetitionsOf(const BenchFlags& flags);
// The deviation at which they end: what was asked for, else kDeviationLimit unless their number
// was.
double DeviationOf(const BenchFlags& flags);

// Reports a wrong picture, and the expected values under which it would be right.
bool PictureIsRight(const SuiteScene& scene, PictureCheck check, const Fingerprint& found);

// Each returns the exit code.
int BenchScene(const BenchFlags& flags);
int BenchSuite(const BenchFlags& flags);
int BenchSustained(const BenchFlags& flags);
int BenchCopies(const BenchFlags& flags);
int CompareBenches(const BenchFlags& flags);
int GuardScene(const BenchFlags& flags);
int PrintCounters(const BenchFlags& flags);      // of a scene
int PrintInstructions(const BenchFlags& flags);  // likewise

}  // namespace skywave
