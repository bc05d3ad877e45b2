// Tests skywave converge from the outside: consistent figures, files and messages.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <regex>
#include <string>
#include <vector>

#include "base/error.h"
#include "image/image.h"
#include "tests/support/program.h"
#include "tests/support/xml.h"

namespace skywave {
namespace {

using Json = nlohmann::json;

bool Contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

constexpr char kSmall[] =
    "converge spheres --env sky.pfm --size 32x24 --integrator direct --threads 2 ";

// The map is darker below the horizon and has a bright patch, but no sun whose noise would
// dominate.
Image Sky() {
  Image map(16, 8);
  for (int y = 0; y < 8; ++y) {
    for (int x = 0; x < 16; ++x) {
      const float patch = y == 2 && (x == 5 || x == 6) ? 6.0f : 0.0f;
      const float sky = y < 4 ? 0.9f - 0.1f * float(y) : 0.2f;
      map.Pixel(x, y)[0] = sky + patch;
      map.Pixel(x, y)[1] = sky + 0.8f * patch;
      map.Pixel(x, y)[2] = 1.1f * sky + 0.6f * patch;
    }
  }
  return map;
}

class Converge : public Program {
 protected:
  void SetUp() override {
    Program::SetUp();
    WritePfm(Path("sky.pfm"), Sky());
  }
  Json ReadJson(const std::string& name) const { return Json::parse(Bytes(name)); }
};

TEST_F(Converge, FiguresAgreeWithEachOther) {
  const Result result =
      Run(std::string(kSmall) +
          "--strategies importance uniform median-cut:lights=1 --budgets 16,1,4 --repeats 4 "
          "--reference-spp 2048 --json j.json -q");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const Json json = ReadJson("j.json");
  EXPECT_EQ(json.at("schema"), "skywave-converge-2");
  EXPECT_EQ(json.at("settings").at("width"), 32);
  EXPECT_EQ(json.at("settings").at("repeats"), 4);
  EXPECT_EQ(json.at("settings").at("measure"), "mse");
  EXPECT_EQ(json.at("scene").at("name"), "spheres");
  EXPECT_EQ(json.at("reference").at("source"), "auto");
  EXPECT_EQ(json.at("reference").at("samples_per_pixel"), 2048);
  EXPECT_GT(json.at("reference").at("mse").get<double>(), 0);
  ASSERT_EQ(json.at("strategies").size(), 3u);
  for (const Json& strategy : json.at("strategies")) {
    const std::string name = strategy.at("strategy");
    SCOPED_TRACE(name);
    const bool lights = name == "median-cut:lights=1";
    EXPECT_EQ(strategy.at("unbiased"), !lights);
    EXPECT_GE(strategy.at("table_seconds").get<double>(), 0);
    ASSERT_EQ(strategy.at("budgets").size(), 3u);
    double before = std::numeric_limits<double>::infinity();
    std::uint32_t samples = 1;
    for (const Json& budget : strategy.at("budgets")) {
      EXPECT_EQ(budget.at("samples_per_pixel"), samples);
      samples *= 4;
      ASSERT_EQ(budget.at("runs").size(), 4u);
      double mean = 0, fastest = 1e9, slowest = 0;
      for (const Json& run : budget.at("runs")) {
        mean += run.at("mse").get<double>() / 4;
        fastest = std::min(fastest, run.at("seconds").get<double>());
        slowest = std::max(slowest, run.at("seconds").get<double>());
      }
      const double error = budget.at("error");
      EXPECT_NEAR(error, mean, 1e-12);
      EXPECT_LT(budget.at("error_interval").at(0), error);
      EXPECT_GT(budget.at("error_interval").at(1), error);
      EXPECT_GE(budget.at("seconds"), fastest);
      EXPECT_LE(budget.at("seconds"), slowest);
      // An error is the sum of noise, bias and the noise of the reference.
      const double bias = budget.at("squared_bias"), variance = budget.at("variance");
      EXPECT_NEAR(bias + variance + json.at("reference").at("mse").get<double>(), error,
                  1e-6 * error);
      EXPECT_EQ(budget.at("biased"), lights) << budget.dump();
      EXPECT_NEAR(budget.at("variance_seconds").get<double>(),
                  variance * budget.at("seconds").get<double>(), 1e-12);
      EXPECT_TRUE(lights || error < before) << error << " after " << before;
      before = error;
    }
  }
  const Json& first = json.at("strategies").at(0);
  EXPECT_EQ(json.at("target").at("error"), first.at("budgets").at(2).at("error"));
  EXPECT_EQ(first.at("time_to_target").at("place"), "inside");
  EXPECT_NEAR(first.at("speed_up").at("factor").get<double>(), 1, 1e-9);
  // One light never comes as near, so its time is longer and its speed-up smaller than any.
  EXPECT_EQ(json.at("strategies").at(2).at("time_to_target").at("place"), "beyond");
  const std::string targets = result.out.substr(result.out.find("time to mse"));
  const std::string row = targets.substr(targets.find("\nmedian-cut"));
  EXPECT_TRUE(std::regex_search(row, std::regex("^\nmedian-cut:lights=1 +\\S+ +> \\S+ .* < \\S+ .*"
                                                "biased")))
      << targets;
  for (const char* const part :
       {"importance", "median-cut:lights=1", "speed-up", "x variance", "none found"}) {
    EXPECT_TRUE(Contains(result.out, part)) << part << "\n" << result.out;
  }
}

// References have 16 times the samples of the largest budget, and weights also where what is
// measured has none.
TEST_F(Converge, ReferencesAreAsGoodAsTheHelpSays) {
  const std::string rest =
      "--strategies uniform --reference-strategy uniform --budgets 1,4 --repeats 2 -q --json ";
  ASSERT_EQ(Run(kSmall + rest + "a.json").exit_code, 0);
  ASSERT_EQ(Run(kSmall + rest + "b.json --no-mis").exit_code, 0);
  const Json a = ReadJson("a.json"), b = ReadJson("b.json");
  EXPECT_EQ(a.at("reference").at("samples_per_pixel"), 64);
  EXPECT_EQ(a.at("reference").at("mse"), b.at("reference").at("mse"));
  EXPECT_NE(a.at("strategies").at(0).at("budgets").at(0).at("error"),
            b.at("strategies").at(0).at("budgets").at(0).at("error"));
}

// The error maps of all share a scale: twice the typical relative error of the median strategy,
// rounded up to two digits.
TEST_F(Converge, ErrorMapsHaveTheScaleOfTheMedianStrategy) {
  const Result result = Run(std::string(kSmall) +
                            "--strategies importance uniform median-cut:lights=1 --budgets 1,16 "
                            "--repeats 2 --reference-spp 256 --json j.json --report r.html -q");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  std::vector<double> errors;
  const Json json = ReadJson("j.json");
  for (const Json& strategy : json.at("strategies")) {
    double sum = 0;
    for (const Json& run : strategy.at("budgets").at(1).at("runs")) {
      sum += run.at("relative_mse").get<double>();
    }
    errors.push_back(sum / 2);
  }
  std::sort(errors.begin(), errors.end());
  const std::string page = Bytes("r.html"), words = "black 0, yellow ";
  const std::size_t at = page.find(words);
  ASSERT_NE(at, std::string::npos);
  const double scale = std::stod(page.substr(at + words.size()));
  EXPECT_GE(scale, 2 * std::sqrt(errors[1]) * (1 - 1e-9));
  EXPECT_LE(scale, 2 * std::sqrt(errors[1]) * 1.1);
}

TEST_F(Converge, TimesAreComparedAtTheTargetError) {
  ASSERT_EQ(
      Run(std::string(kSmall) + "--strategies importance uniform --budgets 1,4,16 --repeats 2 "
                                "--reference-spp 1024 --json j.json -q")
          .exit_code,
      0);
  const double noise = ReadJson("j.json").at("reference").at("mse");
  const Json first = ReadJson("j.json").at("strategies").at(0).at("budgets");
  // The mean of the errors of two rungs is crossed between them.
  const double wanted =
      0.5 * (first.at(0).at("error").get<double>() + first.at(1).at("error").get<double>());
  ASSERT_EQ(Run(std::string(kSmall) +
                "--strategies importance uniform --budgets 1,4,16 --repeats 2 "
                "--reference-spp 1024 --json k.json -q --reference-strategy "
                "uniform --target-error " +
                std::to_string(wanted))
                .exit_code,
            0);
  const Json json = ReadJson("k.json");
  EXPECT_NEAR(json.at("target").at("error").get<double>() / wanted, 1, 1e-3);
  EXPECT_EQ(json.at("strategies").at(0).at("time_to_target").at("place"), "inside");
  // Uniform samples are noisier than the default ones.
  EXPECT_GT(json.at("reference").at("mse").get<double>(), 1.3 * noise);
}

TEST_F(Converge, IntegratorsAreComparedByTheLightThatPathSees) {
  const Result result =
      Run("converge spheres --env sky.pfm --size 32x24 --threads 2 --integrators path direct "
          "--strategies importance uniform --budgets 16 --repeats 4 --reference-spp 1024 "
          "--json j.json -q");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const Json json = ReadJson("j.json");
  EXPECT_EQ(json.at("reference").at("integrator"), "path");
  ASSERT_EQ(json.at("strategies").size(), 4u);
  const char* const expected[4][2] = {
      {"importance", "path"}, {"importance", "direct"}, {"uniform", "path"}, {"uniform", "direct"}};
  for (std::size_t i = 0; i < 4; ++i) {
    const Json& contestant = json.at("strategies").at(i);
    EXPECT_EQ(contestant.at("strategy"), expected[i][0]);
    EXPECT_EQ(contestant.at("integrator"), expected[i][1]);
    // Only interreflection is missing from direct light; nothing else is biased.
    EXPECT_EQ(contestant.at("budgets").at(0).at("biased"), i % 2 == 1);
    EXPECT_TRUE(Contains(result.out, std::string(expected[i][1]) + " " + expected[i][0]));
  }
}

TEST_F(Converge, BiasedIntegratorsAreCalledSo) {
  const Result result =
      Run("converge spheres --env sky.pfm --size 16x12 --threads 2 --vpls 4 --cache-rays 16 "
          "--integrators path vcm photon vpl irradiance-cache --budgets 1 --repeats 2 "
          "--reference-spp 16 --json j.json -q");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const Json json = ReadJson("j.json");
  EXPECT_EQ(json.at("strategies").size(), 5u);
  for (const Json& contestant : json.at("strategies")) {
    const std::string name = contestant.at("integrator");
    EXPECT_EQ(contestant.at("unbiased"), name == "path" || name == "vcm") << name;
  }
}

TEST_F(Converge, RunsOfOneRepeatShareTheirSeedAndNoOthersDo) {
  ASSERT_EQ(Run(std::string(kSmall) + "--strategies importance importance --budgets 1,2 "
                                      "--repeats 2 --reference-spp 64 --json j.json -q")
                .exit_code,
            0);
  const Json json = ReadJson("j.json");
  const Json &a = json.at("strategies").at(0), &b = json.at("strategies").at(1);
  std::set<std::uint32_t> seeds;
  for (int budget = 0; budget < 2; ++budget) {
    for (int repeat = 0; repeat < 2; ++repeat) {
      const Json& x = a.at("budgets").at(budget).at("runs").at(repeat);
      const Json& y = b.at("budgets").at(budget).at("runs").at(repeat);
      EXPECT_EQ(x.at("seed"), y.at("seed"));
      EXPECT_EQ(x.at("mse"), y.at("mse"));
      EXPECT_TRUE(seeds.insert(x.at("seed").get<std::uint32_t>()).second);
    }
  }
}

TEST_F(Converge, WritesCurvesAndAPageThatNeedsNothingElse) {
  const Result result = Run(std::string(kSmall) +
                            "--strategies importance hybrid:lights=8,inside=1 --budgets 1,4 "
                            "--repeats 2 --reference-spp 64 --plot p.svg --report r.html -q");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const std::string svg = Bytes("p.svg"), page = Bytes("r.html");
  EXPECT_TRUE(IsWellFormedXml(svg));
  EXPECT_TRUE(Contains(svg, "hybrid:lights=8,inside=1"));
  EXPECT_TRUE(Contains(page, "<svg")) << page.substr(0, 500);
  EXPECT_TRUE(Contains(page, "<td>hybrid:lights=8,inside=1</td><td>4</td>"));
  std::size_t pictures = 0;
  for (std::size_t at = page.find("data:image/png;base64,iVBORw0KGgo"); at != std::string::npos;
       at = page.find("data:image/png;base64,iVBORw0KGgo", at + 1)) {
    ++pictures;
  }
  EXPECT_EQ(pictures, 1u + 2u * 2u);  // the reference, plus the picture and the error map of each
                                      // strategy
  for (const char* const outside : {"src=\"http", "href=", "url(", "<script"}) {
    EXPECT_FALSE(Contains(page, outside)) << outside;
  }
  EXPECT_EQ(Files(), (std::set<std::string>{"p.svg", "r.html", "sky.pfm"}));
}

// Measured against the file, the same runs have the same errors, and its noise is still known.
TEST_F(Converge, ASavedReferenceGivesTheSameErrors) {
  const std::string rest = "--strategies importance --budgets 2 --repeats 3 -q ";
  ASSERT_EQ(
      Run(kSmall + rest + "--reference-spp 256 --save-reference r.exr --json a.json").exit_code, 0);
  const Result again = Run(kSmall + rest + "--reference r.exr --json b.json");
  ASSERT_EQ(again.exit_code, 0) << again.err;
  const Json a = ReadJson("a.json"), b = ReadJson("b.json");
  const Json &x = a.at("strategies").at(0).at("budgets").at(0),
             &y = b.at("strategies").at(0).at("budgets").at(0);
  EXPECT_EQ(x.at("error"), y.at("error"));
  EXPECT_EQ(x.at("variance"), y.at("variance"));
  EXPECT_NEAR(x.at("squared_bias").get<double>(), y.at("squared_bias").get<double>(),
              1e-6 * x.at("error").get<double>());
  EXPECT_EQ(a.at("reference").at("mse"), b.at("reference").at("mse"));
  EXPECT_EQ(a.at("reference").at("relative_mse"), b.at("reference").at("relative_mse"));
  EXPECT_NE(b.at("reference").at("relative_mse"), b.at("reference").at("mse"));
  EXPECT_EQ(b.at("reference").at("samples_per_pixel"), 256);
  EXPECT_EQ(b.at("reference").at("source"), "r.exr");
  const Result other = Run("converge gallery --size 32x24 --reference r.exr " + rest);
  EXPECT_EQ(other.exit_code, 0);
  EXPECT_TRUE(Contains(other.err, "another scene")) << other.err;
}

// Clamps make a picture too dark, so the truth has none.
TEST_F(Converge, MeasuresClampsAgainstAReferenceWithoutThem) {
  const std::string rest = "--strategies importance --budgets 2 --repeats 2 -q --reference-spp 64 ";
  ASSERT_EQ(Run(kSmall + rest + "--save-reference plain.exr").exit_code, 0);
  const Result clamped =
      Run(kSmall + rest + "--clamp-direct 0.2 --save-reference clamped.exr --json j.json");
  ASSERT_EQ(clamped.exit_code, 0) << clamped.err;
  EXPECT_EQ(ReadImage(Path("clamped.exr")).rgb, ReadImage(Path("plain.exr")).rgb);
  const Json json = ReadJson("j.json");
  EXPECT_EQ(json.at("strategies").at(0).at("unbiased"), false);
  EXPECT_EQ(json.at("strategies").at(0).at("budgets").at(0).at("biased"), true);
  EXPECT_TRUE(Contains(json.at("command").get<std::string>(), "--clamp-direct 0.2"));
}

TEST_F(Converge, WarnsOfAReferenceThatIsTooNoisyOrUnknown) {
  const std::string rest = "--strategies importance --budgets 4 --repeats 2 -q ";
  const Result noisy = Run(kSmall + rest + "--reference-spp 8 --json n.json --report n.html");
  EXPECT_EQ(noisy.exit_code, 0);
  const std::size_t hint = noisy.err.find("take more --reference-spp, about ");
  ASSERT_NE(hint, std::string::npos) << noisy.err;
  EXPECT_EQ(ReadJson("n.json").at("warnings").size(), 1u);
  EXPECT_TRUE(Contains(Bytes("n.html"), "take more --reference-spp"));
  // The number of samples that the warning advises suffices.
  const std::string advised = noisy.err.substr(noisy.err.find_last_of(' ') + 1);
  ASSERT_EQ(advised.back(), '\n');
  const Result enough =
      Run(kSmall + rest + "--reference-spp " + advised.substr(0, advised.size() - 1));
  EXPECT_EQ(enough.exit_code, 0);
  EXPECT_EQ(enough.err, "");
  ASSERT_EQ(
      Run("render spheres --env sky.pfm --size 32x24 --spp 64 --integrator direct -q -o plain.exr")
          .exit_code,
      0);
  const Result unknown = Run(kSmall + rest + "--reference plain.exr --json j.json");
  EXPECT_EQ(unknown.exit_code, 0);
  EXPECT_TRUE(Contains(unknown.err, "noise of the reference is unknown")) << unknown.err;
  EXPECT_TRUE(ReadJson("j.json").at("reference").at("mse").is_null());
  EXPECT_EQ(ReadJson("j.json").at("warnings").size(), 1u);
}

TEST_F(Converge, TimeGivesEveryStrategyALadderOfItsOwn) {
  const Result result = Run(std::string(kSmall) +
                            "--strategies importance median-cut:lights=64 --time 0.01 "
                            "--repeats 2 --measure relative_mse --json j.json -q");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const Json json = ReadJson("j.json");
  ASSERT_EQ(json.at("strategies").size(), 2u);
  for (const Json& strategy : json.at("strategies")) {
    std::uint32_t before = 0;
    for (const Json& budget : strategy.at("budgets")) {
      const std::uint32_t samples = budget.at("samples_per_pixel");
      EXPECT_GT(samples, before);
      EXPECT_LE(samples, std::max(2 * before, 1u));
      before = samples;
      const Json& runs = budget.at("runs");
      EXPECT_NEAR(budget.at("error").get<double>(),
                  0.5 * (runs.at(0).at("relative_mse").get<double>() +
                         runs.at(1).at("relative_mse").get<double>()),
                  1e-12);
    }
  }
}

struct BadCase {
  std::string arguments;
  int exit_code;
  std::vector<std::string> message;  // expected parts of the message
};

TEST_F(Converge, BadInputIsReportedAndLeavesNoFile) {
  WriteExr(Path("small.exr"), Image(8, 4));
  Image bad(32, 24);
  bad.rgb[5] = std::numeric_limits<float>::quiet_NaN();
  WriteExr(Path("nan.exr"), bad);
  const std::set<std::string> before = Files();
  const std::string good = std::string(kSmall) + "--strategies importance --budgets 1 --repeats 2 ";
  const BadCase cases[] = {
      {"converge spheres --integrators frob", kExitUsage, {"--integrators", "frob"}},
      {good + "--reference-integrator frob", kExitUsage, {"--reference-integrator", "frob"}},
      {good + "--integrators path", kExitUsage, {"--integrator", "--integrators"}},
      {std::string(kSmall) + "--strategies frob", kExitUsage, {"frob", "importance"}},
      {std::string(kSmall) + "--strategies importance hybrid:frob=1", kExitUsage, {"frob"}},
      {std::string(kSmall) + "--strategies importance:compensate=1 --no-mis",
       kExitUsage,
       {"--no-mis"}},
      {good + "--budgets 0", kExitUsage, {"--budgets"}},
      {good + "--budgets 1,x", kExitUsage, {"--budgets"}},
      {good + "--time 1", kExitUsage, {"--time", "--budgets"}},
      {std::string(kSmall) + "--strategies importance --time nan", kExitUsage, {"--time"}},
      {good + "--repeats 1", kExitUsage, {"--repeats"}},
      {good + "--measure psnr", kExitUsage, {"--measure", "psnr", "relative_mse"}},
      {good + "--target-error 0", kExitUsage, {"--target-error"}},
      {good + "--spp 4", kExitUsage, {"--spp"}},
      {good + "--strategy importance", kExitUsage, {"--strategy"}},
      {good + "--reference small.exr", kExitBadInput, {"small.exr", "8 x 4", "32 x 24", "--size"}},
      {good + "--reference nan.exr", kExitBadInput, {"nan.exr", "not numbers"}},
      {good + "--reference nosuch.exr", kExitIo, {"nosuch.exr"}},
      {good + "--reference small.exr --save-reference a.exr", kExitUsage, {"a.exr", "auto"}},
      {good + "--save-reference a.png", kExitUsage, {"a.png", ".exr"}},
      {good + "--json sky.pfm", kExitUsage, {"sky.pfm"}},
      {good + "--reference small.exr --plot small.exr", kExitUsage, {"small.exr"}},
      {std::string(kSmall) + "--strategies importance --budgets 65537 --light-samples 65536",
       kExitUsage,
       {"--budgets", "65537", "2^32"}},
      {good + "--json missing/j.json", kExitIo, {"missing/j.json"}},
      {good + "--plot missing/p.svg", kExitIo, {"missing/p.svg"}},
      {good + "--report missing/r.html", kExitIo, {"missing/r.html"}},
      {good + "--save-reference missing/r.exr", kExitIo, {"missing/r.exr"}},
      {"converge nosuch.pbrt --strategies importance", kExitBadInput, {"nosuch.pbrt"}},
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

TEST_F(Converge, TheCommandInTheReportMeasuresTheSameAgain) {
  ASSERT_EQ(Run(std::string(kSmall) +
                "--strategies importance \"hybrid:lights=8,inside=1\" --budgets 1,2 --repeats 2 "
                "--reference-integrator bdpt --reference-spp 32 --seed 5 --measure relative_mse "
                "--json a.json -q")
                .exit_code,
            0);
  const Json a = ReadJson("a.json");
  const std::string command = a.at("command");
  ASSERT_EQ(command.substr(0, 8), "skywave ");
  ASSERT_EQ(Run(command.substr(8) + " -q --json b.json").exit_code, 0) << command;
  const Json b = ReadJson("b.json");
  EXPECT_EQ(b.at("reference").at("integrator"), "bdpt");
  for (int strategy = 0; strategy < 2; ++strategy) {
    for (int budget = 0; budget < 2; ++budget) {
      const auto error = [&](const Json& json) {
        return json.at("strategies").at(strategy).at("budgets").at(budget).at("error");
      };
      EXPECT_EQ(error(a), error(b));
    }
  }
}

TEST_F(Converge, HelpHasExamples) {
  const Result result = Run("converge --help");
  EXPECT_EQ(result.exit_code, 0);
  for (const char* const part : {"Examples", "  skywave converge gallery", "--strategies",
                                 "--reference-spp", "--repeats", "--report"}) {
    EXPECT_TRUE(Contains(result.out, part)) << part;
  }
  EXPECT_FALSE(Contains(result.out, "--spp "));
}

// A run is repeated by render, and compare reports the same errors for it.
TEST_F(Converge, ErrorsOfARunEqualThoseOfCompare) {
  ASSERT_EQ(Run(std::string(kSmall) + "--strategies importance --budgets 2 --repeats 2 "
                                      "--reference-spp 64 --save-reference r.exr --json j.json -q")
                .exit_code,
            0);
  const Json run = ReadJson("j.json").at("strategies").at(0).at("budgets").at(0).at("runs").at(1);
  const std::string seed = std::to_string(run.at("seed").get<std::uint32_t>());
  ASSERT_EQ(Run("render spheres --env sky.pfm --size 32x24 --integrator direct --threads 2 "
                "--strategy importance --spp 2 -q -o p.exr --seed " +
                seed)
                .exit_code,
            0);
  ASSERT_EQ(Run("compare p.exr r.exr --json c.json").exit_code, 0);
  const Json compared = ReadJson("c.json");
  for (const char* const key : {"mse", "relative_mse", "mean_absolute", "psnr_db",
                                "squared_channel_sum", "thesis_luminance"}) {
    const double expected = compared.at(key);
    EXPECT_NEAR(run.at(key).get<double>() / expected, 1, 1e-6) << key;
  }
  EXPECT_GT(compared.at("squared_channel_sum").get<double>(),
            1.1 * compared.at("thesis_luminance").get<double>());
}

}  // namespace
}  // namespace skywave
