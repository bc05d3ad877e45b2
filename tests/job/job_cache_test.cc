// Tests the cache of jobs, and that jobs which share parts make the pictures of jobs that do not.
#include "job/job_cache.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <barrier>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

#include "base/error.h"
#include "job/job.h"
#include "job/options.h"
#include "job/picture.h"
#include "scene/reader.h"
#include "tests/support/camera_text.h"
#include "tests/support/gltf_document.h"
#include "tests/support/temporary_folder.h"
#include "wavefront/render.h"

namespace skywave {
namespace {

struct Bytes {
  int number;
  std::size_t size;
  std::size_t bytes() const { return size; }
};

class Cache : public testing::Test {
 protected:
  // Returns what the cache has for `key`; if it has nothing, a value of `size` bytes is made.
  std::shared_ptr<const Bytes> Get(JobCache& cache, const std::string& key, std::size_t size = 10) {
    return cache.Get<Bytes>(key, [&] {
      ++made_;
      return std::make_shared<const Bytes>(Bytes{made_, size});
    });
  }
  bool Has(JobCache& cache, const std::string& key) {
    const int before = made_;
    Get(cache, key);
    return made_ == before;
  }

  int made_ = 0;
};

TEST_F(Cache, DropsTheLeastRecentlyUsedFirst) {
  JobCache cache(30);
  for (const char* const key : {"a", "b", "c", "a", "d"}) Get(cache, key);
  EXPECT_EQ(made_, 4);
  EXPECT_EQ(cache.bytes(), 30u);
  EXPECT_TRUE(Has(cache, "a"));
  EXPECT_TRUE(Has(cache, "c"));
  EXPECT_TRUE(Has(cache, "d"));
  EXPECT_FALSE(Has(cache, "b"));  // now it replaces `a`
  EXPECT_FALSE(Has(cache, "a"));
}

// What was needed once makes room before what is needed again.
TEST_F(Cache, KeepsLessOfWhatNobodyHasAskedForAgain) {
  JobCache cache(100, 30);
  for (const char* const key : {"a", "b", "a", "b"}) Get(cache, key);
  for (int i = 0; i < 20; ++i) {
    Get(cache, std::to_string(i));
    EXPECT_LE(cache.bytes(), 50u);
  }
  EXPECT_EQ(cache.bytes(), 50u);
  const int before = made_;
  for (const char* const key : {"a", "b", "19", "18", "17"}) EXPECT_TRUE(Has(cache, key)) << key;
  EXPECT_EQ(made_, before);
  EXPECT_FALSE(Has(cache, "16"));
}

// A value that has made room is one that was asked for again when somebody asks for it who finds it
// with another one.
TEST_F(Cache, WhatIsHeldIsAskedForAgain) {
  JobCache cache(100, 15);
  const std::shared_ptr<const Bytes> held = Get(cache, "a");
  Get(cache, "b");  // `a` is not kept any more
  EXPECT_EQ(cache.bytes(), 10u);
  EXPECT_EQ(Get(cache, "a"), held);
  for (int i = 0; i < 9; ++i) Get(cache, std::to_string(i));
  EXPECT_EQ(cache.bytes(), 20u) << "`a`, and the last one";
}

TEST_F(Cache, StaysWithinItsLimitWhateverTheSizes) {
  JobCache cache(100);
  for (std::size_t i = 0; i < 50; ++i) {
    Get(cache, std::to_string(i), i * 37 % 60);
    EXPECT_LE(cache.bytes(), 100u);
  }
  Get(cache, "small", 1);
  EXPECT_EQ(Get(cache, "large", 101)->size, 101u);
  EXPECT_LE(cache.bytes(), 100u);
  EXPECT_FALSE(Has(cache, "large"));
}

TEST_F(Cache, DroppedValuesLiveWhileTheyAreHeld) {
  JobCache cache(1);
  std::shared_ptr<const Bytes> held = Get(cache, "a");
  EXPECT_LE(cache.bytes(), 1u);
  EXPECT_EQ(held->number, 1);
  EXPECT_EQ(Get(cache, "a"), held);  // and are found
  Get(cache, "b");
  EXPECT_EQ(Get(cache, "a"), held);
  EXPECT_LE(cache.bytes(), 1u);
  held.reset();
  EXPECT_FALSE(Has(cache, "a"));
}

TEST_F(Cache, ForgetsWhatBeginsWithAPrefix) {
  JobCache cache(100);
  for (const char* const key : {"a", "b 1", "b 2", "c"}) Get(cache, key);
  cache.Forget("b ");
  EXPECT_EQ(cache.bytes(), 20u);
  EXPECT_TRUE(Has(cache, "a"));
  EXPECT_TRUE(Has(cache, "c"));
  EXPECT_FALSE(Has(cache, "b 1"));
  EXPECT_FALSE(Has(cache, "b 2"));
}

TEST_F(Cache, MakesAValueOnceForAllThreads) {
  constexpr int kThreads = 8;
  JobCache cache(1000);
  std::atomic<int> made = 0;
  std::barrier start(kThreads);
  std::vector<std::shared_ptr<const Bytes>> got(kThreads);
  std::vector<std::thread> threads;
  for (int i = 0; i < kThreads; ++i) {
    threads.emplace_back([&, i] {
      start.arrive_and_wait();
      got[std::size_t(i)] = cache.Get<Bytes>("a", [&] {
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
        return std::make_shared<const Bytes>(Bytes{++made, 10});
      });
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(made, 1);
  for (const auto& value : got) EXPECT_EQ(value, got[0]);
  EXPECT_EQ(cache.bytes(), 10u);
}

TEST_F(Cache, FailedValuesAreTriedAgain) {
  JobCache cache(100);
  const auto fail = [&] {
    cache.Get<Bytes>(
        "a", []() -> std::shared_ptr<const Bytes> { throw std::runtime_error("no memory"); });
  };
  EXPECT_THROW(fail(), std::runtime_error);
  EXPECT_THROW(fail(), std::runtime_error);
  EXPECT_EQ(cache.bytes(), 0u);
  EXPECT_EQ(Get(cache, "a")->number, 1);
}

// Everything that shows whether two jobs are the same, and one sample of every pixel.
struct Outcome {
  std::string command;
  std::uint64_t scene_hash, map_hash;
  std::vector<std::string> notes;
  std::vector<std::uint64_t> sums;
  bool operator==(const Outcome&) const = default;
};

using Option = std::pair<std::string, std::string>;
using Options = std::vector<Option>;

Outcome Render(const Options& options, JobCache* cache) {
  const auto request = std::make_shared<JobRequest>();
  request->width = 24, request->height = 16, request->samples_per_pixel = 1;
  SetOptions(BindAll(JobOptions(), request), options);
  const RenderJob job(*request, cache);
  Film film = job.MakeFilm();
  RenderFrame(job.frame(), film);
  const PictureIdentity identity = IdentityOf(job, {}, true);
  return {.command = RepeatCommand(identity, PartOf(job, {0, identity.samples})),
          .scene_hash = job.scene_hash(),
          .map_hash = job.map_hash(),
          .notes = job.notes(),
          .sums = {film.sums().begin(), film.sums().end()}};
}

constexpr char kCamera[] =
    "LookAt 0 2 5  0 0.5 0  0 1 0\nCamera \"perspective\" \"float fov\" 50\nWorldBegin\n";
constexpr char kOneLight[] = "LightSource \"infinite\" \"string filename\" \"sun.pfm\"\n";
// Two maps, one of them turned, and a lamp.
constexpr char kLights[] = R"(LightSource "infinite" "string filename" "sky.pfm"
AttributeBegin
Rotate 40 0 1 0
LightSource "infinite" "string filename" "sun.pfm"
AttributeEnd
LightSource "point" "rgb I" [3 2 1] "point3 from" [1 2 1]
)";
constexpr char kShapes[] =
    R"(MakeNamedMaterial "red" "string type" "diffuse" "rgb reflectance" [0.8 0.1 0.1]
NamedMaterial "red"
Shape "trianglemesh" "integer indices" [0 1 2 2 1 3] "point2 uv" [0 0 1 0 0 1 1 1]
  "point3 P" [-2 0 -2  2 0 -2  -2 0 2  2 1 2]
)";

class SharedParts : public testing::Test {
 protected:
  SharedParts() {
    // A square is taken for an angular map, or whatever a projection says.
    for (const auto& [name, width, height] :
         {std::tuple("sky.pfm", 16, 8), {"sun.pfm", 8, 8}, {"ramp.pfm", 12, 12}}) {
      Image map(width, height);
      for (std::size_t i = 0; i < map.rgb.size(); ++i) map.rgb[i] = float(i * 7 % 23) / 8;
      map.rgb[map.rgb.size() / 3] = name[1] == 'u' ? 90.0f : -1.0f;  // a sun, or a bad pixel
      WritePfm(folder_.Path(name), map);
    }
    const Option one = {"scene",
                        folder_.Write("one.pbrt", std::string(kCamera) + kOneLight + kShapes)};
    const Option lights = {"scene",
                           folder_.Write("lights.pbrt", std::string(kCamera) + kLights + kShapes)};
    const Option sky = {"env", folder_.Path("sky.pfm")}, ramp = {"env", folder_.Path("ramp.pfm")};
    // The first two frames of a map that moves.
    std::filesystem::copy_file(folder_.Path("sky.pfm"), folder_.Path("moving_1.pfm"));
    std::filesystem::copy_file(folder_.Path("ramp.pfm"), folder_.Path("moving_2.pfm"));
    const Option moving = {"env", folder_.Path("moving_#.pfm")}, second = {"frame", "2"};
    const std::vector<Options> scenes = {
        {one},    {one, sky},    {one, ramp},           {one, moving, {"frame", "1"}},
        {lights}, {lights, sky}, {one, moving, second}, {lights, moving, second}};
    const std::vector<Options> changes = {{},
                                          {{"env-rotate", "30"}},
                                          {{"env-rotate", "75"}},
                                          {{"env-intensity", "2"}},
                                          {{"env-up", "z"}},
                                          {{"env-up", "z"}, {"env-rotate", "30"}},
                                          {{"eye", "1,3,6"}},
                                          {{"orbit", "90"}},
                                          {{"ground", "true"}},
                                          {{"aovs", "albedo,uv,normal"}},
                                          {{"strategy", "alias"}},
                                          {{"strategy", "uniform"}},
                                          {{"strategy", "median-cut"}, {"env-rotate", "30"}},
                                          {{"continuation-strategy", "uniform"}, {"split", "2"}},
                                          {{"integrator", "light"}, {"strategy", "alias"}},
                                          {{"seed", "5"}},
                                          {{"trust-input", "true"}},
                                          {{"material", "red=:reflectance=0.1/0.2/0.9"}},
                                          {{"size", "16x16"}}};
    for (const Options& scene : scenes) {
      std::vector<Options> all = changes;
      if (scene.size() > 1) {
        all.push_back({{"env-projection", "mirror-ball"}});
        all.push_back({{"env-projection", "latlong"}, {"env-rotate", "30"}});
      }
      for (const Options& change : all) {
        jobs_.push_back(scene);
        jobs_.back().insert(jobs_.back().end(), change.begin(), change.end());
      }
    }
  }

  static std::string Text(const Options& options) {
    std::string text;
    for (const auto& [name, value] : options) text += name + " = " + value + ", ";
    return text;
  }

  TemporaryFolder folder_;
  std::vector<Options> jobs_;
};

// Returns the options of an example as the table has it, "scene.pbrt --spp 3 --no-mis"; names of
// files that `folder` has are in it.
Options OptionsOfExample(const std::string& example, const TemporaryFolder& folder) {
  std::vector<std::string> words = {""};
  bool quoted = false;
  for (const char c : example) {
    if (c == '\'') {
      quoted = !quoted;
    } else if (!quoted && (c == ' ' || c == '=') && (c == ' ' || words.back().starts_with("--"))) {
      words.emplace_back();
    } else {
      words.back() += c;
    }
  }
  for (std::string& word : words) {
    if (std::filesystem::is_regular_file(folder.Path(word))) word = folder.Path(word);
  }
  Options options;
  for (std::size_t i = 0; i < words.size(); ++i) {
    const std::string& word = words[i];
    const bool has_value = i + 1 < words.size() && !words[i + 1].starts_with("--");
    if (!word.starts_with("--")) {
      options.emplace_back("scene", word);
    } else if (word.starts_with("--no-")) {
      options.emplace_back(word.substr(5), "false");
    } else {
      options.emplace_back(word.substr(2), has_value ? words[++i] : "true");
    }
  }
  return options;
}

// What is kept is made anew where the line of an option in the table says that the option changes
// it. An option whose line forgets a map or the lights of the scene gives the picture of its value
// before; one that forgets the prepared scene gives no other picture at all, as other tests see.
TEST_F(SharedParts, FollowTheChangeOfAnyOptionOfTheTable) {
  folder_.Write("moving.gltf", MovingTriangle().text());
  folder_.Write("scene.pbrt", std::string(kCamera) + kOneLight + kShapes);
  folder_.Write("camera.json", test::kCameraFile);
  WriteExr(folder_.Path("map.exr"), ReadImage(folder_.Path("sky.pfm")));
  const Option lights = {"scene", folder_.Path("lights.pbrt")};
  const Option map = {"env", folder_.Path("sun.pfm")};
  JobCache cache(std::uint64_t{1} << 40);
  const auto expect_fresh = [&](const Options& options) {
    const Outcome fresh = Render(options, nullptr), shared = Render(options, &cache);
    EXPECT_EQ(shared.notes, fresh.notes) << Text(options);
    EXPECT_EQ(shared.scene_hash, fresh.scene_hash) << Text(options);
    EXPECT_EQ(shared.map_hash, fresh.map_hash) << Text(options);
    EXPECT_TRUE(shared.sums == fresh.sums) << Text(options);
  };
  for (const JobOption& option : JobOptions()) {
    ASSERT_NE(option.example, "") << option.name;
    const Options example = OptionsOfExample(std::string(option.example), folder_);
    const bool found = std::any_of(example.begin(), example.end(),
                                   [&](const Option& given) { return given.first == option.name; });
    EXPECT_TRUE(found) << option.name;
    for (const Options& base : {Options{lights}, Options{lights, map}}) {
      // The scene of the example, if it has one, without the option and with it.
      Options before = base;
      for (const Option& given : example) {
        if (given.first != option.name || given.first == "scene") before.push_back(given);
      }
      if (example.front().first == "scene" && base.size() == 1) before.push_back(map);
      Options with = before;
      for (const Option& given : example) with.push_back(given);
      // `--no-mis` of this one asks for `--paths`.
      if (option.positional || option.name == "paths") before = base;
      expect_fresh(before);
      expect_fresh(with);
    }
  }
}

TEST_F(SharedParts, OfASceneInMemoryAreBuiltOnceForAllCamerasMapsAndStrategies) {
  auto scene = std::make_unique<SharedScene>(
      std::make_shared<LoadedScene>(ReadScene(folder_.Path("lights.pbrt"), ReadOptions())));
  const auto job = [&](const Options& options) {
    const auto request = std::make_shared<JobRequest>();
    request->width = 24, request->height = 16, request->samples_per_pixel = 1;
    SetOptions(BindAll(JobOptions(), request), options);
    return RenderJob(*scene, *request);
  };
  const Options env = {{"env", folder_.Path("sky.pfm")}};
  std::optional<RenderJob> first(job(env));
  const Geometry* const geometry = &first->geometry();
  const EnvStrategy* const strategy = &first->strategy();
  const auto with = [&](Option option) { return Options{env.front(), std::move(option)}; };
  EXPECT_EQ(&job(with({"eye", "1,3,6"})).geometry(), geometry);
  EXPECT_EQ(&job(with({"eye", "1,3,6"})).strategy(), strategy);
  EXPECT_EQ(&job(with({"size", "8x8"})).strategy(), strategy);
  EXPECT_EQ(&job(with({"strategy", "alias"})).geometry(), geometry);
  EXPECT_NE(&job(with({"strategy", "alias"})).strategy(), strategy);
  EXPECT_EQ(&job(with({"env", folder_.Path("ramp.pfm")})).geometry(), geometry);
  EXPECT_NE(&job(with({"ground", "true"})).geometry(), geometry);
  first.reset();
  EXPECT_EQ(&job(env).strategy(), strategy);  // kept though no job is there
  // A job needs its scene no more.
  const RenderJob last = job(env);
  scene.reset();
  Film film = last.MakeFilm();
  RenderFrame(last.frame(), film);
  EXPECT_TRUE(std::any_of(film.sums().begin(), film.sums().end(), [](auto x) { return x != 0; }));
}

TEST_F(SharedParts, AreMadeAnewWhenTheFileOfAMapHasChanged) {
  const SharedScene scene(
      std::make_shared<LoadedScene>(ReadScene(folder_.Path("one.pbrt"), ReadOptions())));
  JobRequest request;
  request.width = 8, request.height = 6;
  request.environment.path = folder_.Path("sky.pfm");
  const std::uint64_t before = RenderJob(scene, request).map_hash();
  EXPECT_EQ(RenderJob(scene, request).map_hash(), before);
  Image other(16, 8);
  for (float& value : other.rgb) value = 2;
  WritePfm(folder_.Path("sky.pfm"), other);
  EXPECT_NE(RenderJob(scene, request).map_hash(), before);
}

TEST_F(SharedParts, AreMadeAnewWhenTheLayerOfAMapHasChanged) {
  JobCache cache(std::uint64_t{1} << 40);
  const auto hash_of = [&](float value) {
    const std::vector<float> values(16 * 8, value);
    WriteExr(folder_.Path("sky.exr"), Image(16, 8), {},
             {{"sun.R", values}, {"sun.G", values}, {"sun.B", values}});
    JobRequest request;
    request.scene = folder_.Path("one.pbrt");
    request.width = 8, request.height = 6;
    request.environment.path = folder_.Path("sky.exr:sun");
    return RenderJob(request, &cache).map_hash();
  };
  EXPECT_NE(hash_of(1), hash_of(2.5f));
}

TEST_F(SharedParts, AreMadeAnewWhenTheLightsOfAFileHaveChanged) {
  JobCache cache(std::uint64_t{1} << 40);
  const auto strategy = [&] {
    JobRequest request;
    request.scene = folder_.Path("one.pbrt");
    request.width = 8, request.height = 6;
    request.environment.path = folder_.Path("sky.pfm");
    request.strategy = "presampled:mode=fixed,file=" + folder_.Path("set.json");
    return &RenderJob(request, &cache).strategy();
  };
  folder_.Write("set.json", R"({"samples": [{"uv": [0.25, 0.5]}, {"uv": [0.75, 0.5]}]})");
  const EnvStrategy* const before = strategy();
  EXPECT_EQ(strategy(), before);
  folder_.Write("set.json", R"({"samples": [{"uv": [0.5, 0.5]}]})");
  EXPECT_NE(strategy(), before);
}

// The file of the cells is broken meanwhile, which only making tables anew would notice.
TEST_F(SharedParts, OrientationsOfAMapShareItsImageAndTables) {
  JobCache cache(std::uint64_t{1} << 40);
  const std::string cells =
      folder_.Write("set.json", R"({"samples": [{"uv": [0.25, 0.5]}, {"uv": [0.75, 0.5]}]})");
  const auto job = [&](double degrees, const std::string& strategy) {
    JobRequest request;
    request.scene = folder_.Path("one.pbrt");
    request.width = 8, request.height = 6;
    request.environment.path = folder_.Path("sky.pfm");
    request.environment.rotation_degrees = degrees;
    request.strategy = strategy;
    return RenderJob(request, &cache);
  };
  const std::string shared = "presampled:file=" + cells;
  const RenderJob first = job(0, shared);
  const auto time = std::filesystem::last_write_time(cells);
  folder_.Write("set.json", std::string(std::filesystem::file_size(cells), '?'));
  std::filesystem::last_write_time(cells, time);
  const RenderJob turned = job(30, shared);
  EXPECT_NE(&first.strategy(), &turned.strategy());
  EXPECT_EQ(first.frame().map->latlong.operator->(), turned.frame().map->latlong.operator->());
  EXPECT_NE(first.frame().map->map_from_world, turned.frame().map->map_from_world);
  EXPECT_THROW(job(30, shared + ",mode=fixed"), InputError);
}

TEST_F(SharedParts, MaterialsOfTheSameTrianglesShareTheirBvh) {
  JobCache cache(std::uint64_t{1} << 40);
  const auto job = [&](const std::string& change, bool ground) {
    JobRequest request;
    request.scene = folder_.Path("one.pbrt");
    request.width = 8, request.height = 6;
    request.ground = ground ? Ground::kGrey : Ground::kNone;
    if (!change.empty()) request.materials = {change};
    return RenderJob(request, &cache);
  };
  const RenderJob plain = job("", false), mirror = job("red=mirror", false),
                  blue = job("red=:reflectance=0.1/0.2/0.9", false), ground = job("", true);
  EXPECT_NE(&mirror.geometry(), &plain.geometry());
  EXPECT_EQ(mirror.geometry().scene(), plain.geometry().scene());
  EXPECT_EQ(blue.geometry().scene(), plain.geometry().scene());
  EXPECT_EQ(blue.geometry().bvh_bytes(), 0u);
  EXPECT_NE(ground.geometry().scene(), plain.geometry().scene());
}

TEST_F(SharedParts, PicturesEqualThoseWithoutACache) {
  std::vector<Outcome> expected;
  for (const Options& job : jobs_) expected.push_back(Render(job, nullptr));
  JobCache all(std::uint64_t{1} << 40), none(1), some(200'000);
  for (JobCache* const cache : {&all, &none, &some}) {
    // The second round finds what the first one has left, in another order.
    for (std::size_t i = 0; i < 2 * jobs_.size(); ++i) {
      const std::size_t number = i < jobs_.size() ? i : (i * 31) % jobs_.size();
      const Outcome outcome = Render(jobs_[number], cache);
      EXPECT_EQ(outcome.command, expected[number].command);
      EXPECT_EQ(outcome.notes, expected[number].notes) << Text(jobs_[number]);
      EXPECT_EQ(outcome.scene_hash, expected[number].scene_hash) << Text(jobs_[number]);
      EXPECT_EQ(outcome.map_hash, expected[number].map_hash) << Text(jobs_[number]);
      EXPECT_TRUE(outcome.sums == expected[number].sums) << Text(jobs_[number]);
    }
  }
  EXPECT_LE(none.bytes(), 1u);
  EXPECT_LE(some.bytes(), 200'000u);
}

}  // namespace
}  // namespace skywave
