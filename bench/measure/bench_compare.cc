#include "bench/measure/bench_compare.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/error.h"

namespace skywave {
namespace {

constexpr double kNotCompared = std::numeric_limits<double>::quiet_NaN();

[[noreturn]] void FailRecord(const BenchRecord& record, const std::string& reason) {
  throw InputError(InputPosition::File(record.file), reason);
}

// Returns the value of a setting; empty: unknown.
std::string SettingOf(const BenchRecord& record, std::string_view name) {
  for (const auto& [key, value] : record.settings) {
    if (key == name) return value;
  }
  return "";
}

// Pictures are identified by their hashes. Where these are unknown, or Embree was set to find hits
// by other instructions, only the scene's name and the command identify them.
void CheckSameWork(const BenchRecord& first, const BenchRecord& other) {
  if (other.subject != first.subject) {
    FailRecord(other, fmt::format("is a result of another measurement than {}: {}, not {}",
                                  first.file, other.subject, first.subject));
  }
  if (other.scenes.size() != first.scenes.size()) {
    FailRecord(other, fmt::format("/scenes: has {} scenes, {} has {}", other.scenes.size(),
                                  first.file, first.scenes.size()));
  }
  const bool same_hits = SettingOf(first, "embree_config") == SettingOf(other, "embree_config");
  for (std::size_t i = 0; i < first.scenes.size(); ++i) {
    const SceneRecord &a = first.scenes[i], &b = other.scenes[i];
    const auto fail = [&](std::string_view what, const auto& mine, const auto& theirs) {
      FailRecord(other, fmt::format("/scenes/{}: is other work than in {}: {} {}, not {}", i,
                                    first.file, what, mine, theirs));
    };
    if (b.name != a.name) fail("scene", b.name, a.name);
    if (same_hits && !a.picture.empty() && !b.picture.empty() && b.picture != a.picture) {
      fail("picture", b.picture, a.picture);
    }
  }
}

// Compares two files by their repetitions.
std::vector<SpeedRatio> CompareRepetitions(const BenchRecord& a, const BenchRecord& b) {
  std::vector<SpeedRatio> ratios;
  std::vector<std::vector<double>> all_a, all_b;
  for (std::size_t i = 0; i < a.scenes.size(); ++i) {
    for (const BenchRecord* const record : {&a, &b}) {
      if (record->scenes[i].render.size() > 1) continue;
      FailRecord(*record, fmt::format("{}: has one repetition, which gives no interval: take "
                                      "more, or give more pairs of files",
                                      record->scenes[i].name));
    }
    ratios.push_back(
        CompareRuns(a.scenes[i].name, {&a.scenes[i].render, 1}, {&b.scenes[i].render, 1}));
    all_a.push_back(a.scenes[i].render);
    all_b.push_back(b.scenes[i].render);
  }
  if (ratios.size() > 1) {
    ratios.insert(ratios.begin(), CompareRuns(std::string(kWholeSuite), all_a, all_b));
  }
  return ratios;
}

std::vector<SpeedRatio> ComparePairs(std::span<const BenchRecord> records) {
  const std::size_t scenes = records[0].scenes.size(), pairs = records.size() / 2;
  std::vector<SpeedRatio> ratios;
  std::vector<double> whole(pairs, 1);
  for (std::size_t scene = 0; scene < scenes; ++scene) {
    std::vector<double> medians[2], quotients;
    for (std::size_t pair = 0; pair < pairs; ++pair) {
      for (std::size_t side = 0; side < 2; ++side) {
        medians[side].push_back(Median(records[2 * pair + side].scenes[scene].render));
      }
      quotients.push_back(medians[1].back() / medians[0].back());
      whole[pair] *= std::pow(quotients.back(), 1 / double(scenes));
    }
    ratios.push_back({.name = records[0].scenes[scene].name,
                      .a = Median(medians[0]),
                      .b = Median(medians[1]),
                      .ratio = PairedRatio(quotients),
                      .least = kNotCompared});
  }
  if (scenes > 1) {
    ratios.insert(ratios.begin(), {.name = std::string(kWholeSuite),
                                   .a = kNotCompared,
                                   .b = kNotCompared,
                                   .ratio = PairedRatio(whole),
                                   .least = kNotCompared});
  }
  return ratios;
}

std::vector<std::string> Differences(const BenchRecord& a, const BenchRecord& b) {
  std::vector<std::string> notes;
  if (a.version != b.version) {
    notes.push_back(fmt::format("version: {} against {}", a.version, b.version));
  }
  for (const auto& [name, value] : a.settings) {
    const std::string other = SettingOf(b, name);
    if (!other.empty() && other != value) {
      notes.push_back(fmt::format("{}: {} against {}", name, value, other));
    }
  }
  return notes;
}

}  // namespace

SpeedRatio CompareRuns(const std::string& name, std::span<const std::vector<double>> a,
                       std::span<const std::vector<double>> b) {
  const auto least = [](const std::vector<double>& x) {
    return *std::min_element(x.begin(), x.end());
  };
  SpeedRatio ratio = {.name = name,
                      .a = a.size() == 1 ? Median(a[0]) : kNotCompared,
                      .b = b.size() == 1 ? Median(b[0]) : kNotCompared,
                      .ratio = WelchRatio(a, b, kKeptTimes),
                      .least = 1};
  for (std::size_t i = 0; i < a.size(); ++i) {
    ratio.least *= std::pow(least(b[i]) / least(a[i]), 1 / double(a.size()));
  }
  return ratio;
}

BenchComparison CompareRecords(std::span<const BenchRecord> records) {
  for (const BenchRecord& record : records) CheckSameWork(records[0], record);
  std::vector<std::string> notes = Differences(records[0], records[1]);
  // The note above stands for all pairs only if the runs of each side are alike.
  for (std::size_t i = 2; i < records.size(); ++i) {
    const BenchRecord& first = records[i % 2];
    for (const std::string& difference : Differences(first, records[i])) {
      notes.push_back(fmt::format("{} against {}: {}", first.file, records[i].file, difference));
    }
  }
  std::vector<std::string> doubts;
  for (const BenchRecord& record : records) {
    for (const SceneRecord& scene : record.scenes) {
      for (const std::string& doubt : scene.doubts) {
        doubts.push_back(fmt::format("{}: {}: {}", record.file, scene.name, doubt));
      }
    }
  }
  return {.pairs = records.size() / 2,
          .ratios = records.size() == 2 ? CompareRepetitions(records[0], records[1])
                                        : ComparePairs(records),
          .notes = std::move(notes),
          .doubts = std::move(doubts)};
}

JudgedSpeed Judge(const BenchComparison& comparison, double threshold) {
  if (comparison.pairs == 1 && !comparison.doubts.empty()) return {SpeedVerdict::kCannotTell, {}};
  const auto named = [&](SpeedVerdict verdict, const auto& holds) {
    JudgedSpeed judged = {verdict, {}};
    for (const SpeedRatio& ratio : comparison.ratios) {
      if (holds(ratio)) judged.names.push_back(ratio.name);
    }
    return judged;
  };
  const JudgedSpeed slower =
      named(SpeedVerdict::kSlower, [&](const SpeedRatio& r) { return r.slower(threshold); });
  if (!slower.names.empty()) return slower;
  const JudgedSpeed unclear =
      named(SpeedVerdict::kCannotTell, [&](const SpeedRatio& r) { return r.may_hide(threshold); });
  if (!unclear.names.empty()) return unclear;
  const bool faster = comparison.ratios.front().faster(threshold);
  return {faster ? SpeedVerdict::kFaster : SpeedVerdict::kPassed, {}};
}

}  // namespace skywave
