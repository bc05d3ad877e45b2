// Tests the table of options: every line is complete, text becomes a value and the same text again,
// and request, scene file and default take precedence in this order.
#include "job/options.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <string>

#include "base/error.h"
#include "job/job.h"
#include "job/resolve.h"
#include "wavefront/records/photon_map.h"

namespace skywave {
namespace {

const JobOption& OptionCalled(std::string_view name) {
  for (const JobOption& option : JobOptions()) {
    if (option.name == name) return option;
  }
  throw std::logic_error("no option");
}

void Set(JobRequest& request, const std::string& name, const std::string& text) {
  const std::shared_ptr<JobRequest> target(&request, [](JobRequest*) {});
  std::vector<BoundOption> options;
  for (const JobOption& option : JobOptions()) options.push_back(Bind(option, target));
  SetOption(options, name, text);
}

TEST(Options, HaveUniqueNamesAndHelpTexts) {
  std::set<std::string_view> names;
  for (const JobOption& option : JobOptions()) {
    SCOPED_TRACE(option.name);
    EXPECT_TRUE(names.insert(option.name).second);
    EXPECT_FALSE(option.help.empty());
    EXPECT_NE(option.help.back(), '.');
    EXPECT_FALSE(option.values.empty());
    EXPECT_EQ(option.needs.empty() && option.excludes.empty(), true)
        << "only subcommands have these";
  }
}

// Without an example, the tests of recorded commands and of the cache would skip the option.
TEST(Options, HaveAnExampleThatNamesThem) {
  for (const JobOption& option : JobOptions()) {
    SCOPED_TRACE(option.name);
    if (option.positional) continue;
    const std::string flag =
        (option.printed_default == "true" ? "--no-" : "--") + std::string(option.name);
    EXPECT_NE(std::string(option.example).find(flag), std::string::npos) << option.example;
  }
}

TEST(Options, ParseTheWordsThatTheyPrint) {
  const std::pair<const char*, const char*> values[] = {{"size", "31x17"},
                                                        {"spp", "7"},
                                                        {"integrator", "vcm"},
                                                        {"strategy", "bsdf"},
                                                        {"env", "a b.exr"},
                                                        {"env-projection", "mirror-ball"},
                                                        {"env-rotate", "-12.5"},
                                                        {"env-up", "z"},
                                                        {"mis", "false"},
                                                        {"eye", "1,-2.5,3e-05"},
                                                        {"fov", "33.3"},
                                                        {"fov", "0.01"},
                                                        {"camera", "equal-area"},
                                                        {"crop", "3x4+5+6"},
                                                        {"filter", "triangle"},
                                                        {"seed", "4294967295"},
                                                        {"split", "9"},
                                                        {"paths", "2,3"},
                                                        {"photons", "123456"},
                                                        {"progressive-alpha", "0.25"},
                                                        {"photon-kernel", "cone"},
                                                        {"aovs", "albedo,depth"},
                                                        {"max-triangles", "77"},
                                                        {"backend", "packet"},
                                                        {"frame", "-12.25"},
                                                        {"fps", "29.97"},
                                                        {"animation", "a b"},
                                                        {"scene-camera", "front"},
                                                        {"orbit", "-120"},
                                                        {"guide", "true"}};
  for (const auto& [name, text] : values) {
    JobRequest request;
    Set(request, name, text);
    EXPECT_EQ(OptionCalled(name).get(request), std::vector<std::string>{text}) << name;
  }
}

// A list is one word, which is split at its delimiter.
TEST(Options, ListsSurviveACommand) {
  JobRequest request;
  Set(request, "material", "red paint=mirror; steel=:alpha=0.5");
  EXPECT_EQ(request.materials, (std::vector<std::string>{"red paint=mirror", " steel=:alpha=0.5"}));
  EXPECT_EQ(CommandWords(OptionCalled("material"), request),
            " --material 'red paint=mirror; steel=:alpha=0.5'");
}

TEST(Options, RefuseCallsThatTheLinkedEmbreeLacks) {
  const JobOption& option = OptionCalled("backend");
  for (const Named<Backend>& backend : kEnumNames<Backend>) {
    SCOPED_TRACE(backend.name);
    JobRequest request;
    const std::string problem = option.set(request, {std::string(backend.name)});
    EXPECT_EQ(problem.empty(), IsAvailable(backend.value)) << problem;
    EXPECT_TRUE(problem.empty() || problem.ends_with(" is not best|packet|single")) << problem;
  }
}

// Every printed default is a valid value of the option, and equals the default of the field.
TEST(Options, PrintedDefaultsParseToTheDefault) {
  const JobRequest defaults;
  for (const JobOption& option : JobOptions()) {
    for (const std::string& text : option.get(defaults)) {
      if (text.empty()) continue;
      JobRequest request;
      EXPECT_EQ(option.set(request, {text}), "") << option.name;
      EXPECT_EQ(option.get(request), option.get(defaults)) << option.name;
    }
  }
}

TEST(Options, InvalidValuesAndNamesAreRefused) {
  const std::pair<const char*, const char*> values[] = {
      {"size", "0x3"},        {"size", "3"},
      {"size", "3x4x5"},      {"spp", "0"},
      {"spp", "1.5"},         {"spp", "16777217"},
      {"integrator", "p"},    {"env-rotate", "nan"},
      {"env-rotate", "1e7"},  {"env-intensity", "-1"},
      {"env-up", "xy"},       {"eye", "1,2"},
      {"eye", "1,2,inf"},     {"fov", "0"},
      {"crop", "1x1"},        {"seed", "-1"},
      {"seed", "4294967296"}, {"split", "0"},
      {"paths", "1"},         {"aovs", "colour"},
      {"mis", "maybe"},       {"photon-neighbors", "1"}};
  for (const auto& [name, text] : values) {
    JobRequest request;
    try {
      Set(request, name, text);
      ADD_FAILURE() << name << " took " << text;
    } catch (const InputError& error) {
      EXPECT_EQ(error.exit_code(), kExitUsage);
      EXPECT_NE(std::string(error.what()).find(name), std::string::npos) << error.what();
      EXPECT_NE(std::string(error.what()).find(text), std::string::npos) << error.what();
    }
  }
  JobRequest request;
  try {
    Set(request, "max-dept", "3");
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("max-depth"), std::string::npos) << error.what();
  }
}

JobRequest Resolve(const JobRequest& request, const RenderSettings& settings = {}) {
  std::vector<std::string> notes;
  return ResolveRequest(request, settings, notes);
}

TEST(Resolve, TakesTheRequestThenTheSceneThenTheDefault) {
  RenderSettings scene;
  scene.width = 50, scene.height = 40;
  scene.samples_per_pixel = 3;
  scene.max_depth = 2;
  scene.integrator = "direct";
  scene.filter = PixelFilter::kTriangle;
  scene.filter_radius = 1.25f;
  JobRequest request;
  EXPECT_EQ(Resolve(request).options.width, RenderOptions().width);
  EXPECT_EQ(*Resolve(request).samples_per_pixel, RenderOptions().samples_per_pixel);
  EXPECT_EQ(*Resolve(request).max_depth, RenderOptions().max_depth);

  const RenderOptions of_scene = Resolve(request, scene).options;
  EXPECT_EQ(of_scene.width, 50);
  EXPECT_EQ(of_scene.height, 40);
  EXPECT_EQ(of_scene.samples_per_pixel, 3u);
  EXPECT_EQ(of_scene.max_depth, 2u);
  EXPECT_EQ(of_scene.integrator, Integrator::kDirect);
  EXPECT_EQ(of_scene.filter, PixelFilter::kTriangle);
  EXPECT_EQ(of_scene.filter_radius, 1.25f);

  request.width = 6, request.height = 5;
  request.samples_per_pixel = 9;
  request.max_depth = 7;
  request.integrator = Integrator::kPath;
  request.filter = PixelFilter::kBox;
  const RenderOptions own = Resolve(request, scene).options;
  EXPECT_EQ(own.width, 6);
  EXPECT_EQ(own.samples_per_pixel, 9u);
  EXPECT_EQ(own.max_depth, 7u);
  EXPECT_EQ(own.integrator, Integrator::kPath);
  EXPECT_EQ(own.filter, PixelFilter::kBox);
  EXPECT_EQ(own.filter_radius, DefaultFilterRadius(PixelFilter::kBox)) << "not the scene's";
}

// Resolving again changes nothing: a recorded command is a fixed point.
TEST(Resolve, ResolvingTwiceChangesNothing) {
  RenderSettings scene;
  scene.crop = CropFractions{0.25f, 0.75f, 0.5f, 1};
  scene.integrator = "photon";
  scene.photons_each_sample = true;
  scene.photon_distance = 0.5f;
  JobRequest request;
  request.width = 9, request.height = 6;
  request.samples_per_pixel = 4;
  const JobRequest once = Resolve(request, scene);
  EXPECT_EQ(once.options.of<PhotonOptions>().passes, 4u);
  EXPECT_EQ(once.options.of<PhotonOptions>().distance, 0.5f);
  EXPECT_EQ(once.options.width, 4);
  EXPECT_EQ(once.options.film_width, 9);
  EXPECT_EQ(once.options.crop_x, 3);
  const JobRequest twice = Resolve(once, scene);
  EXPECT_EQ(PictureOptions(once), PictureOptions(twice));
  EXPECT_EQ(twice.options.width, 4);
  EXPECT_EQ(twice.options.film_width, 9);
}

// A tenth of 160 pixels is 16, although a tenth is not a float. pbrt rounds the product up.
TEST(Resolve, FractionsOfAFileBecomeWholePixels) {
  RenderSettings scene;
  scene.crop = CropFractions{0.1f, 0.9f, 0.1f, 0.9f};
  JobRequest request;
  request.width = 160, request.height = 120;
  const RenderOptions options = Resolve(request, scene).options;
  EXPECT_EQ(options.crop_x, 16);
  EXPECT_EQ(options.crop_y, 12);
  EXPECT_EQ(options.width, 128);
  EXPECT_EQ(options.height, 96);
}

TEST(Resolve, LowersADepthBeyondTheLargest) {
  RenderSettings scene;
  scene.max_depth = 100000;
  std::vector<std::string> notes;
  EXPECT_EQ(ResolveRequest({}, scene, notes).options.max_depth, kMaxDepth);
  ASSERT_EQ(notes.size(), 1u);
  EXPECT_NE(notes[0].find("100000"), std::string::npos);
}

// A recorded command omits options of other integrators and input options with their default.
TEST(PictureOptions, NamesWhatDecidesThePictureAndNothingElse) {
  JobRequest request;
  request.scene = "a b.pbrt";
  request.options.threads = 3;
  request.options.wave = 64;
  const std::string words = PictureOptions(Resolve(request));
  EXPECT_NE(words.find(" 'a b.pbrt'"), std::string::npos) << words;
  for (const char* const flag : {"--threads", "--wave", "--backend", "--photons", "--split",
                                 "--strict", "--max-triangles", "--no-mis", "--ground"}) {
    EXPECT_EQ(words.find(flag), std::string::npos) << flag << words;
  }
  request.integrator = Integrator::kVcm;
  request.read.max_triangles = 5;
  const std::string of_vcm = PictureOptions(Resolve(request));
  for (const char* const flag : {"--photons 200000", "--progressive-alpha", "--max-triangles 5"}) {
    EXPECT_NE(of_vcm.find(flag), std::string::npos) << flag << of_vcm;
  }
  EXPECT_EQ(of_vcm.find("--gather"), std::string::npos) << of_vcm;
  const std::string_view without[] = {"photons"};
  EXPECT_EQ(PictureOptions(Resolve(request), without).find("--photons"), std::string::npos);
}

TEST(Options, TheNumberOfLightsForABiasIsReported) {
  JobRequest request;
  request.scene = "spheres";
  request.width = request.height = 4, request.samples_per_pixel = 1;
  request.strategy = "variance-cut:lights=auto:0.2";
  const RenderJob job(request);
  const std::string begin = request.strategy + ": ";
  const auto note = std::find_if(job.notes().begin(), job.notes().end(),
                                 [&](const std::string& text) { return text.starts_with(begin); });
  ASSERT_NE(note, job.notes().end());
  EXPECT_EQ(std::stoul(note->substr(begin.size())), job.strategy().Plan(1).fixed) << *note;
}

TEST(Resolve, PhotonsOfTheUserComeBeforeThoseOfTheScene) {
  RenderSettings scene;
  scene.integrator = "photon";
  scene.photons_each_sample = true;
  scene.photon_distance = 0.5f;
  JobRequest request;
  request.samples_per_pixel = 4;
  request.options.of<PhotonOptions>().passes = 2;
  request.options.of<PhotonOptions>().distance = 0.25f;
  const RenderOptions options = Resolve(request, scene).options;
  EXPECT_EQ(options.of<PhotonOptions>().passes, 2u);
  EXPECT_EQ(options.of<PhotonOptions>().distance, 0.25f);
}

}  // namespace
}  // namespace skywave
