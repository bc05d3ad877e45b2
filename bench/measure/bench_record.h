// A result of `skywave bench --json` (docs/bench_json.md), as far as results are compared with each
// other and handed to other tools.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "bench/measure/suite.h"

namespace skywave {

inline constexpr std::string_view kSuiteSchema = "skywave-bench-suite-2";
inline constexpr std::string_view kSceneSchema = "skywave-bench-2";

struct SceneRecord {
  std::string name;
  std::string picture;                   // hash of the expected picture; empty: unknown
  double samples = 0;                    // of a render; 0: unknown
  double rays = 0;                       // likewise, of all kinds
  std::vector<double> render;            // [s] every repetition, wall clock
  std::vector<double> processor;         // [s] of all threads meanwhile; empty: unknown
  std::vector<std::string> doubts = {};  // why the times are not to be trusted
};

struct BenchRecord {
  std::string file;
  std::string subject;  // what was measured: "quick suite", or a command that renders a picture
  std::string version;  // of the program
  // Settings whose differences must be reported with a difference in speed: names and values.
  std::vector<std::pair<std::string, std::string>> settings;
  int threads = 0;  // 0: unknown
  std::vector<SceneRecord> scenes;
};

// Throws InputError if the JSON is no result, or one of another schema.
BenchRecord RecordOf(const nlohmann::json& json, const std::string& file);
BenchRecord ReadRecord(const std::string& path);

// Returns the summary of a result of the suite; 0: not measured. Throws InputError likewise.
SuiteSummary SummaryOf(const nlohmann::json& json, const std::string& file);

}  // namespace skywave
