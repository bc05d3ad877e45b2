// A picture is bit-identical however its work is divided and whatever it runs on.
#include <gtest/gtest.h>
#include <algorithm>
#include <atomic>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "base/files.h"
#include "lights/strategies/strategy.h"
#include "scene/builtin/builtin.h"
#include "tests/support/emission_guides.h"
#include "tests/support/painted_scene.h"
#include "tests/support/photon_maps.h"
#include "tests/support/program.h"
#include "tests/support/render_scenes.h"
#include "tests/support/screens_scene.h"
#include "tests/support/shade_points.h"
#include "tests/support/targets.h"
#include "wavefront/flush_denormals.h"
#include "wavefront/policies/emission_pilot.h"
#include "wavefront/records/irradiance_cache.h"
#include "wavefront/records/photon_map.h"
#include "wavefront/records/virtual_lights.h"
#include "wavefront/render.h"
#include "wavefront/worker.h"

namespace skywave {
namespace {

struct Case {
  std::string scene;
  Integrator integrator;
};
void PrintTo(const Case& test, std::ostream* out) {
  *out << test.scene << " " << ToString(test.integrator);
}

Scene SceneOf(const Case& test) {
  if (test.scene == "screens") return ScreensScene();
  return test.scene == "painted" ? PaintedScene() : BuiltinScene(test.scene);
}

// Jobs are built once because reading and building take longer than the renders.
const RenderJob& Job(const Case& test) {
  static std::vector<std::pair<std::string, std::unique_ptr<RenderJob>>> jobs;
  const std::string name = test.scene + std::string(ToString(test.integrator));
  for (const auto& [known, job] : jobs) {
    if (known == name) return *job;
  }
  // The size is not a multiple of any tile, and with 5 samples waves end inside blocks.
  JobRequest request = SmallRequest(37, 29, 5);
  request.integrator = test.integrator;
  request.options.light_samples = 3;
  request.max_depth = 8;
  request.options.of<PhotonOptions>().indirect = request.options.of<PhotonOptions>().caustic = 3000;
  request.options.of<PhotonOptions>().gather = 2;
  request.options.of<VirtualLightOptions>().count = 6;
  request.options.of<IrradianceCacheOptions>() = {.accuracy = 0.5f, .rays = 12};
  request.options.of<GuideOptions>().guide = true;
  return *jobs.emplace_back(name, std::make_unique<RenderJob>(SceneOf(test), request)).second;
}

struct Rendered {
  std::vector<std::uint64_t> sums;
  RenderStats stats;
};
Rendered Render(const FrameView& frame, const RenderJob& job) {
  Film film = job.MakeFilm();
  const FrameResult result = RenderFrame(frame, film);
  return {{film.sums().begin(), film.sums().end()}, result.stats};
}

class Determinism : public testing::TestWithParam<Case> {
 protected:
  const RenderJob& job() const { return Job(GetParam()); }
  // Returns the picture on one thread with the default wave.
  const std::vector<std::uint64_t>& Reference() {
    if (reference_.empty()) {
      FrameView frame = job().frame();
      frame.options.threads = 1;
      reference_ = Render(frame, job()).sums;
    }
    return reference_;
  }

