// Compares results that bench has written.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>

#include "base/error.h"
#include "bench/measure/bench_compare.h"
#include "cli/bench/flags.h"
#include "cli/print.h"

namespace skywave {
namespace {

void PrintSpeedRatio(const SpeedRatio& ratio) {
  const auto figure = [](double value) {
    return std::isnan(value) ? std::string("-") : fmt::format("{:.4f}", value);
  };
  Print(stdout, "{:<16}{:>10}{:>10}{:>9.4f}{:>9}  [{:.4f}, {:.4f}]\n", ratio.name, figure(ratio.a),
        figure(ratio.b), ratio.ratio.value, figure(ratio.least), ratio.ratio.interval.low,
        ratio.ratio.interval.high);
}

int ExitCodeOf(SpeedVerdict verdict) {
  if (verdict == SpeedVerdict::kSlower) return kExitSlower;
  return verdict == SpeedVerdict::kCannotTell ? kExitCannotTell : 0;
}

}  // namespace

int CompareBenches(const BenchFlags& flags) {
  if (flags.compare.size() % 2 != 0) {
    throw OptionError("compare", "", "takes pairs of files: A B, or A B A B of runs in turn");
  }
  std::vector<BenchRecord> records;
  for (const std::string& path : flags.compare) records.push_back(ReadRecord(path));
  const BenchComparison comparison = CompareRecords(records);
  const double threshold = flags.threshold_percent / 100;
  Print(stdout, "A {}\nB {}\n", records[0].file, records[1].file);
  for (const std::string& note : comparison.notes) Print(stdout, "note: {}\n", note);
  Print(stdout, "{:<16}{:>10}{:>10}{:>9}{:>9}  interval of 95 % ({})\n",
        records[0].scenes.size() > 1 ? records[0].subject : "scene", "A [s]", "B [s]", "B / A",
        "least",
        comparison.pairs == 1 ? "Yuen, repetitions"
                              : fmt::format("{} pairs of runs", comparison.pairs));
  for (const SpeedRatio& ratio : comparison.ratios) PrintSpeedRatio(ratio);
  const Ratio& whole = comparison.ratios.front().ratio;
  const JudgedSpeed judged = Judge(comparison, threshold);
  std::string verdict(ToString(judged.verdict));
  if (!judged.names.empty()) verdict += fmt::format(": {}", fmt::join(judged.names, ", "));
  for (const std::string& doubt : comparison.doubts) Print(stdout, "doubt: {}\n", doubt);
  if (judged.verdict == SpeedVerdict::kCannotTell) {
    Print(stdout, "{}: measure again with nothing else running, or compare runs in turn: A B A B\n",
          judged.names.empty() ? "times that are doubted say nothing"
                               : "intervals are wider than the threshold");
  }
  Print(stdout, "COMPARE ratio={:.4f} low={:.4f} high={:.4f} pairs={} threshold={:g}% result={}\n",
        whole.value, whole.interval.low, whole.interval.high, comparison.pairs,
        flags.threshold_percent, verdict);
  return ExitCodeOf(judged.verdict);
}

}  // namespace skywave
