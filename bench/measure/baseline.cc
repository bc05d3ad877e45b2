#include "bench/measure/baseline.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "base/json.h"
#include "bench/measure/bench_compare.h"
#include "bench/measure/json_input.h"

namespace skywave {
namespace {

constexpr std::string_view kBaselineSchema = "skywave-bench-baseline-1";

template <class Value>
nlohmann::ordered_json Members(const std::vector<std::pair<std::string, Value>>& values) {
  nlohmann::ordered_json json = nlohmann::ordered_json::object();
  for (const auto& [name, value] : values) json[name] = value;
  return json;
}

NamedTexts ReadTexts(const JsonInput& from) {
  NamedTexts texts;
  for (const auto& [name, value] : from.members()) texts.emplace_back(name, value.text());
  return texts;
}

// Returns null if there is none of that name.
template <class Value>
const Value* Find(const std::vector<std::pair<std::string, Value>>& values, std::string_view name) {
  for (const auto& [key, value] : values) {
    if (key == name) return &value;
  }
  return nullptr;
}

// Returns a line for each name whose value differs.
std::vector<std::string> DifferentTexts(const NamedTexts& before, const NamedTexts& now) {
  std::vector<std::string> lines;
  for (const auto& [name, value] : before) {
    const std::string* const found = Find(now, name);
    if (found == nullptr || *found != value) {
      lines.push_back(fmt::format("{}: {}, was {}", name, found ? *found : "none", value));
    }
  }
  for (const auto& [name, value] : now) {
    if (Find(before, name) == nullptr) {
      lines.push_back(fmt::format("{}: {}, was none", name, value));
    }
  }
  return lines;
}

GateResult JudgeCounters(const Baseline& baseline, const Baseline& now) {
  GateResult result = {.gate = BaselineGate::kCounters, .summary = {}, .lines = {}};
  if (baseline.hits != now.hits) {
    result.verdict = GateResult::kSkipped;
    result.summary = fmt::format("Embree has found hits with {}, not {}", now.hits, baseline.hits);
    return result;
  }
  result.lines = DifferentTexts(baseline.counters, now.counters);
  if (!result.lines.empty()) result.verdict = GateResult::kFailed;
  result.summary = result.lines.empty()
                       ? fmt::format("all {} as they were", baseline.counters.size())
                       : fmt::format("{} differ", result.lines.size());
  return result;
}

GateResult JudgeInstructions(const Baseline& baseline, const Baseline& now) {
  GateResult result = {
      .gate = BaselineGate::kInstructions, .summary = now.not_counted, .lines = {}};
  if (result.summary.empty() && baseline.instructions.empty()) {
    result.summary = "the baseline has none";
  }
  if (result.summary.empty() && baseline.toolchain != now.toolchain) {
    result.summary =
        fmt::format("the baseline is that of {}, not of {}", baseline.toolchain, now.toolchain);
  }
  if (!result.summary.empty()) {
    result.verdict = GateResult::kSkipped;
    return result;
  }
  double farthest = 0;
  for (const auto& [stage, before] : baseline.instructions) {
    const std::uint64_t* const count = Find(now.instructions, stage);
    const double change = count ? double(*count) / double(before) - 1 : -1;
    if (std::abs(change) > std::abs(farthest)) farthest = change;
    if (std::abs(change) <= kInstructionLimit) continue;
    result.verdict = GateResult::kFailed;
    result.lines.push_back(
        fmt::format("{}: {}, was {} ({:+.2f} %)", stage, count ? *count : 0, before, 100 * change));
  }
  for (const auto& [stage, count] : now.instructions) {
    if (Find(baseline.instructions, stage) != nullptr) continue;
    result.verdict = GateResult::kFailed;
    result.lines.push_back(fmt::format("{}: {}, was none", stage, count));
  }
  result.summary = fmt::format("at most {:+.4f} % in a stage", 100 * farthest);
  return result;
}

GateResult JudgeTime(const Baseline& baseline, const Baseline& now, double threshold) {
  GateResult result = {.gate = BaselineGate::kTime, .summary = {}, .lines = {}};
  const std::vector<std::string> elsewhere = DifferentTexts(baseline.machine, now.machine);
  if (!elsewhere.empty()) {
    result.verdict = GateResult::kSkipped;
    result.summary = "not measured like this: " + elsewhere.front();
    return result;
  }
  if (baseline.seconds.empty()) {
    result.verdict = GateResult::kSkipped;
    result.summary = "the baseline has none";
    return result;
  }
  if (baseline.seconds.size() < 2 || now.seconds.size() < 2) {
    result.verdict = GateResult::kSkipped;
    result.summary = "one render gives no interval; repeat it";
    return result;
  }
  if (!baseline.doubts.empty()) {
    result.verdict = GateResult::kSkipped;
    result.summary = fmt::format("the baseline's times are doubtful: {}; take it again",
                                 fmt::join(baseline.doubts, "; "));
    return result;
  }
  if (!now.doubts.empty()) {
    result.verdict = GateResult::kUnclear;
    result.summary = fmt::format("{}", fmt::join(now.doubts, "; "));
    return result;
  }
  const SpeedRatio ratio = CompareRuns("", {&baseline.seconds, 1}, {&now.seconds, 1});
  result.summary =
      fmt::format("{:.4f} times as long [{:.4f}, {:.4f}], least times {:.4f}", ratio.ratio.value,
                  ratio.ratio.interval.low, ratio.ratio.interval.high, ratio.least);
  if (ratio.slower(threshold)) {
    result.verdict = GateResult::kFailed;
    result.lines.push_back(fmt::format("median {:.4f} s, was {:.4f} s; {:g} % are allowed", ratio.b,
                                       ratio.a, 100 * threshold));
  } else if (ratio.may_hide(threshold)) {
    result.verdict = GateResult::kUnclear;
  }
  return result;
}

}  // namespace

nlohmann::ordered_json Json(const Baseline& baseline) {
  nlohmann::ordered_json json;
  json["schema"] = kBaselineSchema;
  json["version"] = baseline.version;
  json["reasons"] = baseline.reasons;
  json["options"] = Members(baseline.options);
  json["hits"] = baseline.hits;
  json["counters"] = Members(baseline.counters);
  json["toolchain"] = baseline.toolchain;
  json["instructions"] = Members(baseline.instructions);
  json["machine"] = Members(baseline.machine);
  json["render_seconds"] = baseline.seconds;
  json["doubts"] = baseline.doubts;
  return json;
}

std::string JsonText(const Baseline& baseline) { return JsonText(Json(baseline), 2); }

Baseline ReadBaseline(const std::string& path) { return BaselineOf(ReadJson(path), path); }

Baseline BaselineOf(const nlohmann::json& json, const std::string& file) {
  const JsonInput root(json, file);
  root.schema({kBaselineSchema}, "a baseline of skywave bench");
  Baseline baseline = {.reasons = {},
                       .version = root.at("version").text(),
                       .options = ReadTexts(root.at("options")),
                       .hits = root.at("hits").text(),
                       .counters = ReadTexts(root.at("counters")),
                       .toolchain = root.at("toolchain").text(),
                       .instructions = {},
                       .machine = ReadTexts(root.at("machine")),
                       .seconds = {}};
  const JsonInput seconds = root.at("render_seconds");
  if (!seconds.items().empty()) baseline.seconds = seconds.positive_numbers();
  for (const JsonInput& reason : root.at("reasons").items()) {
    baseline.reasons.push_back(reason.text());
  }
  if (root.has("doubts")) {  // older files have none
    for (const JsonInput& doubt : root.at("doubts").items()) {
      baseline.doubts.push_back(doubt.text());
    }
  }
  for (const auto& [stage, count] : root.at("instructions").members()) {
    baseline.instructions.emplace_back(stage, count.whole_number(1, JsonInput::kMostWhole));
  }
  if (baseline.counters.empty()) root.at("counters").Fail("is empty");
  return baseline;
}

std::vector<GateResult> JudgeBaseline(const Baseline& baseline, const Baseline& now,
                                      const std::vector<BaselineGate>& gates, double threshold,
                                      const std::string& path) {
  const std::vector<std::string> options = DifferentTexts(baseline.options, now.options);
  if (!options.empty()) {
    throw InputError(
        InputPosition::File(path),
        fmt::format("/options: is the baseline of another picture: {}", fmt::join(options, "; ")));
  }
  std::vector<GateResult> results;
  for (const BaselineGate gate : gates) {
    results.push_back(gate == BaselineGate::kCounters       ? JudgeCounters(baseline, now)
                      : gate == BaselineGate::kInstructions ? JudgeInstructions(baseline, now)
                                                            : JudgeTime(baseline, now, threshold));
  }
  return results;
}

int ExitCodeOf(const std::vector<GateResult>& results) {
  int code = 0;
  for (const GateResult& result : results) {
    if (result.verdict != GateResult::kFailed) continue;
    code = code == 0 ? ExitCodeOf(result.gate) : std::min(code, ExitCodeOf(result.gate));
  }
  return code;
}

}  // namespace skywave
