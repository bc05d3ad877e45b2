// Tests guided light paths in whole frames: the pilot's result, and that pictures keep their
// expectation.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <limits>

#include "lights/strategies/strategy.h"
#include "tests/support/emission_guides.h"
#include "tests/support/picture_estimate.h"
#include "tests/support/random_rows.h"
#include "tests/support/render_scenes.h"
#include "tests/support/statistics.h"
#include "wavefront/policies/emission_pilot.h"
#include "wavefront/records/photon_map.h"
#include "wavefront/render.h"
#include "wavefront/stages/light_stages.h"

namespace skywave {
namespace {

// A box with an opening in its roof, seen from inside, on a wide floor, under a sky with a sun; a
// pane of glass covers half of the opening.
Scene Hut() {
  Scene scene;
  const std::uint32_t white = AddLambert(scene, "white", glm::vec3(0.7f));
  Place(scene, Quad(30), AddLambert(scene, "ground", glm::vec3(0.4f)), glm::vec3(0));
  const auto wall = [&](const glm::vec3& centre, const glm::vec3& half) {
    Place(scene, Facetted(RoundedBox(half, 0.01f, 1)), white, centre);
  };
  wall({0, 1, -2}, {2, 1, 0.05f}), wall({0, 1, 2}, {2, 1, 0.05f});
  wall({-2, 1, 0}, {0.05f, 1, 2}), wall({2, 1, 0}, {0.05f, 1, 2});
  wall({-1.2f, 2, 0}, {0.8f, 0.05f, 2}), wall({1.2f, 2, 0}, {0.8f, 0.05f, 2});
  wall({0, 2, -1.2f}, {0.4f, 0.05f, 0.8f}), wall({0, 2, 1.2f}, {0.4f, 0.05f, 0.8f});
  Place(scene, Quad(0.2f), AddMirror(scene, 0.9f), {0.2f, 1.2f, 0});
  scene.camera = LookAtCamera({1.2f, 1.2f, 1.5f}, {-0.3f, 0.5f, -0.4f}, {0, 1, 0}, 70, false);
  SetLight(scene, SkyWithSun(64, 32, 40, 0.2));
  return scene;
}

JobRequest Request(Integrator integrator, std::uint32_t samples = 32) {
  JobRequest request = SmallRequest(32, 24, samples);
  request.integrator = integrator;
  request.max_depth = 4;
  request.options.of<GuideOptions>().guide = true;
  return request;
}

std::vector<float> AllOf(const EmissionGuide& guide) {
  std::vector<float> all = guide.cuts;
  for (const GuideCell& cell : guide.cells) {
    all.insert(all.end(), {cell.gain, cell.even, cell.low[0], cell.high[1]});
  }
  return all;
}

TEST(LearnEmission, DependsOnNothingButTheFilm) {
  const RenderJob job(Hut(), Request(Integrator::kLight));
  const std::vector<float> reference = AllOf(GuideFor(job.frame()));
  ASSERT_FALSE(reference.empty());
  for (const int threads : {1, 3}) {
    EXPECT_EQ(AllOf(GuideFor(job.frame(), threads)), reference);
  }
  FrameView frame = job.frame();
  for (const std::uint32_t wave : {1u, 17u, 2048u}) {
    frame.options.wave = wave;
    EXPECT_EQ(AllOf(GuideFor(frame)), reference) << wave;
  }
  frame.options.first_sample = 7, frame.options.samples_per_pixel = 3;
  EXPECT_EQ(AllOf(GuideFor(frame)), reference);
  JobRequest part = Request(Integrator::kLight);
  part.crop = CropWindow{9, 7, 12, 9};
  const RenderJob of_part(Hut(), part);
  EXPECT_EQ(AllOf(GuideFor(of_part.frame())), reference);
  frame.options.seed = 1;
  EXPECT_NE(AllOf(GuideFor(frame)), reference);
}

TEST(LearnEmission, LeavesStatisticsToTheFrame) {
  const RenderJob job(Hut(), Request(Integrator::kLight, 2));
  std::uint64_t camera_rays[2];
  for (const bool guided : {false, true}) {
    FrameView frame = job.frame();
    frame.options.of<GuideOptions>().guide = guided;
    Film film = job.MakeFilm();
    const FrameResult result = RenderFrame(frame, film);
    camera_rays[guided] = result.stats.rays[0];
    EXPECT_EQ(result.pilots.of("guide").paths > 0, guided);
    EXPECT_EQ(result.pilots.of("guide").samples > 0, guided);
    EXPECT_EQ(result.stats.samples, 32u * 24 * 2);
  }
  EXPECT_EQ(camera_rays[0], camera_rays[1]);
}

// No light enters a closed box, and no surface is visible in the other scene.
TEST(LearnEmission, AcceptsScenesWithoutGuideSamples) {
  Scene box;
  Place(box, Sphere(1, 20), AddLambert(box, "white", glm::vec3(0.7f)), glm::vec3(0));
  SetConstantLight(box, 1);
  box.camera = LookAtCamera({0, 0, 0.5f}, {0, 0, 0}, {0, 1, 0}, 40, false);
  Scene away = box;
  away.camera = LookAtCamera({0, 0, 5}, {0, 0, 9}, {0, 1, 0}, 40, false);
  for (const bool environment_is_seen : {false, true}) {
    const Scene& scene = environment_is_seen ? away : box;
    for (const Integrator integrator : {Integrator::kLight, Integrator::kBdpt}) {
      const RenderJob job(scene, Request(integrator, 4));
      EXPECT_TRUE(GuideFor(job.frame()).empty());
      Film film = job.MakeFilm();
      RenderFrame(job.frame(), film);
      const Image picture = film.Resolve(4);
      EXPECT_EQ(picture.rgb[0] > 0, environment_is_seen);
    }
  }
}

// Returns the fraction of a picture's light paths that enter the hut.
double ShareInside(const RenderJob& job, const EmissionGuide* guide) {
  FrameView frame = job.frame();
  frame.Show<EmissionGuide>(guide);
  Worker worker(2048);
  worker.tables.Add<LightPathTables>(2048);
  StageClock clock(worker.stats);
  StartLightPaths(frame.options, 0, 2048, worker.paths);
  EmitRays(frame, 2048, worker.rays[0], worker, clock);
  double inside = 0;
  const RayColumns& rays = worker.rays[0];
  for (std::uint32_t i = 0; i < 2048; ++i) {
    const double t = (1.9 - rays.org_y[i]) / rays.dir_y[i];
    const double x = rays.org_x[i] + t * rays.dir_x[i], z = rays.org_z[i] + t * rays.dir_z[i];
    inside += rays.dir_y[i] < 0 && std::fabs(x) < 0.5 && std::fabs(z) < 0.5;
  }
  return inside / 2048;
}

TEST(LearnEmission, FindsTheWayIn) {
  JobRequest request = Request(Integrator::kLight);
  request.width = 160, request.height = 120;
  const RenderJob job(Hut(), request);
  const EmissionGuide guide = GuideFor(job.frame());
  EXPECT_LT(ShareInside(job, nullptr), 0.002);
  EXPECT_GT(ShareInside(job, &guide), 0.2);
}

// Whatever the strategy, and also next to lamps, guided rays carry the power of the lights.
TEST(GuidedRays, CarryThePowerOfAllLights) {
  Scene scene = Hut();
  scene.lights = {{.emission = {2, 3, 1}, .position = {-1, 1, 1}}, SlantingSun()};
  for (const char* const strategy : {"importance", "alias", "uniform", "median-cut:pick=power",
                                     "presampled", "hybrid:pick=power"}) {
    SCOPED_TRACE(strategy);
    JobRequest request = Request(Integrator::kLight);
    request.strategy = strategy;
    const RenderJob job(scene, request);
    const EmissionGuide guide = GuideFor(job.frame());
    ASSERT_FALSE(guide.empty());
    EXPECT_EQ(guide.directions != nullptr, job.strategy().unbiased());
    Moments means[2];
    for (const bool guided : {false, true}) {
      for (std::uint32_t seed = 0; seed < 60; ++seed) {
        FrameView frame = job.frame();
        frame.options.seed = seed;
        if (guided) frame.Show<EmissionGuide>(&guide);
        Worker worker(2048);
        worker.tables.Add<LightPathTables>(2048);
        StageClock clock(worker.stats);
        StartLightPaths(frame.options, guided ? 100000 : 0, 2048, worker.paths);
        EmitRays(frame, 2048, worker.rays[0], worker, clock);
        double sum = 0;
        for (std::uint32_t i = 0; i < 2048; ++i) {
          if (worker.rays[0]->t_far[i] >= 0) sum += worker.rays[0]->throughput_g[i];
        }
        means[guided].Add(sum / 2048);
      }
    }
    EXPECT_TRUE(AgreesWith(means[0], means[1], SidakLevel(6)));
  }
}

// The weights of bidirectional paths rely on this: the record of a light path's start is the
// density of light samples in its direction times the density with which light paths arrive along
// it.
TEST(GuidedRays, HaveTheDensityThatTheOtherEndComputes) {
  for (const char* const strategy : {"importance", "uniform", "median-cut:pick=power"}) {
    SCOPED_TRACE(strategy);
    JobRequest request = Request(Integrator::kBdpt);
    request.strategy = strategy;
    const RenderJob job(Hut(), request);
    const EmissionGuide guide = GuideFor(job.frame());
    FrameView frame = job.frame();
    frame.Show<EmissionGuide>(&guide);
    const std::uint32_t n = 2000;
    Worker w(2048);
    w.tables.Add<LightPathTables>(2048);
    StageClock clock(w.stats);
    StartLightPaths(frame.options, 0, n, w.paths);
    EmitRays(frame, n, w.rays[0], w, clock);
    const RayColumns& rays = w.rays[0];
    const EscapeColumns& seen = w.escaped;
    for (std::uint32_t i = 0; i < n; ++i) {
      const Vec dir = Get(i, rays.dir_x, rays.dir_y, rays.dir_z);
      Put(-dir, i, seen.dir_x, seen.dir_y, seen.dir_z);
      Put(Get(i, rays.org_x, rays.org_y, rays.org_z) + 3.0 * dir, i, w.surfaces->org_x,
          w.surfaces->org_y, w.surfaces->org_z);
      w.surfaces->lift[i] = 0;
      seen.pdf[i] = 1, seen.from[i] = i;
    }
    const bool directional = !job.strategy().unbiased();
    const SurfaceRanges ranges;
    frame.strategy->EvaluateEscaped(
        {.surfaces = w.surfaces, .ranges = ranges, .materials = {}, .paths = w.paths}, n, 1, seen);
    std::vector<float> arrival(PaddedRows(n));
    EnvironmentArrivals(frame.sphere, guide.view(),
                        {seen.dir_x, seen.dir_y, seen.dir_z, w.surfaces, seen.from}, n,
                        arrival.data());
    std::uint32_t off = 0;
    for (std::uint32_t i = 0; i < n; ++i) {
      const double light_pdf = directional ? 1 : double(seen.light_pdf[i]);
      const double pdf = light_pdf * double(arrival[i]);
      off += !(std::fabs(double(w.of<LightPathTables>().emission->pdf[i]) - pdf) < 1e-4 * pdf);
      ASSERT_NEAR(w.of<LightPathTables>().emission->light_pdf[i], light_pdf, 1e-4 * light_pdf);
    }
    // A few float positions fall on the other side of a cut.
    EXPECT_LT(off, n / 200);
  }
}

PictureEstimate Estimate(const Scene& scene, Integrator integrator, bool guided, int runs,
                         std::uint32_t samples, bool lens = false) {
  JobRequest request = Request(integrator, samples);
  if (lens) request.camera.lens_radius = 0.05f;
  request.options.of<GuideOptions>().guide = guided;
  const RenderJob job(scene, request);
  return EstimateFromEngine(job, runs, 300 + 100 * std::uint32_t(integrator) + guided);
}

TEST(GuidedPictures, MatchPathTracing) {
  constexpr int kRuns = 12;
  for (const bool lamps : {false, true}) {
    SCOPED_TRACE(lamps);
    Scene scene = Hut();
    // The mirror is removed because not all integrators see what is in it.
    scene.meshes.pop_back();
    if (lamps)
      scene.lights = {SlantingSun(), {.emission = {0.2f, 0.3f, 0.2f}, .position = {0, 1, 0}}};
    const PictureEstimate path = Estimate(scene, Integrator::kPath, true, kRuns, 128, lamps);
    for (const Integrator integrator : {Integrator::kLight, Integrator::kBdpt}) {
      SCOPED_TRACE(ToString(integrator));
      EXPECT_TRUE(
          SamePicture(Estimate(scene, integrator, true, kRuns, 32, lamps), path, SidakLevel(8)));
    }
  }
}

TEST(GuidedPictures, HaveTheSameExpectationOverMirrorsAndLessNoise) {
  constexpr int kRuns = 12;
  const PictureEstimate even = Estimate(Hut(), Integrator::kBdpt, false, kRuns, 64);
  const PictureEstimate guided = Estimate(Hut(), Integrator::kBdpt, true, kRuns, 64);
  EXPECT_TRUE(SamePicture(even, guided, SidakLevel(8)));
  double variance[2] = {};
  for (std::size_t i = 0; i < even.variance.size(); ++i) {
    variance[0] += even.variance[i], variance[1] += guided.variance[i];
  }
  EXPECT_LT(variance[1], 0.5 * variance[0]);
}

// With photons, seen directly or by a final gather, more passes come closer to paths.
TEST(GuidedPictures, ConvergeToPathTracingByPassesOfPhotons) {
  Scene scene = Hut();
  scene.meshes.pop_back();
  const auto estimate = [&](const JobRequest& request, int runs) {
    return MeanOfBlocks(EstimateFromEngine(RenderJob(scene, request), runs, 40), 4);
  };
  const PictureEstimate paths = estimate(Request(Integrator::kPath, 256), 8);
  const auto difference = [&](std::uint32_t gather, std::uint32_t passes) {
    JobRequest request = Request(Integrator::kPhoton, 8 * passes);
    // Whole disks of a final gather must not extend under the walls to the sunlit ground, where
    // guided photons are few and bright.
    request.options.of<PhotonOptions>() = {.indirect = 8000,
                                           .distance = gather > 0 ? 0.09f : 0.3f,
                                           .gather = gather,
                                           .passes = passes};
    return RelativeDifference(estimate(request, 1), paths);
  };
  for (const std::uint32_t gather : {0u, 1u}) {
    const double first = difference(gather, 2), last = difference(gather, 16);
    std::printf("gather %u: %.3f, then %.3f\n", gather, first, last);
    EXPECT_LT(last, 0.6 * first);
    EXPECT_LT(last, 0.15);
  }
}

// The bias of the radius vanishes in the noise, in mirrors too.
TEST(GuidedPictures, MatchPathTracingWithMergedVertices) {
  constexpr int kRuns = 12;
  JobRequest request = Request(Integrator::kVcm, 24);
  request.options.of<PhotonOptions>().distance = 0.03f;
  request.options.of<PhotonOptions>().passes = 1;
  EXPECT_TRUE(SameAsPaths(Hut(), request, kRuns, SidakLevel(8)));
}

}  // namespace
}  // namespace skywave
