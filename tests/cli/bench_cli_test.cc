// Tests skywave bench from the outside: the suite, its files, and that wrong pictures get no score.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "base/error.h"
#include "tests/support/paths.h"
#include "tests/support/program.h"
#include "tests/support/xml.h"
#include "wavefront/rays/trace.h"

namespace skywave {
namespace {

using Json = nlohmann::json;

bool Contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

std::size_t Count(const std::string& text, const std::string& part) {
  std::size_t count = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) {
    ++count;
  }
  return count;
}

// If a browser is installed, the page must be complete in it without any network access.
void ExpectWholeInABrowser(const std::string& folder, const std::string& name) {
  if (std::system("command -v chromium >/dev/null") != 0) {
    std::puts("skipped: there is no chromium");
    return;
  }
  const std::string browser =
      "cd '" + folder +
      "' && timeout 60 chromium --headless --no-sandbox --disable-gpu --user-data-dir=profile "
      "--host-resolver-rules='MAP * ~NOTFOUND' --dump-dom 'file://" +
      folder + "/" + name + "' >dom 2>said </dev/null";
  ASSERT_EQ(std::system(browser.c_str()), 0) << ReadFile(folder + "/said");
  const std::string page = ReadFile(folder + "/" + name), dom = ReadFile(folder + "/dom");
  EXPECT_EQ(Count(dom, "<svg"), Count(page, "<svg"));
  EXPECT_EQ(Count(dom, "</svg>"), Count(page, "</svg>"));
  EXPECT_EQ(Count(dom, "<tr"), Count(page, "<tr"));
  EXPECT_TRUE(Contains(dom, "SUMMARY"));
}

using Bench = Program;

TEST_F(Bench, HelpNamesTheSceneFilesThatItTakes) {
  const std::string help = Run("bench --help").out;
  for (const char* const format : {".pbrt", ".obj", ".gltf", ".glb", ".ply"}) {
    EXPECT_TRUE(Contains(help, format)) << format;
  }
}

TEST_F(Bench, SuiteWritesFiguresThatAgreeAndAPageThatNeedsNothingElse) {
  const Result result = Run("bench --repetitions 1 --threads 2 --json a.json");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const Json json = Json::parse(Bytes("a.json"));
  EXPECT_EQ(json.at("schema"), "skywave-bench-suite-2");
  EXPECT_EQ(json.at("suite"), "quick");
  for (const char* const key : {"processor", "compiler", "revision", "instructions", "libraries"}) {
    EXPECT_TRUE(json.at("machine").contains(key)) << key;
  }
  ASSERT_EQ(json.at("scenes").size(), 3u);
  double logs = 0;
  for (const Json& scene : json.at("scenes")) {
    SCOPED_TRACE(scene.at("name").get<std::string>());
    EXPECT_NE(scene.at("picture").at("check"), "wrong");
    const Json& times = scene.at("repetitions").at("render");
    ASSERT_EQ(times.size(), 1u);
    const double seconds = times.at(0);
    EXPECT_NEAR(scene.at("seconds").at("render").get<double>(), seconds, 1e-9);
    const double samples = scene.at("samples");
    EXPECT_EQ(samples, scene.at("width").get<double>() * scene.at("height").get<double>() *
                           scene.at("samples_per_pixel").get<double>());
    EXPECT_NEAR(scene.at("msamples_per_s").get<double>(), samples / seconds * 1e-6, 1e-9);
    logs += std::log(scene.at("msamples_per_s").get<double>()) / 3;
    double share = 0;
    for (const auto& [name, stage] : scene.at("stages").items()) {
      share += stage.at("share").get<double>();
      const double of_one = scene.at("repetitions").at("stages").at(name).at(0);
      EXPECT_NEAR(stage.at("ns_per_sample").get<double>(), of_one * 1e9 / samples, 1e-6) << name;
    }
    EXPECT_NEAR(share, 1, 1e-9);
    // Sorted rays gain the factor by which they take less time.
    const Json& replay = scene.at("replay");
    for (const char* const order : {"wave", "frame"}) {
      EXPECT_NEAR(replay.at(order).at("gain").get<double>() *
                      replay.at(order).at("best_seconds").get<double>(),
                  replay.at("traced").at("best_seconds").get<double>(), 1e-9)
          << order;
    }
    for (const Backend call : kBackends) {
      const Json& replays = scene.at("replay").at("traced").at("seconds").at(ToString(call));
      for (const char* const kind : {"camera", "bounce", "shadow"}) {
        EXPECT_EQ(replays.at(kind).size(), 1u);
      }
    }
    double mrays = 0;
    for (const Json& kind : scene.at("rays")) {
      mrays += kind.at("mrays_per_s").get<double>();
      EXPECT_GT(kind.at("traced_mrays_per_s").get<double>(), kind.at("mrays_per_s").get<double>());
      EXPECT_GT(kind.at("raw_mrays_per_s").get<double>(), 0);
    }
    EXPECT_NEAR(mrays, scene.at("mrays_per_s").get<double>(), 1e-9);
    EXPECT_EQ(scene.at("lanes").at("generate").at("active"), samples);
    EXPECT_EQ(scene.at("lanes").at("shadow").at("active"),
              scene.at("rays").at("shadow").at("count"));
    EXPECT_GT(scene.at("replay").at("frame").at("gain").get<double>(), 0);
    EXPECT_EQ(scene.at("scaling").size(), 2u);
    EXPECT_EQ(scene.at("bounces").at(0).at("rows"), samples);
    EXPECT_EQ(scene.at("load_average").size(), 2u);
    EXPECT_TRUE(scene.at("tables").contains("importance"));
  }
  const Json& summary = json.at("summary");
  EXPECT_NEAR(std::log(summary.at("msamples_per_s").get<double>()), logs, 1e-9);
  for (const char* const key : {"mrays_per_s", "embree_fraction", "scaling_2"}) {
    EXPECT_GT(summary.at(key).get<double>(), 0) << key;
    EXPECT_TRUE(Contains(result.out, std::string(" ") + key + "=")) << result.out;
  }

  const Result again =
      Run("bench --renders-only --repetitions 1 --report r.html --history a.json --json b.json");
  ASSERT_EQ(again.exit_code, 0) << again.err;
  EXPECT_FALSE(Contains(again.out, "nan")) << again.out;
  EXPECT_FALSE(Contains(again.out, "embree_fraction=")) << again.out;
  EXPECT_TRUE(Contains(again.out, "not measured: embree_fraction, scaling_2 (--renders-only)"))
      << again.out;
  const Json renders = Json::parse(Bytes("b.json"));
  EXPECT_TRUE(renders.at("summary").at("embree_fraction").is_null());
  EXPECT_TRUE(renders.at("scenes").at(0).at("tables").is_null());
  const std::string page = Bytes("r.html");
  for (const char* const part : {"<svg", "a.json", "this run", "light sample", "SUMMARY"}) {
    EXPECT_TRUE(Contains(page, part)) << part;
  }
  for (const char* const outside : {"src=", "href=", "url(", "<script"}) {
    EXPECT_FALSE(Contains(page, outside)) << outside;
  }
  for (std::size_t at = page.find("<svg"); at != std::string::npos;
       at = page.find("<svg", at + 1)) {
    EXPECT_TRUE(IsWellFormedXml(page.substr(at, page.find("</svg>", at) + 6 - at)));
  }
  ExpectWholeInABrowser(Path(""), "r.html");
}

TEST_F(Bench, NoScoreForAWrongPicture) {
  const Result result =
      Run("bench --seed 1 --repetitions 1 --renders-only --json a.json --report r.html");
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_FALSE(Contains(result.out, "SUMMARY")) << result.out;
  EXPECT_EQ(result.out, "");
  EXPECT_TRUE(Contains(result.err, "gallery: not the picture")) << result.err;
  EXPECT_EQ(Files(), std::set<std::string>());
}

// The counters with other threads and calls into Embree must equal the committed ones, which the
// gate compares.
TEST_F(Bench, CountersAreTheSameTextForThreadsAndBackends) {
  if (!__builtin_cpu_supports("avx2")) GTEST_SKIP() << "the committed counters are of AVX2";
  const bool intel = __builtin_cpu_is("intel");
  if (!intel && !__builtin_cpu_is("amd")) GTEST_SKIP() << "no counters of this vendor's processors";
  const std::string committed = SourcePath(intel ? "tests/baselines/bench_counters_intel.txt"
                                                 : "tests/baselines/bench_counters_amd.txt");
  if (!std::filesystem::exists(committed)) GTEST_SKIP() << "there is no " << committed << " yet";
  const Result one = Run("bench --counters --threads 2 --backend single");
  EXPECT_EQ(one.exit_code, 0) << one.err;
  EXPECT_EQ(one.out, ReadFile(committed));
  for (const char* const part : {"gallery rays shadow ", "many-shapes bounce 1 rows ",
                                 "spheres table_bytes importance ", "bytes_per_path "}) {
    EXPECT_TRUE(Contains(one.out, part)) << part;
  }
}

// A run sees the file of its own vendor only, so a new strategy could be missing in the other.
TEST(BenchCounters, FilesOfBothVendorsHaveTheTablesOfTheSameStrategies) {
  const auto tables = [](const std::string& vendor) {
    std::istringstream lines(
        ReadFile(SourcePath("tests/baselines/bench_counters_" + vendor + ".txt")));
    std::vector<std::string> found;
    for (std::string line; std::getline(lines, line);) {
      if (Contains(line, " table_bytes ")) found.push_back(line);
    }
    return found;
  };
  EXPECT_FALSE(tables("intel").empty());
  EXPECT_EQ(tables("intel"), tables("amd"));
}

// Bencher takes standard output, so nothing else may be there.
TEST_F(Bench, ExportsReplaceTheTextOnStandardOutput) {
  const std::string scene = "bench spheres --size 32x24 --spp 1 ";
  const Result bmf = Run(scene + "--repetitions 2 --export bmf --json a.json");
  ASSERT_EQ(bmf.exit_code, 0) << bmf.err;
  const Json measures = Json::parse(bmf.out).at("spheres");
  const Json kept = Json::parse(Bytes("a.json"));
  double sum = 0;
  for (const Json& seconds : kept.at("render_seconds")) sum += seconds.get<double>();
  EXPECT_NEAR(measures.at("latency").at("value").get<double>(), sum / 2 * 1e9, 1);
  const Result google = Run(scene + "--repetitions 3 --export google");
  ASSERT_EQ(google.exit_code, 0) << google.err;
  const Json runs = Json::parse(google.out).at("benchmarks");
  EXPECT_EQ(runs.size(), 3u + 4u);
  EXPECT_EQ(runs.at(0).at("name"), "spheres");
  EXPECT_GT(runs.at(0).at("cpu_time").get<double>(), 0);
}

TEST_F(Bench, RepeatsUntilTimesAgreeAndSaysWhenTheyDoNot) {
  const std::string scene = "bench spheres --size 32x24 --spp 1 --json a.json ";
  const auto repetitions = [&] { return Json::parse(Bytes("a.json")).at("render_seconds").size(); };
  // Times of less than a millisecond never agree to a millionth. Two values deviate by 141 % at
  // most.
  const Result never = Run(scene + "--repetitions 2 --deviation 0.0001");
  EXPECT_EQ(repetitions(), 8u);
  EXPECT_TRUE(Contains(never.err, "the times of 8 renders deviate by")) << never.err;
  EXPECT_FALSE(Json::parse(Bytes("a.json")).at("deviation").at("reached"));
  const Result soon = Run(scene + "--repetitions 2 --deviation 200");
  EXPECT_EQ(repetitions(), 2u);
  EXPECT_FALSE(Contains(soon.err, "deviate")) << soon.err;
  Run(scene + "--repetitions 3");
  EXPECT_EQ(repetitions(), 3u) << "a number of repetitions is that number";
  Run(scene);
  EXPECT_EQ(Json::parse(Bytes("a.json")).at("deviation").at("limit"), 0.025);
}

TEST_F(Bench, SustainRendersForTheTimeAndKeepsEveryRound) {
  const Result result = Run("bench spheres --size 32x24 --spp 1 --sustain 0.5 --json s.json");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_TRUE(Contains(result.out, "SUSTAIN seconds=")) << result.out;
  const Json json = Json::parse(Bytes("s.json"));
  EXPECT_EQ(json.at("schema"), "skywave-bench-sustain-1");
  EXPECT_GE(json.at("seconds").get<double>(), 0.5);
  double last = -1;
  for (const Json& round : json.at("rounds")) {
    EXPECT_GT(round.at("start").get<double>(), last);
    EXPECT_GT(round.at("msamples_per_s").get<double>(), 0);
    last = round.at("start");
  }
  EXPECT_LT(last, 0.5);
  // Means of rounds lie between them, in the units of the rounds; the last line has the same.
  double least = json.at("rounds").at(0).at("msamples_per_s"), most = least;
  for (const Json& round : json.at("rounds")) {
    least = std::min(least, round.at("msamples_per_s").get<double>());
    most = std::max(most, round.at("msamples_per_s").get<double>());
  }
  const double ends[] = {json.at("first_msamples_per_s"), json.at("last_msamples_per_s")};
  for (const double end : ends) {
    EXPECT_GE(end, least * (1 - 1e-9));
    EXPECT_LE(end, most * (1 + 1e-9));
  }
  const std::size_t summary = result.out.find("SUSTAIN");
  double seconds = 0, first = 0, final = 0, ratio = 0;
  ASSERT_EQ(std::sscanf(result.out.c_str() + summary,
                        "SUSTAIN seconds=%lf first_msamples_per_s=%lf last_msamples_per_s=%lf "
                        "ratio=%lf",
                        &seconds, &first, &final, &ratio),
            4)
      << result.out;
  EXPECT_NEAR(first, ends[0], 0.0006);
  EXPECT_NEAR(final, ends[1], 0.0006);
  EXPECT_NEAR(ratio, json.at("last_to_first").at("ratio").get<double>(), 0.00006);
  const Json& interval = json.at("last_to_first").at("interval");
  EXPECT_LE(interval.at(0), json.at("last_to_first").at("ratio"));
}

TEST_F(Bench, CopiesAddUp) {
  const Result result =
      Run("bench spheres --size 32x24 --spp 1 --copies 3 --repetitions 2 --json c.json");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const Json json = Json::parse(Bytes("c.json"));
  EXPECT_EQ(json.at("schema"), "skywave-bench-copies-1");
  ASSERT_EQ(json.at("copies").size(), 3u);
  double sum = 0;
  for (const Json& copy : json.at("copies")) {
    sum += copy.at("msamples_per_s").get<double>();
    EXPECT_EQ(copy.at("scenes").at(0).at("render").size(), 2u);
  }
  EXPECT_NEAR(json.at("summary").at("msamples_per_s").get<double>(), sum, 1e-9);
  EXPECT_FALSE(json.at("rotate").get<bool>());
  const Result scene = Run("bench spheres --size 32x24 --spp 1 --copies 3 --rotate");
  EXPECT_EQ(scene.exit_code, kExitUsage);
  EXPECT_TRUE(Contains(scene.err, "--rotate: belongs to the suite")) << scene.err;
  const Result failed = Run("bench nosuch.pbrt --copies 2 --json d.json");
  EXPECT_EQ(failed.exit_code, kExitBadInput);
  EXPECT_TRUE(Contains(failed.err, "nosuch.pbrt")) << failed.err;
  EXPECT_EQ(Files(), std::set<std::string>{"c.json"});
}

// Returns a result of two scenes whose times are `factor` times some others.
std::string SuiteResultText(double factor, const std::string& suite = "quick") {
  Json json = {{"schema", "skywave-bench-suite-2"},
               {"version", "1"},
               {"suite", suite},
               {"settings", {{"threads", 2}}},
               {"scenes", Json::array()}};
  for (const char* const name : {"one", "two"}) {
    json["scenes"].push_back(
        {{"name", name},
         {"picture", {{"expected", "12"}}},
         {"samples", 100},
         {"rays", {{"camera", {{"count", 100}}}}},
         {"repetitions", {{"render", {factor, factor * 1.01, factor * 0.99}}}}});
  }
  return json.dump(2);
}

TEST_F(Bench, ComparesFilesAndEndsWithOneWhereTheSecondIsSlower) {
  Put("a.json", SuiteResultText(1));
  Put("b.json", SuiteResultText(1.2));
  Put("full.json", SuiteResultText(1, "full"));
  const Result slower = Run("bench --compare a.json b.json");
  EXPECT_EQ(slower.exit_code, 1) << slower.err;
  EXPECT_TRUE(Contains(slower.out, "result=slower: all, one, two\n")) << slower.out;
  EXPECT_TRUE(Contains(slower.out, "COMPARE ratio=1.2000")) << slower.out;
  const Result faster = Run("bench --compare b.json a.json");
  EXPECT_EQ(faster.exit_code, 0) << faster.err;
  EXPECT_TRUE(Contains(faster.out, "result=faster\n")) << faster.out;
  EXPECT_EQ(Run("bench --compare a.json b.json --threshold 25").exit_code, 0);
  const Result pairs = Run("bench --compare a.json b.json a.json b.json");
  EXPECT_EQ(pairs.exit_code, 1) << pairs.err;
  EXPECT_TRUE(Contains(pairs.out, "pairs=2 ")) << pairs.out;
  Json doubted = Json::parse(SuiteResultText(1.2));
  doubted["scenes"][1]["deviation"] = {{"relative", 0.07}, {"limit", 0.025}, {"reached", false}};
  Put("doubted.json", doubted.dump());
  const Result unclear = Run("bench --compare a.json doubted.json");
  EXPECT_EQ(unclear.exit_code, 2) << unclear.err;
  EXPECT_TRUE(Contains(unclear.out, "doubt: doubted.json: two: the times of 3 renders deviate"))
      << unclear.out;
  EXPECT_TRUE(Contains(unclear.out, "result=cannot tell\n")) << unclear.out;
  const Result other = Run("bench --compare a.json full.json");
  EXPECT_EQ(other.exit_code, kExitBadInput);
  EXPECT_TRUE(Contains(other.err, "full.json: is a result of another measurement")) << other.err;
}

TEST_F(Bench, ABaselineHoldsCountersInstructionsAndTime) {
  // Valgrind takes seconds for the maps and meshes of built-in scenes.
  Put("s.pbrt",
      "WorldBegin\nLightSource \"infinite\" \"rgb L\" [1 1 1]\n"
      "Shape \"trianglemesh\" \"integer indices\" [0 1 2]\n"
      "  \"point P\" [-1 -1 3 1 -1 3 0 1 3]\nWorldEnd\n");
  const std::string command =
      "bench s.pbrt --size 32x24 --spp 1 --repetitions 5 --baseline b.json ";
  EXPECT_EQ(Run(command).exit_code, kExitIo);
  const Result made = Run(command + "--update-baseline first");
  ASSERT_EQ(made.exit_code, 0) << made.err;
  // Times of such a picture scatter, so they are not asked.
  const Result same = Run(command + "--gates counters");
  EXPECT_EQ(same.exit_code, 0) << same.out << same.err;
  EXPECT_TRUE(Contains(same.out, "BASELINE counters=")) << same.out;
  const Json baseline = Json::parse(Bytes("b.json"));
  const auto expect = [&](Json changed, const std::string& gates, int code,
                          const std::string& part) {
    Put("b.json", changed.dump());
    const Result result = Run(command + "--gates " + gates);
    EXPECT_EQ(result.exit_code, code) << result.out << result.err;
    EXPECT_TRUE(Contains(result.out + result.err, part)) << result.out << result.err;
  };
  if (__builtin_cpu_supports("avx2")) {
    Json changed = baseline;
    changed["counters"]["rays camera"] = "1";
    expect(changed, "counters,time", 1, ", was 1\n");
    changed = baseline;
    if (baseline.at("instructions").empty()) {
      std::puts("skipped: no instructions were counted; is there a valgrind?");
    } else {
      changed["instructions"]["film"] = 10;
      expect(changed, "instructions", 2, "film: ");
    }
  }
  Json changed = baseline;
  // Where other programs run, the gate says so and gives no verdict.
  const auto expect_time = [&](const std::vector<double>& before, int code,
                               const std::string& verdict) {
    changed["render_seconds"] = before;
    changed["doubts"] = Json::array();
    Put("b.json", changed.dump());
    const Result result = Run(command + "--gates time");
    const bool unclear = Contains(result.out, "time: unclear: ");
    EXPECT_EQ(result.exit_code, unclear ? 0 : code) << result.out << result.err;
    EXPECT_TRUE(Contains(result.out, unclear ? "time=unclear" : verdict)) << result.out;
    EXPECT_TRUE(unclear || code == 0 || Contains(result.err, "measured once more")) << result.err;
  };
  expect_time({1e-9, 1.1e-9, 1.2e-9}, 3, "time=FAILED");
  expect_time({1e6, 1.1e6, 1.2e6}, 0, "time=passed");
  changed["doubts"] = {"its threads waited"};
  expect(changed, "time", 0, "the baseline's times are doubtful: its threads waited");
  changed = baseline;
  changed["options"]["spp"] = "--spp 2";
  expect(changed, "counters", kExitBadInput,
         "b.json: /options: is the baseline of another picture");
  // A reason is added to those that are there; a broken file is not written over.
  Put("b.json", baseline.dump());
  EXPECT_EQ(Run(command + "--update-baseline 'it gained' --gates time").exit_code, 0);
  EXPECT_EQ(Json::parse(Bytes("b.json")).at("reasons"), (Json{"first", "it gained"}));
  EXPECT_TRUE(Json::parse(Bytes("b.json")).at("instructions").empty());
  Put("b.json", "{");
  EXPECT_EQ(Run(command + "--update-baseline again").exit_code, kExitBadInput);
  EXPECT_EQ(Bytes("b.json"), "{");
}

TEST_F(Bench, TheExampleOfAGuardGoesThroughAFolder) {
  const auto guard = [&](const std::string& arguments) {
    return Shell("SKYWAVE='" + ProgramPath() + "' '" + SourcePath("examples/guard.sh") + "' " +
                 arguments);
  };
  EXPECT_EQ(guard("scenes --gates counters").exit_code, kExitUsage);
  std::filesystem::create_directories(Path("scenes"));
  for (const char* const name : {"one", "two"}) {
    Put(std::string("scenes/") + name + ".pbrt",
        "WorldBegin\nLightSource \"infinite\" \"rgb L\" [1 1 1]\n"
        "Shape \"trianglemesh\" \"integer indices\" [0 1 2]\n"
        "  \"point P\" [-1 -1 3 1 -1 3 0 1 3]\nWorldEnd\n");
    Put(std::string("scenes/") + name + ".options", "--size 32x24\n--spp 1\n");
    const Result made = Run(std::string("bench scenes/") + name +
                            ".pbrt --size 32x24 --spp 1 --gates time --repetitions 1 --baseline "
                            "scenes/" +
                            name + ".baseline.json --update-baseline first");
    ASSERT_EQ(made.exit_code, 0) << made.err;
  }
  const Result same = guard("scenes --gates counters");
  EXPECT_EQ(same.exit_code, 0) << same.out << same.err;
  EXPECT_EQ(Count(same.out, "BASELINE counters="), 2u) << same.out;
  Put("scenes/one.options", "--size 32x24 --spp 1 --env-rotate 3\n");
  EXPECT_EQ(guard("scenes --gates counters").exit_code, kExitBadInput);
  if (!__builtin_cpu_supports("avx2")) return;
  Put("scenes/one.options", "--size 32x24 --spp 1\n");
  std::string scene = Bytes("scenes/one.pbrt");
  scene.replace(scene.find("[-1 -1 3"), 8, "[-9 -1 3");
  Put("scenes/one.pbrt", scene);
  const Result other = guard("scenes --gates counters");
  EXPECT_EQ(other.exit_code, 1) << other.out << other.err;
  EXPECT_EQ(Count(other.out, "BASELINE counters=passed"), 1u) << "it goes on: " << other.out;
}

struct BadCase {
  std::string arguments;
  int exit_code;
  std::vector<std::string> message;  // expected parts of the message
};

TEST_F(Bench, BadInputIsReportedAndLeavesNoFile) {
  Put("other.json", "{\"schema\": \"skywave-bench-1\"}");
  Put("no.json", "frob");
  const std::set<std::string> before = Files();
  const BadCase cases[] = {
      {"bench --spp 4", kExitUsage, {"--spp", "give a scene"}},
      {"bench --size 8x8", kExitUsage, {"--size"}},
      {"bench spheres --full", kExitUsage, {"--full", "suite"}},
      {"bench spheres --report r.html", kExitUsage, {"--report"}},
      {"bench --history other.json", kExitUsage, {"--report"}},
      {"bench --report r.html --history other.json", kExitBadInput, {"other.json", "schema"}},
      {"bench --report r.html --history no.json", kExitBadInput, {"no.json"}},
      {"bench --report r.html --history missing.json", kExitIo, {"missing.json"}},
      {"bench --json missing/a.json", kExitIo, {"missing/a.json"}},
      {"bench --repetitions 0", kExitUsage, {"--repetitions"}},
      {"bench nosuch.pbrt", kExitBadInput, {"nosuch.pbrt"}},
      {"bench --compare other.json", kExitUsage, {"--compare", "pairs"}},
      {"bench --compare other.json no.json", kExitBadInput, {"other.json", "not skywave-bench-1"}},
      {"bench --compare no.json other.json", kExitBadInput, {"no.json:1"}},
      {"bench --compare missing.json no.json", kExitIo, {"missing.json"}},
      {"bench spheres --threshold 3 --compare no.json no.json", kExitUsage, {"renders nothing"}},
      {"bench --threshold 3", kExitUsage, {"--threshold", "another measurement"}},
      {"bench --sustain 1 --repetitions 3", kExitUsage, {"--repetitions", "--sustain"}},
      {"bench --copies 2 --threads 2", kExitUsage, {"--threads", "one thread"}},
      {"bench --baseline other.json", kExitUsage, {"--baseline", "scene"}},
      {"bench spheres --baseline other.json", kExitBadInput, {"other.json", "baseline"}},
      {"bench spheres --update-baseline why", kExitUsage, {"--baseline"}},
      {"bench spheres --baseline new.json --update-baseline ''", kExitUsage, {"needs a reason"}},
      {"bench spheres --instructions --json a.json", kExitUsage, {"--json", "--instructions"}},
      {"bench --export csv", kExitUsage, {"bmf|google"}},
  };
  for (const BadCase& test : cases) {
    SCOPED_TRACE(test.arguments);
    const Result result = Run(test.arguments);
    EXPECT_EQ(result.exit_code, test.exit_code) << result.err;
    for (const std::string& part : test.message) {
      EXPECT_TRUE(Contains(result.err, part)) << "no \"" << part << "\" in: " << result.err;
    }
    EXPECT_EQ(result.out, "");
    EXPECT_EQ(Files(), before);
  }
}

}  // namespace
}  // namespace skywave
