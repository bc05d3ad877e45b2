// Tests borrowed columns: views refer to the promised memory, nothing else shares it, and none of
// it is read after a view has ended.
#include "wavefront/scratch.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "lights/strategies/strategy.h"
#include "scene/builtin/builtin.h"
#include "tests/support/photon_maps.h"
#include "tests/support/random_rows.h"
#include "tests/support/screens_scene.h"
#include "wavefront/flush_denormals.h"
#include "wavefront/integrators/path.h"
#include "wavefront/records/photon_map.h"
#include "wavefront/render.h"
#include "wavefront/worker.h"

namespace skywave {
namespace {

constexpr std::uint32_t kRows = 40;

TEST(Views, PointIntoTheirTables) {
  const Worker w(kRows);
  const Scratch& s = w.scratch;
  EXPECT_EQ(FilmUniforms(s)->u, s.first->u);
  EXPECT_EQ(FilmUniforms(s)->v, s.first->v);
  EXPECT_EQ(LensUniforms(s)->v, s.second->v);
  EXPECT_EQ(MixtureUniforms(s)->u, s.first->u);
  EXPECT_EQ(LightUniforms(s)->v, s.first->v);
  EXPECT_EQ(AimUniforms(s)->u, s.second->u);
  EXPECT_EQ(DirectionUniforms(s)->u, s.first->u);
  EXPECT_EQ(LobeUniforms(s)->u, s.second->u);
  EXPECT_EQ(PixelUniforms(s)->u, s.first->u);
  EXPECT_EQ(SplitRemainder(s)->u, s.second->u);
  EXPECT_EQ(LightReach(s)->distance, s.second->v);
  EXPECT_EQ(LightReach(s)->light, s.second->u);
  EXPECT_EQ(RayQueues(s)->queue, s.words->word);
  EXPECT_EQ(RayKeys(s)->key, s.words->word);
  EXPECT_EQ(LightPlaces(w.hits)->triangle, w.hits->triangle);
  EXPECT_EQ(EmitterHits(w.escaped)->light_pdf, w.escaped->light_pdf);
  EXPECT_EQ(EnvironmentDensities(w.escaped)->light_pdf, w.escaped->light_pdf);
  EXPECT_EQ(ScatteredDirections(w.lights)->dir_z, w.lights->dir_z);
  const CameraRayPoints points(w.surfaces);
  EXPECT_EQ(points->x, w.surfaces->org_x);
  EXPECT_EQ(points.as_surfaces().org_z, w.surfaces->org_z);
  EXPECT_EQ(points.as_surfaces().ng_z, nullptr);
}

// Stages hold these at the same time. Checked builds abort if two of them share a column.
TEST(Views, ViewsOfAStageDoNotOverlap) {
  const Worker w(kRows);
  const Scratch& s = w.scratch;
  {
    const LightUniforms uniforms(s);
    { EXPECT_NE(uniforms->u, SplitRemainder(s)->u); }
    const LightReach reach(s);
    const LightPlaces places(w.hits);
    const RayKeys keys(s);
    EXPECT_NE(uniforms->v, reach->distance);
    EXPECT_NE(uniforms->v, reach->light);
  }
  {
    const FilmUniforms film(s);
    const LensUniforms lens(s);
    EXPECT_NE(film->u, lens->u);
  }
  {
    const LightUniforms uniforms(s);
    const AimUniforms aim(s);
    EXPECT_NE(uniforms->u, aim->u);
  }
  {
    const LensUniforms lens(s);
    const PixelUniforms pixel(s);
    EXPECT_NE(lens->u, pixel->u);
  }
  const MixtureUniforms mixture(s);
  const RayQueues queues(s);
  const LobeUniforms lobe(s);
  EXPECT_NE(mixture->u, lobe->u);
}

TEST(Views, MayHoldNothing) {
  EXPECT_FALSE(LightReach().limited());
  EXPECT_EQ(RayKeys()->key, nullptr);
  EXPECT_TRUE(LightReach(Scratch(kRows)).limited());
}

TEST(Views, MovingTransfersTheColumn) {
  const Scratch s(kRows);
  LightReach reach(s);
  reach->distance[3] = 7;
  const LightReach moved(std::move(reach));
  EXPECT_EQ(moved->distance, s.second->v);
  EXPECT_EQ(moved->distance[3], 7);
  EXPECT_FALSE(std::is_copy_constructible_v<LightReach>);
  EXPECT_FALSE(std::is_move_assignable_v<LightReach>);
}

#ifdef SKYWAVE_CHECKS

std::vector<std::uint32_t> Bits(const float* column, std::uint32_t n) {
  std::vector<std::uint32_t> bits(n);
  std::memcpy(bits.data(), column, n * sizeof(float));
  return bits;
}

TEST(ViewsDeathTest, BorrowingTwiceAborts) {
  const Worker w(kRows);
  const Scratch& s = w.scratch;
  const auto twice = [](const auto&, const auto&) {};
  EXPECT_DEATH(twice(LensUniforms(s), LobeUniforms(s)), "borrowed twice");
  EXPECT_DEATH(twice(FilmUniforms(s), FilmUniforms(s)), "FilmUniforms is borrowed twice");
  const LobeUniforms lobe(s);
  EXPECT_DEATH(LightReach{s}, "LightReach is borrowed twice: LobeUniforms holds it");
  EXPECT_DEATH(SplitRemainder{s}, "SplitRemainder is borrowed twice: LobeUniforms holds it");
  const RayQueues queues(s);
  EXPECT_DEATH(RayKeys{s}, "RayKeys is borrowed twice: RayQueues holds it");
  const EmitterHits hits(w.escaped);
  EXPECT_DEATH(EnvironmentDensities{w.escaped}, "EmitterHits holds it");
  // A part of a column counts as borrowed like the whole.
  const LightPlaces places(w.hits);
  const HitColumns upper = Slice(w.hits.columns(), kRows - 1);
  EXPECT_DEATH((Borrowed<HitColumns>(upper, 1, "upper rows")), "LightPlaces holds it");
  const HitColumns behind = Slice(w.hits.columns(), kRows);
  const Borrowed<HitColumns> padding(behind, 1, "padding");
}

TEST(Views, PoisonTheirColumnsWhenTheyEnd) {
  const Worker w(kRows);
  const Scratch& s = w.scratch;
  const std::vector<std::uint32_t> zeros(kPadRows);
  const auto expect_poison = [&](const float* column) {
    EXPECT_EQ(Bits(column, kRows), std::vector<std::uint32_t>(kRows, kPoisonedFloat));
    EXPECT_EQ(Bits(column + kRows, kPadRows), zeros) << "padding is nobody's";
    EXPECT_TRUE(std::isnan(column[0]));
  };
  { const SplitRemainder remainder(s); }
  expect_poison(s.second->u);
  EXPECT_EQ(s.second->v[0], 0) << "nobody has held it";
  { const LightReach reach(s); }
  expect_poison(s.second->v);
  { const RayKeys keys(s); }
  for (std::uint32_t i = 0; i < kRows; ++i) EXPECT_EQ(s.words->word[i], 0xDEAD0000u + i);
  { const EmitterHits hits(w.escaped); }
  expect_poison(w.escaped->light_pdf);
  EXPECT_EQ(w.escaped->path[5], PoisonedWord(5));
  // A view that has been moved from does nothing when it ends.
  std::optional<LightReach> reach(std::in_place, s);
  {
    const LightReach moved(std::move(*reach));
    std::fill_n(moved->distance, kRows, 3.0f);
    reach.reset();
    EXPECT_EQ(s.second->v[kRows - 1], 3);
  }
  expect_poison(s.second->v);
}

#else

TEST(Views, AreAsSmallAsTheirPointers) {
  EXPECT_EQ(sizeof(LightPlaces), sizeof(HitColumns));
  EXPECT_EQ(sizeof(LightReach), sizeof(ReachColumns));
  EXPECT_TRUE(std::is_trivially_destructible_v<LightPlaces>);
  EXPECT_TRUE(std::is_trivially_move_constructible_v<LightPlaces>);
  const Scratch s(kRows);
  { LensUniforms(s)->u[3] = 7; }
  EXPECT_EQ(LobeUniforms(s)->u[3], 7);
}

#endif

// If lights of A compete with samples of B, the uniforms of B are in t_far of the samples.
TEST(Hybrid, BorrowsTheReachOfItsSamples) {
  Scene scene = BuiltinScene("spheres");
  SetLight(scene, SkyWithSun(64, 32, 100, 0.2));
  JobRequest request = SmallRequest(8, 8, 1);
  request.strategy = "hybrid:pick=power";
  const RenderJob job(scene, request);
  const Worker w(kRows);
  const auto uniforms = RandomUniforms(kRows, 1);
  const ShadePoints points = {.surfaces = w.surfaces,
                              .ranges = w.ranges,
                              .materials = job.frame().geometry->materials(),
                              .paths = w.paths};
  std::fill_n(w.lights->t_far, PaddedRows(kRows), 7.0f);
  job.strategy().Sample(points, uniforms, kRows, {}, w.lights);
  for (std::uint32_t i = 0; i < kRows; ++i) {
#ifdef SKYWAVE_CHECKS
    EXPECT_TRUE(std::isnan(w.lights->t_far[i])) << i;
#else
    EXPECT_GE(w.lights->t_far[i], 0) << i;
    EXPECT_LT(w.lights->t_far[i], 1) << i;
#endif
    EXPECT_GT(w.lights->pdf[i], 0) << i;
  }
}

void FillTables(const Worker& w) {
  const std::uint32_t rows = w.paths.rows();
  FillWithGarbage(w.scratch.first.columns(), rows);
  FillWithGarbage(w.scratch.second.columns(), rows);
  FillWithGarbage(w.scratch.words.columns(), rows);
  FillWithGarbage(w.hits.columns(), rows);
  FillWithGarbage(w.escaped.columns(), rows);
  FillWithGarbage(w.lights.columns(), rows);
  FillWithGarbage(w.surfaces.columns(), rows);
}

// A wave gives the same radiance whatever the columns that it borrows contain: it reads nothing
// that it has not written.
void ExpectSameInGarbage(const RenderJob& job, Integrator integrator, std::uint32_t split = 0) {
  SCOPED_TRACE(testing::Message() << ToString(integrator) << ", split " << split);
  const RenderMethod method = job.MakeMethod(job.request().strategy, integrator);
  FrameView frame = job.frame(method);
  frame.options.bsdf_samples = split;
  frame.options.wave = 200;  // the last wave is smaller
  frame.options.of<PhotonOptions>().passes = 1;
  const Tile tile = {0, 0, 16, 12};
  std::vector<std::uint64_t> sums[2];
  for (const bool garbage : {false, true}) {
    const FlushDenormals flush;
    Film film = job.MakeFilm(integrator);
    const std::unique_ptr<Worker> worker = MakeWorker(frame.options);
    EachPassOf(frame, [&](const FrameView& pass) {
      const std::uint32_t rows = 16 * 12 * pass.options.samples_per_pixel;
      for (std::uint32_t first = 0; first < rows; first += 200) {
        if (garbage) FillTables(*worker);
        Continuations* const continuations = worker->tables.find<Continuations>();
        if (garbage && continuations != nullptr) FillTables(continuations->wave);
        RenderWave(pass, {tile, first, std::min(200u, rows - first)}, *worker, film);
      }
    });
    sums[garbage].assign(film.sums().begin(), film.sums().end());
    EXPECT_EQ(worker->stats.invalid_samples, 0u);
  }
  EXPECT_EQ(sums[0], sums[1]);
}

TEST(Waves, ReadNoValuesOfEarlierWaves) {
  for (const std::string scene : {"materials", "lamps", "screens"}) {
    SCOPED_TRACE(scene);
    JobRequest request = SmallRequest(16, 12, 4);
    request.max_depth = 6;
    request.options.light_samples = 2;
    request.options.of<PhotonOptions>().indirect = request.options.of<PhotonOptions>().caustic =
        1000;
    request.integrator = Integrator::kVcm;
    const RenderJob job(scene == "screens" ? ScreensScene() : BuiltinScene(scene), request);
    ExpectSameInGarbage(job, Integrator::kPath);
    ExpectSameInGarbage(job, Integrator::kPath, /*split=*/2);
    ExpectSameInGarbage(job, Integrator::kDirect);
    ExpectSameInGarbage(job, Integrator::kLight);
    ExpectSameInGarbage(job, Integrator::kBdpt);
    ExpectSameInGarbage(job, Integrator::kPhoton);
    ExpectSameInGarbage(job, Integrator::kVcm);
    ExpectSameInGarbage(job, Integrator::kVpl);
    ExpectSameInGarbage(job, Integrator::kIrradianceCache);
  }
}

}  // namespace
}  // namespace skywave
