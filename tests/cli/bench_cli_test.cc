// Tests skywave bench from the outside: the suite, its files, and that wrong pictures get no score.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
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
    for (const Json& stage : scene.at("stages")) share += stage.at("share").get<double>();
    EXPECT_NEAR(share, 1, 1e-9);
    for (const Backend call : kBackends) {
      const Json& seconds = scene.at("replay").at("traced").at("seconds").at(ToString(call));
      for (const char* const kind : {"camera", "bounce", "shadow"}) {
        EXPECT_EQ(seconds.at(kind).size(), 1u);
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
  const Result one = Run("bench --counters --threads 2 --backend single");
  EXPECT_EQ(one.exit_code, 0) << one.err;
  EXPECT_EQ(one.out, ReadFile(SourcePath("tests/baselines/bench_counters.txt")));
  for (const char* const part : {"gallery rays shadow ", "many-shapes bounce 1 rows ",
                                 "spheres table_bytes importance ", "bytes_per_path "}) {
    EXPECT_TRUE(Contains(one.out, part)) << part;
  }
}

struct BadCase {
  std::string arguments;
  int exit_code;
  std::vector<std::string> message;  // expected parts of the message
};

TEST_F(Bench, BadInputIsToldClearlyAndLeavesNoFile) {
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
