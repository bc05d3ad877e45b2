// Tests how results of skywave bench are read back, compared, exported and held to a baseline: with
// made-up times, so that no clock decides.
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "bench/measure/baseline.h"
#include "bench/measure/bench_compare.h"
#include "bench/measure/bench_export.h"
#include "bench/measure/json_input.h"
#include "bench/measure/statistics.h"
#include "tests/support/temporary_folder.h"

namespace skywave {
namespace {

using Json = nlohmann::json;
using Values = std::vector<double>;

BenchRecord Record(const std::string& file, const std::vector<Values>& times) {
  BenchRecord record = {.file = file, .subject = "quick suite", .version = "1"};
  record.settings = {{"threads", "2"}, {"embree_config", "isa=avx2"}};
  record.threads = 2;
  for (const Values& render : times) {
    record.scenes.push_back({.name = "scene " + std::to_string(record.scenes.size()),
                             .picture = "abc",
                             .samples = 1e6,
                             .rays = 3e6,
                             .render = render,
                             .processor = {}});
  }
  return record;
}

std::string Failure(const std::vector<BenchRecord>& records) {
  try {
    CompareRecords(records);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(BenchCompare, FindsOnlyWhatIsSlower) {
  const Values base = {1.00, 1.02, 0.99, 1.01}, slow = {1.20, 1.22, 1.21, 1.19};
  const auto compared = [&](const Values& other) {
    const std::vector<BenchRecord> records = {Record("a", {base, base}),
                                              Record("b", {base, other})};
    return CompareRecords(records).ratios;
  };
  const std::vector<SpeedRatio> slower = compared(slow);
  ASSERT_EQ(slower.size(), 3u);
  EXPECT_EQ(slower[0].name, kWholeSuite);
  EXPECT_NEAR(slower[0].ratio.value, std::sqrt(slower[2].ratio.value), 1e-12);
  EXPECT_FALSE(slower[1].slower(0.05));
  EXPECT_TRUE(slower[2].slower(0.05));
  EXPECT_FALSE(slower[2].slower(0.25));
  for (const SpeedRatio& ratio : compared(base)) {
    EXPECT_FALSE(ratio.slower(0) || ratio.faster(0)) << ratio.name;
  }
  EXPECT_TRUE(compared({0.8, 0.81, 0.79})[2].faster(0.05));
  // All repetitions but one were disturbed: the interval alone would call that slower.
  const SpeedRatio disturbed = compared({1.0, 1.5, 1.5, 1.5, 1.5, 1.5, 1.5, 1.5})[2];
  EXPECT_GT(disturbed.ratio.interval.low, 1.05);
  EXPECT_FALSE(disturbed.slower(0.05));
}

// The runs of each pair were slow or fast together, by a factor of two; B takes 1.1 times as long.
TEST(BenchCompare, PairsCancelWhatBothRunsShare) {
  std::vector<BenchRecord> records;
  for (const double machine : {1.0, 2.0, 1.4, 1.1}) {
    records.push_back(Record("a", {{machine, machine * 1.01}}));
    records.push_back(Record("b", {{machine * 1.1, machine * 1.11}}));
  }
  const BenchComparison comparison = CompareRecords(records);
  EXPECT_EQ(comparison.pairs, 4u);
  ASSERT_EQ(comparison.ratios.size(), 1u);
  EXPECT_NEAR(comparison.ratios[0].ratio.value, 1.1, 0.01);
  EXPECT_TRUE(comparison.ratios[0].slower(0.05));
  const std::vector<BenchRecord> unpaired = {Record("a", {{1, 2, 1.4, 1.1}}),
                                             Record("b", {{1.1, 2.2, 1.54, 1.21}})};
  EXPECT_FALSE(CompareRecords(unpaired).ratios[0].slower(0.05));
}

// Times that are doubted look slower or faster for other reasons; those of pairs have that in their
// interval.
TEST(BenchCompare, DoubtedTimesOfTwoRunsTellNothing) {
  const Values base = {1.00, 1.02, 0.99, 1.01}, slow = {1.20, 1.22, 1.21, 1.19};
  const auto judge = [&](const std::vector<BenchRecord>& records) {
    return Judge(CompareRecords(records), 0.05);
  };
  const BenchRecord a = Record("a", {base}), b = Record("b", {slow});
  EXPECT_EQ(judge({a, b}).verdict, SpeedVerdict::kSlower);
  EXPECT_EQ(judge({a, b}).names, std::vector<std::string>{"scene 0"});
  EXPECT_EQ(judge({b, a}).verdict, SpeedVerdict::kFaster);
  EXPECT_EQ(judge({a, a}).verdict, SpeedVerdict::kPassed);
  BenchRecord doubted = b;
  doubted.scenes[0].doubts = {"the machine was busy"};
  for (const std::vector<BenchRecord>& records :
       {std::vector{a, doubted}, std::vector{doubted, a}, std::vector{doubted, doubted}}) {
    EXPECT_EQ(judge(records).verdict, SpeedVerdict::kCannotTell);
  }
  EXPECT_EQ(CompareRecords(std::vector{a, doubted}).doubts,
            std::vector<std::string>{"b: scene 0: the machine was busy"});
  EXPECT_EQ(judge({a, doubted, a, b}).verdict, SpeedVerdict::kSlower);
}

// A slow-down by the threshold could hide in such an interval; one by more is seen all the same.
TEST(BenchCompare, WideIntervalsTellNothingUnlessAllOfThemIsSlower) {
  const auto judge = [](const Values& a, const Values& b) {
    return Judge(CompareRecords(std::vector{Record("a", {a}), Record("b", {b})}), 0.05);
  };
  const Values wide = {1.0, 1.2, 1.1, 1.05};
  EXPECT_EQ(judge(wide, wide).verdict, SpeedVerdict::kCannotTell);
  EXPECT_EQ(judge(wide, wide).names, std::vector<std::string>{"scene 0"});
  EXPECT_EQ(judge(wide, {2.0, 2.4, 2.2, 2.1}).verdict, SpeedVerdict::kSlower);
  EXPECT_EQ(judge({2.0, 2.4, 2.2, 2.1}, wide).verdict, SpeedVerdict::kFaster);
}

TEST(BenchCompare, DoubtsAreReadFromResults) {
  const auto doubts = [](const Json& measured) {
    Json json = {{"schema", "skywave-bench-2"},
                 {"version", "1"},
                 {"command", "skywave render spheres"},
                 {"threads", 2},
                 {"rays", Json::object()},
                 {"render_seconds", {1.0, 1.1}}};
    json.update(measured);
    return RecordOf(json, "a.json").scenes[0].doubts;
  };
  EXPECT_TRUE(doubts(Json::object()).empty());
  const Json calm = {{"waiting", 0.001}, {"stolen", nullptr}, {"throttled", nullptr}};
  EXPECT_TRUE(doubts({{"conditions", calm}}).empty());
  const Json busy = {{"waiting", 0.25}, {"stolen", 0.02}, {"throttled", 3}};
  EXPECT_EQ(doubts({{"conditions", busy}}).size(), 3u);
  const Json deviation = {{"relative", 0.06}, {"limit", 0.025}, {"reached", false}};
  EXPECT_EQ(doubts({{"deviation", deviation}}),
            std::vector<std::string>{"the times of 2 renders deviate by 6.0 %, more than 2.5 %"});
  const Json unlimited = {{"relative", 0.06}, {"limit", nullptr}, {"reached", true}};
  EXPECT_TRUE(doubts({{"deviation", unlimited}}).empty());
}

TEST(BenchCompare, OtherWorkIsRefusedAndOtherMachinesAreReported) {
  const BenchRecord a = Record("a.json", {{1, 1.1}});
  BenchRecord b = a;
  b.file = "b.json";
  b.settings[0].second = "4";
  EXPECT_EQ(CompareRecords(std::vector{a, b}).notes,
            std::vector<std::string>{"threads: 2 against 4"});
  BenchRecord other = b;
  other.subject = "full suite";
  EXPECT_NE(Failure({a, other}).find("b.json: is a result of another measurement"),
            std::string::npos);
  other = b;
  other.scenes[0].picture = "def";
  EXPECT_NE(Failure({a, other}).find("b.json: /scenes/0: is other work"), std::string::npos);
  other.settings[1].second = "isa=sse2";  // other hits, so other bits
  EXPECT_EQ(Failure({a, other}), "");
  // One machine for the first run of each side, another one for the second run of B.
  BenchRecord later = a;
  later.file = "later.json";
  later.settings[0].second = "8";
  later.version = "2";
  EXPECT_EQ(CompareRecords(std::vector{a, a, a, later}).notes,
            (std::vector<std::string>{"a.json against later.json: version: 1 against 2",
                                      "a.json against later.json: threads: 2 against 8"}));
  EXPECT_EQ(CompareRecords(std::vector{a, b, later, b}).notes.size(), 3u);
  EXPECT_EQ(CompareRecords(std::vector{a, b, a, b}).notes.size(), 1u);
  other = b;
  other.scenes[0].render = {1};
  EXPECT_NE(Failure({a, other}).find("b.json: scene 0: has one repetition"), std::string::npos);
}

// The structure that bencher.dev documents: {benchmark: {measure: {value, lower_value?,
// upper_value?}}}, all of them numbers, the ends around the value.
TEST(BenchExport, BmfHasTheStructureOfItsSchema) {
  const Json bmf = Export(Record("a", {{0.1, 0.11, 0.12}, {2}}), ExportFormat::kBmf);
  ASSERT_EQ(bmf.size(), 3u);
  for (const auto& [benchmark, measures] : bmf.items()) {
    ASSERT_TRUE(measures.is_object() && !measures.empty()) << benchmark;
    for (const auto& [measure, metric] : measures.items()) {
      EXPECT_LE(measure.size(), 64u);
      ASSERT_TRUE(metric.at("value").is_number());
      for (const auto& [key, value] : metric.items()) {
        EXPECT_TRUE(key == "value" || key == "lower_value" || key == "upper_value") << key;
        EXPECT_TRUE(value.is_number());
      }
      EXPECT_EQ(metric.contains("lower_value"), metric.contains("upper_value"));
      if (!metric.contains("lower_value")) continue;
      EXPECT_LT(metric.at("lower_value"), metric.at("value"));
      EXPECT_GT(metric.at("upper_value"), metric.at("value"));
    }
  }
  EXPECT_NEAR(bmf.at("scene 0").at("latency").at("value").get<double>(), 0.11e9, 1);
  EXPECT_NEAR(bmf.at("scene 0").at("throughput").at("value").get<double>(), 1e6 / 0.11, 1e-3);
  EXPECT_FALSE(bmf.at("scene 1").at("latency").contains("lower_value"));
  EXPECT_NEAR(bmf.at("quick suite").at("throughput").at("value").get<double>(),
              std::sqrt(1e6 / 0.11 * 0.5e6), 1e-3);
}

// The members that Google Benchmark's reporter writes, with their types: those of the context, of
// all runs, of repetitions and of aggregates.
TEST(BenchExport, GoogleHasTheMembersOfItsReporter) {
  BenchRecord record = Record("a", {{0.1, 0.12}});
  record.scenes[0].processor = {0.19, 0.21};
  const Json google = Export(record, ExportFormat::kGoogle);
  const auto expect = [](const Json& from, const std::vector<const char*>& texts,
                         const std::vector<const char*>& numbers) {
    for (const char* const key : texts) EXPECT_TRUE(from.at(key).is_string()) << key;
    for (const char* const key : numbers) EXPECT_TRUE(from.at(key).is_number()) << key;
  };
  const Json& context = google.at("context");
  expect(context, {"date", "host_name", "executable", "library_build_type"},
         {"num_cpus", "mhz_per_cpu"});
  EXPECT_TRUE(context.at("cpu_scaling_enabled").is_boolean());
  EXPECT_TRUE(context.at("caches").is_array() && context.at("load_avg").is_array());
  const Json& runs = google.at("benchmarks");
  ASSERT_EQ(runs.size(), 6u);
  for (const Json& run : runs) {
    expect(run, {"name", "run_name", "run_type", "time_unit"},
           {"family_index", "per_family_instance_index", "repetitions", "threads", "iterations",
            "real_time", "cpu_time"});
    const bool aggregate = run.at("run_type") == "aggregate";
    if (aggregate) expect(run, {"aggregate_name", "aggregate_unit"}, {});
    if (!aggregate) expect(run, {}, {"repetition_index"});
    EXPECT_EQ(run.at("name"),
              run.at("run_name").get<std::string>() +
                  (aggregate ? "_" + run.at("aggregate_name").get<std::string>() : ""));
  }
  EXPECT_DOUBLE_EQ(runs[1].at("real_time").get<double>(), 120);
  EXPECT_DOUBLE_EQ(runs[1].at("cpu_time").get<double>(), 210);
  EXPECT_EQ(runs[2].at("aggregate_name"), "mean");
  EXPECT_NEAR(runs[2].at("real_time").get<double>(), 110, 1e-9);
  EXPECT_EQ(runs[5].at("aggregate_unit"), "percentage");
  EXPECT_NEAR(runs[5].at("real_time").get<double>(), std::sqrt(0.0002) / 0.11, 1e-12);
}

// The format: valgrind.org/docs/manual/cl-format.html.
TEST(Instructions, AreThoseOfTheInnermostStageAndNotOfOtherLibraries) {
  constexpr std::string_view kProfile = R"(# callgrind format
version: 1
cmd: /bin/skywave render
positions: line
events: Ir
summary: 999999

ob=(1) /bin/skywave
fl=(1) trace.cc
fn=(1) skywave::TraceClosest(skywave::Frame const&)'skywave::RenderPathWave(int)'main
0 100
fi=(2) vector
0 20
cob=(2) /usr/lib/libembree3.so.3
cfn=(2) 0x00001'skywave::TraceClosest(skywave::Frame const&)'skywave::RenderPathWave(int)'main
calls=7 0
0 70000
cob=(3) /lib/libc.so.6
cfn=(3) memcpy'skywave::TraceClosest(skywave::Frame const&)'skywave::RenderPathWave(int)'main
calls=1 0
0 900

ob=(2)
fn=(2)
0 70000
ob=(3)
fn=(3)
0 900

ob=(1)
fn=(4) skywave::N_AVX2::Kernel()'skywave::Scatter(int)'skywave::(anonymous namespace)::RenderPhotonWave()'main
+3 8
* 30
fn=(5) skywave::Scatter(int)'skywave::ConnectLights(int)'main
-2 5
fn=(6) skywave::Scattered(int)'main
0 1000
fn=(1)
3 1
totals: 72064
)";
  EXPECT_EQ(StagesOf(kProfile, "/bin/skywave"),
            (StageInstructions{{"intersect", 70121}, {"scatter", 43}, {"wave", 70159}}));
  EXPECT_TRUE(StagesOf("", "/bin/skywave").empty());
}

Baseline SomeBaseline() {
  return {.reasons = {"first"},
          .version = "1",
          .options = {{"spp", "--spp 8"}},
          .hits = "isa=avx2",
          .counters = {{"waves", "12"}, {"rays camera", "9"}},
          .toolchain = "g++",
          .instructions = {{"film", 1000000}, {"wave", 5000000}},
          .machine = {{"processor", "Z80"}},
          .seconds = {1.00, 1.01, 0.99, 1.02},
          .doubts = {}};
}

// Returns the exit code for `now`.
int Judged(const Baseline& now, double threshold = 0.05) {
  return ExitCodeOf(JudgeBaseline(
      SomeBaseline(), now,
      {BaselineGate::kCounters, BaselineGate::kInstructions, BaselineGate::kTime}, threshold, "b"));
}

TEST(BaselineGates, EachFailsByItselfWithItsExitCode) {
  EXPECT_EQ(Judged(SomeBaseline()), 0);
  Baseline now = SomeBaseline();
  now.counters[1].second = "10";
  EXPECT_EQ(Judged(now), 1);
  now = SomeBaseline();
  now.counters.push_back({"new", "1"});
  EXPECT_EQ(Judged(now), 1);
  now = SomeBaseline();
  now.instructions[0].second = 1005001;
  EXPECT_EQ(Judged(now), 2);
  now.instructions[0].second = 994999;  // a gain has to be written down to be kept
  EXPECT_EQ(Judged(now), 2);
  now.instructions[0].second = 1004999;
  EXPECT_EQ(Judged(now), 0);
  now.instructions.emplace_back("sky", 10);  // the baseline does not know this stage
  EXPECT_EQ(Judged(now), 2);
  now = SomeBaseline();
  now.instructions.pop_back();
  EXPECT_EQ(Judged(now), 2);
  now = SomeBaseline();
  for (double& seconds : now.seconds) seconds *= 1.1;
  EXPECT_EQ(Judged(now), 3);
  EXPECT_EQ(Judged(now, 0.2), 0);
  now.instructions[0].second *= 2;
  EXPECT_EQ(Judged(now), 2);
}

TEST(BaselineGates, GatesThatCannotCompareAreSkippedWithAReason) {
  Baseline now = SomeBaseline();
  for (double& seconds : now.seconds) seconds *= 2;
  now.machine[0].second = "6502";
  now.toolchain = "clang";
  now.instructions[0].second *= 2;
  now.hits = "isa=sse2";
  now.counters[0].second = "13";
  const std::vector<GateResult> results = JudgeBaseline(
      SomeBaseline(), now,
      {BaselineGate::kCounters, BaselineGate::kInstructions, BaselineGate::kTime}, 0, "b");
  EXPECT_EQ(ExitCodeOf(results), 0);
  const std::vector<std::string> why = {"isa=sse2", "clang", "6502"};
  for (std::size_t i = 0; i < why.size(); ++i) {
    EXPECT_EQ(results[i].verdict, GateResult::kSkipped);
    EXPECT_NE(results[i].summary.find(why[i]), std::string::npos) << results[i].summary;
  }
}

TEST(BaselineGates, TimesThatAreDoubtedOrScatterAreUnclear) {
  const auto judge = [](const Baseline& now) {
    return JudgeBaseline(SomeBaseline(), now, {BaselineGate::kTime}, 0.05, "b").front();
  };
  Baseline now = SomeBaseline();
  for (double& seconds : now.seconds) seconds *= 2;
  EXPECT_EQ(judge(now).verdict, GateResult::kFailed);
  now.doubts = {"the machine was busy"};
  EXPECT_EQ(judge(now).verdict, GateResult::kUnclear);
  EXPECT_EQ(judge(now).summary, "the machine was busy");
  EXPECT_EQ(ExitCodeOf({judge(now)}), 0);
  now = SomeBaseline();
  now.seconds = {0.9, 1.0, 1.2, 1.3};
  EXPECT_EQ(judge(now).verdict, GateResult::kUnclear);
}

// Measuring once more would not help.
TEST(BaselineGates, TimesAreNotHeldToABaselineOfABusyMachine) {
  Baseline busy = SomeBaseline();
  busy.doubts = {"heat slowed cores once"};
  const GateResult result =
      JudgeBaseline(busy, SomeBaseline(), {BaselineGate::kTime}, 0.05, "b").front();
  EXPECT_EQ(result.verdict, GateResult::kSkipped);
  EXPECT_NE(result.summary.find("heat slowed cores once"), std::string::npos) << result.summary;
}

TEST(BaselineGates, WritingAndReadingAFileKeepsEverything) {
  const TemporaryFolder folder;
  Baseline baseline = SomeBaseline();
  baseline.doubts = {"heat slowed cores once"};
  nlohmann::json json = skywave::Json(baseline);
  EXPECT_EQ(nlohmann::json(skywave::Json(ReadBaseline(folder.Write("b.json", json.dump())))), json);
  json.erase("doubts");  // as older files have it
  EXPECT_TRUE(ReadBaseline(folder.Write("b.json", json.dump())).doubts.empty());
}

// Returns what reading a file of `text` fails with; empty: nothing.
std::string ReadFailure(const std::string& text, bool baseline = false) {
  const TemporaryFolder folder;
  const std::string path = folder.Write("r.json", text);
  try {
    baseline ? (void)ReadBaseline(path) : (void)ReadRecord(path);
  } catch (const InputError& error) {
    EXPECT_EQ(error.exit_code(), kExitBadInput);
    return std::string(error.what()).substr(folder.Path("").size());
  }
  return "";
}

TEST(BenchRecords, BadFilesAreReportedWithTheirPlace) {
  const Json good = {{"schema", kSceneSchema},   {"version", "1"},
                     {"command", "c"},           {"threads", 2},
                     {"render_seconds", {1, 2}}, {"rays", {{"camera", {{"count", 5}}}}}};
  EXPECT_EQ(ReadFailure(good.dump()), "");
  EXPECT_EQ(ReadFailure("{\n\"a\": 1,\nfrob"), "r.json:3: is not JSON from here on");
  EXPECT_EQ(ReadFailure("{\"a\": [1,\n"), "r.json:2: ends within JSON");
  EXPECT_EQ(ReadFailure("[1e999]"), "r.json: is JSON with a number that is too large");
  EXPECT_NE(ReadFailure("[]").find("r.json: is not a result of skywave bench"), std::string::npos);
  Json bad = good;
  bad["schema"] = "skywave-bench-1";
  EXPECT_NE(ReadFailure(bad.dump()).find("not skywave-bench-1"), std::string::npos);
  for (const char* const key : {"version", "command", "threads", "render_seconds", "rays"}) {
    bad = good;
    bad.erase(key);
    EXPECT_EQ(ReadFailure(bad.dump()), "r.json: has no key \"" + std::string(key) + "\"");
  }
  bad = good;
  bad["render_seconds"][1] = 0;
  EXPECT_EQ(ReadFailure(bad.dump()), "r.json: /render_seconds/1: is not above 0");
  bad["render_seconds"] = {"1"};
  EXPECT_EQ(ReadFailure(bad.dump()), "r.json: /render_seconds/0: is not a number");
  bad["render_seconds"] = Json::array();
  EXPECT_EQ(ReadFailure(bad.dump()), "r.json: /render_seconds: is empty");
  for (const Json& threads : {Json(1e300), Json(-1), Json(1.5), Json(3e9)}) {
    for (const char* const key : {"threads", "wave"}) {
      bad = good;
      bad[key] = threads;
      EXPECT_EQ(ReadFailure(bad.dump()),
                "r.json: /" + std::string(key) + ": is not a whole number from 0 to 2147483647");
    }
  }
  bad = good;
  bad["rays"]["camera"] = 7;
  EXPECT_EQ(ReadFailure(bad.dump()), "r.json: /rays/camera: is not an object");

  const Json whole = skywave::Json(SomeBaseline());
  for (const auto& [key, value] : whole.items()) {
    if (key == "doubts") continue;
    bad = whole;
    bad.erase(key);
    EXPECT_NE(ReadFailure(bad.dump(), true).find(key), std::string::npos) << key;
  }
  bad = whole;
  for (const Json& count : {Json(-1), Json(0), Json(0.5), Json(1e300)}) {
    bad["instructions"]["film"] = count;
    EXPECT_EQ(ReadFailure(bad.dump(), true),
              "r.json: /instructions/film: is not a whole number from 1 to 9007199254740992");
  }
}

}  // namespace
}  // namespace skywave
