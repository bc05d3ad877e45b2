// A render that is interrupted at any wave, and that goes on from what was kept, has the bits of
// one that is not interrupted.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <thread>
#include <utility>

#include "tests/support/painted_scene.h"
#include "tests/support/render_scenes.h"
#include "wavefront/policies/emission_pilot.h"
#include "wavefront/records/photon_map.h"
#include "wavefront/records/virtual_lights.h"
#include "wavefront/render.h"
#include "wavefront/worker.h"

namespace skywave {
namespace {

constexpr int kWidth = 37, kHeight = 29;
constexpr std::uint32_t kSamples = 5;

struct Case {
  const char* name;
  Integrator integrator;
  const char* layers;  // all that the integrator keeps
  void (*set)(JobRequest&);
};
void PrintTo(const Case& test, std::ostream* out) { *out << test.name; }

constexpr char kOfPaths[] =
    "albedo,normal,shading-normal,depth,position,uv,object-id,material-id,coverage,samples,"
    "variance,direct,indirect";
constexpr char kOfPhotons[] =
    "albedo,normal,shading-normal,depth,position,uv,object-id,material-id,coverage,samples,"
    "variance";
constexpr char kOfHits[] =
    "albedo,normal,shading-normal,depth,position,uv,object-id,material-id,coverage,samples";

RenderJob MakeJob(const Case& test) {
  JobRequest request = SmallRequest(kWidth, kHeight, kSamples);
  request.integrator = test.integrator;
  request.max_depth = 4;
  request.options.aovs = *ParseAovs(test.layers);
  request.options.of<PhotonOptions>().indirect = request.options.of<PhotonOptions>().caustic = 1000;
  test.set(request);
  Scene scene = PaintedScene();
  scene.lights = {SlantingSpot(), SlantingSun()};
  return RenderJob(std::move(scene), request);
}

Film Rendered(const RenderJob& job, const RenderControl& control = {}) {
  Film film = job.MakeFilm();
  RenderFrame(job.frame(), film, control);
  return film;
}

// Sets `flag` a random time from now on, unless it goes out of scope before.
class Later {
 public:
  Later(std::atomic<bool>& flag, std::chrono::microseconds time)
      : thread_([this, &flag, end = std::chrono::steady_clock::now() + time] {
          while (!over_ && std::chrono::steady_clock::now() < end) std::this_thread::yield();
          if (!over_) flag = true;
        }) {}
  ~Later() {
    over_ = true;
    thread_.join();
  }