 private:
  std::vector<std::uint64_t> reference_;
};

TEST_P(Determinism, ThreadsDoNotMatter) {
  for (const int threads : {1, 2, 3, 8}) {
    FrameView frame = job().frame();
    frame.options.threads = threads;
    frame.options.wave = 64;  // small tiles, so that there is work to share
    EXPECT_EQ(Render(frame, job()).sums, Reference()) << threads << " threads";
  }
}

// RenderFrame lets TBB and Embree choose the number of threads, at most one per core. Here they are
// threads of the operating system with a worker each, and take the tiles in any order.
TEST_P(Determinism, EightThreadsOnAnyNumberOfCoresDoNotMatter) {
  Film film = job().MakeFilm();
  FrameView learnt = job().frame();
  const EmissionGuide guide = GuideFor(learnt);
  if (!guide.empty()) learnt.Show(&guide);
  EachPassOf(learnt, [&](const FrameView& frame) {
    const std::uint32_t samples = frame.options.samples_per_pixel;
    const std::vector<Tile> tiles =
        CutTiles(frame.camera.width, frame.camera.height, TileSide(samples, 16));
    ASSERT_GE(tiles.size(), 16u);
    std::atomic<std::size_t> next = 0;
    const auto work = [&] {
      const FlushDenormals flush;  // RenderFrame does the same
      RenderOptions options = frame.options;
      options.wave = 64;
      const std::unique_ptr<Worker> worker = MakeWorker(options);
      for (std::size_t i = next++; i < tiles.size(); i = next++) {
        const std::uint32_t total = tiles[i].width * tiles[i].height * samples;
        for (std::uint32_t first = 0; first < total; first += 64) {
          const WaveRange range = {tiles[i], first, std::min(64u, total - first)};
          RenderWave(frame, range, *worker, film);
        }
        std::this_thread::yield();
      }
    };
    std::vector<std::thread> threads;
    for (int i = 0; i < 8; ++i) threads.emplace_back(work);
    for (std::thread& thread : threads) thread.join();
  });
  EXPECT_EQ(std::vector<std::uint64_t>(film.sums().begin(), film.sums().end()), Reference());
}

TEST_P(Determinism, WavesAndBackendsDoNotMatter) {
  std::uint64_t rays[kRayKinds] = {};
  for (const Backend backend : kBackends) {
    for (const std::uint32_t wave : {1u, 17u, 256u, 2048u}) {
      SCOPED_TRACE(std::string(ToString(backend)) + ", wave " + std::to_string(wave));
      FrameView frame = job().frame();
      frame.options.wave = wave;
      frame.tracer.closest = frame.tracer.occlusion = backend;
      const Rendered rendered = Render(frame, job());
      EXPECT_EQ(rendered.sums, Reference());
      EXPECT_EQ(rendered.stats.samples, 37u * 29 * 5);
      for (std::uint32_t kind = 0; kind < kRayKinds; ++kind) {
        if (rays[kind] == 0) rays[kind] = rendered.stats.rays[kind];
        EXPECT_EQ(rendered.stats.rays[kind], rays[kind]);
      }
    }
  }
}

TEST_P(Determinism, RangesOfSamplesAddUp) {
  Film merged = job().MakeFilm();
  for (const auto& [first, count] : {std::pair{3u, 2u}, std::pair{0u, 1u}, std::pair{1u, 2u}}) {
    FrameView frame = job().frame();
    frame.options.first_sample = first;
    frame.options.samples_per_pixel = count;
    Film part = job().MakeFilm();
    RenderFrame(frame, part);
    merged.Merge(part);
  }
  EXPECT_EQ(std::vector<std::uint64_t>(merged.sums().begin(), merged.sums().end()), Reference());
}

TEST_P(Determinism, EveryInstructionSetGivesTheSameBits) {
  Reference();
  ForEachTarget([&] { EXPECT_EQ(Render(job().frame(), job()).sums, Reference()); });
}

TEST(DeterminismOfStrategies, EveryInstructionSetAndCutGivesTheSameBits) {
  Scene scene = BuiltinScene("spheres");
  SetLight(scene, SkyWithSun(64, 32, 100, 0.2));
  scene.portals = PortalsAroundTheOrigin();
  for (const StrategyFactory& factory : Strategies()) {
    SCOPED_TRACE(factory.name);
    JobRequest request = SmallRequest(19, 13, 3);
    request.strategy = factory.name;
    const RenderJob of_path(scene, request);
    const bool emits = CanEmit(of_path.strategy());
    for (const Integrator integrator : {Integrator::kPath, Integrator::kDirect, Integrator::kLight,
                                        Integrator::kBdpt, Integrator::kVcm, Integrator::kVpl}) {
      if (Describe(integrator).has_light_paths() && !emits) continue;
      request.integrator = integrator;
      request.options.light_samples = 2;
      request.options.of<VirtualLightOptions>().count = 3;
      const RenderJob job(scene, request);
      const std::vector<std::uint64_t> reference = Render(job.frame(), job).sums;
      ForEachTarget([&] { EXPECT_EQ(Render(job.frame(), job).sums, reference); });
      for (const std::uint32_t wave : {1u, 17u}) {
        FrameView frame = job.frame();
        frame.options.wave = wave;
        EXPECT_EQ(Render(frame, job).sums, reference) << wave;
      }
    }
  }
}

TEST_P(Determinism, SeedsGiveOtherPictures) {
  FrameView frame = job().frame();
  frame.options.seed = 1;
  EXPECT_NE(Render(frame, job()).sums, Reference());
}

INSTANTIATE_TEST_SUITE_P(
    Builtin, Determinism,
    testing::Values(Case{"gallery", Integrator::kPath}, Case{"gallery", Integrator::kDirect},
                    Case{"spheres", Integrator::kPath}, Case{"spheres", Integrator::kDirect},
                    Case{"painted", Integrator::kPath}, Case{"painted", Integrator::kDirect},
                    Case{"screens", Integrator::kPath}, Case{"screens", Integrator::kDirect},
                    Case{"lamps", Integrator::kPath}, Case{"lamps", Integrator::kDirect},
                    Case{"gallery", Integrator::kLight}, Case{"painted", Integrator::kLight},
                    Case{"screens", Integrator::kLight}, Case{"lamps", Integrator::kLight},
                    Case{"gallery", Integrator::kBdpt}, Case{"painted", Integrator::kBdpt},
                    Case{"screens", Integrator::kBdpt}, Case{"lamps", Integrator::kBdpt},
                    Case{"painted", Integrator::kPhoton}, Case{"screens", Integrator::kPhoton},
                    Case{"lamps", Integrator::kPhoton}, Case{"painted", Integrator::kVcm},
                    Case{"screens", Integrator::kVcm}, Case{"lamps", Integrator::kVcm},
                    Case{"painted", Integrator::kVpl}, Case{"screens", Integrator::kVpl},
                    Case{"lamps", Integrator::kVpl}, Case{"gallery", Integrator::kIrradianceCache},
                    Case{"screens", Integrator::kIrradianceCache},
                    Case{"lamps", Integrator::kIrradianceCache}),
    [](const auto& test) {
      std::string name = test.param.scene + "_" + std::string(ToString(test.param.integrator));
      std::replace(name.begin(), name.end(), '-', '_');
      return name;
    });

// The files are identical too: they do not record how the picture was computed.
TEST_F(Program, WritesTheSameBytesWhateverTheThreadsWaveBackendAndNames) {
  const std::string picture = "render spheres --size 40x30 --spp 3 --seed 9 -q";
  ASSERT_EQ(Run(picture + " -o a.exr --threads 1").exit_code, 0);
  ASSERT_EQ(
      Run(picture + " -o other.name.exr --threads 3 --wave 33 --backend single --stats s.json")
          .exit_code,
      0);
  ASSERT_EQ(Run(picture + " --backend packet").exit_code, 0);
  for (const char* const name : {"other.name", "spheres"}) {
    EXPECT_TRUE(Bytes("a.exr") == Bytes(std::string(name) + ".exr")) << name;
    EXPECT_TRUE(Bytes("a.png") == Bytes(std::string(name) + ".png")) << name;
  }
  ASSERT_EQ(Run("render spheres --size 40x30 --spp 3 --seed 10 -q -o b.exr").exit_code, 0);
  EXPECT_FALSE(Bytes("a.png") == Bytes("b.png"));
}

TEST_F(Program, WritesTheSameBytesOfLightPathsToo) {
  for (const std::string integrator :
       {"bdpt", "photon --photons 900 --caustic-photons 0 --progressive 3 --gather 0", "vcm",
        "vpl --vpls 7"}) {
    SCOPED_TRACE(integrator);
    const std::string picture =
        "render three-spheres --size 21x15 --spp 3 --guide -q --integrator " + integrator;
    ASSERT_EQ(Run(picture + " -o a.exr --threads 1").exit_code, 0);
    ASSERT_EQ(Run(picture + " -o b.exr --threads 8 --wave 256").exit_code, 0);
    EXPECT_TRUE(Bytes("a.exr") == Bytes("b.exr"));
  }
}

}  // namespace
}  // namespace skywave