 private:
  std::atomic<bool> over_ = false;
  std::thread thread_;
};

class Resume : public testing::TestWithParam<Case> {};

TEST_P(Resume, GivesTheBitsOfOneRender) {
  const RenderJob job = MakeJob(GetParam());
  const auto start = std::chrono::steady_clock::now();
  const std::string expected = Rendered(job).PackPicture();
  const auto time = std::chrono::duration_cast<std::chrono::microseconds>(
      std::chrono::steady_clock::now() - start);

  std::mt19937 random(7);
  int canceled = 0, paused = 0;
  for (int round = 0; round < 3; ++round) {
    std::pair<std::string, RenderState> kept = {job.MakeFilm().PackPicture(), {}};
    std::pair<std::string, RenderState> of_pause;
    for (bool complete = false; !complete;) {
      // Everything but the bytes and the state is made anew.
      Film film = job.MakeFilm();
      film.UnpackPicture(kept.first);
      RenderState state = kept.second;
      FrameView frame = job.frame();
      frame.options.threads = int(1 + random() % 3);
      frame.options.wave = 16u << (random() % 4);
      Progress progress;
      RenderControl control = {.progress = &progress, .at_pause = [&](const RenderState& at) {
                                 ++paused;
                                 of_pause = {film.PackPicture(), at};
                               }};
      const bool interrupt = canceled < 8 * (round + 1);
      std::atomic<int> tiles = interrupt ? int(1 + random() % 3) : 0;
      control.on_tile = [&](const Tile&, std::uint32_t) {
        if (--tiles == 0) progress.cancel = true;
      };
      progress.pause = random() % 4 == 0;
      const auto soon = [&] { return time / (1 + random() % 8); };
      const Later pause(progress.pause, soon());
      std::optional<Later> cancel;
      if (interrupt && random() % 2 == 0) cancel.emplace(progress.cancel, soon());
      try {
        EXPECT_EQ(RenderFrame(frame, film, state, control).samples_per_pixel, kSamples);
        complete = true;
      } catch (const RenderCanceled&) {
        ++canceled;
      }
      kept = {film.PackPicture(), state};
    }
    EXPECT_TRUE(kept.first == expected);
    // What was seen in the last pause can be resumed as well.
    if (of_pause.first.empty()) continue;
    Film film = job.MakeFilm();
    film.UnpackPicture(of_pause.first);
    RenderFrame(job.frame(), film, of_pause.second);
    EXPECT_TRUE(film.PackPicture() == expected);
  }
  EXPECT_GE(canceled, 6);
  EXPECT_GE(paused, 1);
}

TEST_P(Resume, StepsDoNotMatter) {
  const RenderJob job = MakeJob(GetParam());
  const std::string expected = Rendered(job).PackPicture();
  for (const std::uint32_t step : {1u, 2u, 4u}) {
    const auto next_stop = [&](std::uint32_t done) { return done + step; };
    EXPECT_TRUE(Rendered(job, {.next_stop = next_stop}).PackPicture() == expected) << step;
  }
  // A render that ends early has the first samples of the picture and no others.
  const auto two = [](std::uint32_t done) { return done < 2 ? done + 1 : done; };
  FrameView frame = job.frame();
  frame.options.picture_samples = {0, kSamples};
  frame.options.samples_per_pixel = 2;
  Film first = job.MakeFilm();
  RenderFrame(frame, first);
  EXPECT_TRUE(Rendered(job, {.next_stop = two}).PackPicture() == first.PackPicture());
}

INSTANTIATE_TEST_SUITE_P(
    Integrators, Resume,
    testing::Values(
        Case{"path", Integrator::kPath, "all", [](JobRequest&) {}},
        Case{"split", Integrator::kPath, kOfPaths,
             [](JobRequest& request) {
               request.options.bsdf_samples = 2;
               request.options.light_samples = 2;
             }},
        Case{"direct", Integrator::kDirect, "all",
             [](JobRequest& request) { request.options.light_samples = 3; }},
        Case{"light", Integrator::kLight, kOfHits, [](JobRequest&) {}},
        Case{"guided_light", Integrator::kLight, kOfHits,
             [](JobRequest& request) { request.options.of<GuideOptions>().guide = true; }},
        Case{"bdpt", Integrator::kBdpt, kOfHits, [](JobRequest&) {}},
        Case{"photon", Integrator::kPhoton, kOfPhotons, [](JobRequest&) {}},
        Case{"photon_passes", Integrator::kPhoton, kOfPhotons,
             [](JobRequest& request) { request.options.of<PhotonOptions>().passes = 3; }},
        Case{"vpl", Integrator::kVpl, kOfPhotons,
             [](JobRequest& request) { request.options.of<VirtualLightOptions>().count = 5; }},
        Case{"vcm", Integrator::kVcm, kOfHits, [](JobRequest&) {}},
        Case{"vcm_passes", Integrator::kVcm, kOfHits,
             [](JobRequest& request) { request.options.of<PhotonOptions>().passes = 2; }}),
    [](const auto& test) { return std::string(test.param.name); });

// Every camera ray hits a wall, so the layer coverage knows how many samples a pixel has.
TEST(SamplesByPixel, MatchTheFilm) {
  Scene scene;
  Place(scene, Quad(4), AddLambert(scene, "wall", glm::vec3(0.5f)), {0, 0, 0}, 0);
  scene.camera = LookAtCamera({0, 1, 0}, {0, 0, 0}, {0, 0, 1}, 60, false);
  SetConstantLight(scene, 1);
  JobRequest request = SmallRequest(101, 83, 6);
  request.crop = CropWindow{13, 7, kWidth, kHeight};  // it begins within blocks of beams
  request.options.aovs = *ParseAovs("coverage");
  const RenderJob job(scene, request);
  FrameView frame = job.frame();
  frame.options.wave = 48;
  const std::unique_ptr<Worker> worker = MakeWorker(frame.options);
  const FilmArea area = job.MakeFilm().layout().area;
  std::mt19937 random(11);
  for (const SampleRange step : {SampleRange{0, 1}, SampleRange{0, 6}, SampleRange{3, 5}}) {
    // Each tile has come to some wave.
    Film film = job.MakeFilm();
    RenderState state = {.step = step, .tile_side = 16, .rows = {}};
    for (const Tile& tile : CutTiles(frame.camera.width, frame.camera.height, 16)) {
      const auto render = [&](const SampleRange& samples, std::uint64_t rows) {
        frame.options.first_sample = samples.first;
        frame.options.samples_per_pixel = samples.count();
        for (std::uint64_t row = 0; row < rows; row += 48) {
          const auto count = std::uint32_t(std::min<std::uint64_t>(48, rows - row));
          RenderWave(frame, {tile, row, count}, *worker, film);
        }
      };
      const std::uint64_t all = std::uint64_t{tile.width} * tile.height;
      render({0, step.first}, all * step.first);
      state.rows.push_back(random() % (all * step.count() / 48 + 1) * 48);
      render(step, state.rows.back());
    }
    frame.options.first_sample = 0;
    const std::vector<std::uint32_t> samples = SamplesByPixel(frame, state);
    ASSERT_EQ(samples.size(), std::size_t(area.width) * std::size_t(area.height));
    const NamedChannel hits = film.ResolveAovs(1)[0];
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        const int pixel = (area.picture.y + y) * area.width + area.picture.x + x;
        ASSERT_EQ(float(samples[std::size_t(pixel)]), hits.values[std::size_t(y * kWidth + x)])
            << x << ", " << y;
      }
    }
  }
}

}  // namespace
}  // namespace skywave
