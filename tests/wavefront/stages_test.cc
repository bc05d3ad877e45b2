// Tests the data that the stages pass to the kernels.
#include "wavefront/stages/stages.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <optional>
#include <set>
#include <utility>

#include "kernels/camera.h"
#include "kernels/sampler.h"
#include "tests/support/render_scenes.h"
#include "wavefront/render.h"
#include "wavefront/stages/path_stages.h"
#include "wavefront/worker.h"

namespace skywave {
namespace {

// Every eight rows of any wave are one sample of a block of 4 x 2 pixels of the whole film, and the
// waves together hold every sample of every block once.
TEST(GenerateStage, BeamsAreBlocksOfTheWholeFilm) {
  Scene scene;
  AddLambert(scene, "matt", glm::vec3(0.5f));
  Place(scene, Quad(1), 0, glm::vec3(0));
  SetConstantLight(scene, 1);
  constexpr std::uint32_t kSamples = 5, kFirst = 3;
  for (const std::optional<CropWindow>& crop :
       {std::optional<CropWindow>(), std::optional(CropWindow{7, 5, 20, 9})}) {
    JobRequest request = SmallRequest(37, 29, kSamples);
    request.crop = crop;
    const RenderJob job(scene, request);
    for (const std::uint32_t wave : {8u, 24u, 2048u}) {
      FrameView frame = job.frame();
      frame.options.first_sample = kFirst;
      const CameraView& camera = frame.camera;
      Worker w(wave);
      std::set<std::array<std::uint32_t, 3>> beams;
      for (const Tile& tile : CutTiles(camera.width, camera.height, TileSide(kSamples, 16))) {
        const std::uint32_t total = tile.width * tile.height * kSamples;
        for (std::uint32_t first = 0; first < total; first += wave) {
          const std::uint32_t n = std::min(wave, total - first);
          GenerateRays(frame, {tile, first, n}, FilmUniforms(w.scratch), LensUniforms(w.scratch),
                       w.paths, w.rays[0]);
          for (std::uint32_t row = 0; row < n; ++row) {
            const std::uint32_t ray = row % kBeamRays, beam = row - ray;
            const auto column = [&](std::uint32_t i) {
              return w.paths->pixel[i] % camera.width + camera.first_column;
            };
            const auto line = [&](std::uint32_t i) {
              return w.paths->pixel[i] / camera.width + camera.first_row;
            };
            ASSERT_EQ(column(beam) % kBeamWidth, 0u);
            ASSERT_EQ(line(beam) % kBeamHeight, 0u);
            ASSERT_EQ(column(row), column(beam) + ray % kBeamWidth);
            ASSERT_EQ(line(row), line(beam) + ray / kBeamWidth);
            ASSERT_EQ(w.paths->sample[row], w.paths->sample[beam]);
            ASSERT_EQ(w.paths->seed[row], PixelSeed(column(row), line(row), 0));
            if (ray > 0) continue;
            ASSERT_TRUE(beams.insert({column(row), line(row), w.paths->sample[row]}).second);
            ASSERT_GE(w.paths->sample[row], kFirst);
            ASSERT_LT(w.paths->sample[row], kFirst + kSamples);
          }
        }
      }
      EXPECT_EQ(beams.size(), camera.width * camera.height / kBeamRays * kSamples);
    }
    EXPECT_EQ(job.frame().camera.width, crop ? 24u : 40u);   // columns 4 to 27
    EXPECT_EQ(job.frame().camera.height, crop ? 10u : 30u);  // rows 4 to 13
    Film film = job.MakeFilm();
    EXPECT_EQ(RenderFrame(job.frame(), film).stats.samples, (crop ? 20u * 9 : 37u * 29) * kSamples);
  }
}

// A BSDF that chooses between lobes gets fresh uniforms at every bounce, not leftovers of another
// queue or bounce.
TEST(ScatterStage, DrawsLobeUniformsForBsdfsThatChooseLobes) {
  Scene scene;
  AddLambert(scene, "matt", glm::vec3(0.5f));
  AddMetal(scene, "Au", 0.4f);
  AddMirror(scene, 1);
  AddGlass(scene, 1.5f);
  Place(scene, Quad(1), 0, glm::vec3(0));
  SetConstantLight(scene, 1);
  const RenderJob job(scene, SmallRequest(4, 4, 4));

  constexpr std::uint32_t kRows = 40;
  constexpr std::pair<BsdfKind, std::uint32_t> kMaterials[] = {{BsdfKind::kConductor, 1},
                                                               {BsdfKind::kDielectric, 3}};
  for (const auto& [kind, material] : kMaterials) {
    SCOPED_TRACE(Bsdfs()[std::size_t(kind)].name);
    EXPECT_TRUE(Bsdfs()[std::size_t(kind)].lobed);
    const auto scatter = [&, kind = kind, material = material](float leftover) {
      Worker worker(kRows);
      SurfaceRanges ranges;
      for (auto k = std::uint32_t(kind); k < kBsdfKinds; ++k) ranges.begin[k + 1] = kRows;
      for (std::uint32_t i = 0; i < kRows; ++i) {
        worker.paths->seed[i] = 17 * i, worker.paths->sample[i] = i;
        worker.surfaces->path[i] = i;
        worker.surfaces->material[i] = material;
        worker.surfaces->ns_y[i] = worker.surfaces->ng_y[i] = worker.surfaces->wo_y[i] = 1;
        for (float* column : {worker.surfaces->throughput_r, worker.surfaces->throughput_g,
                              worker.surfaces->throughput_b, worker.surfaces->color_r,
                              worker.surfaces->color_g, worker.surfaces->color_b}) {
          column[i] = 1;
        }
        worker.scratch.second->u[i] = worker.scratch.second->v[i] = leftover;
      }
      const FrameView frame = job.frame();
      const std::uint32_t n = Scatter(frame, PointsIn(ranges, frame, worker),
                                      {kCameraEnd, /*bounce=*/0}, worker.scratch, worker.rays[0]);
      EXPECT_GT(n, 0u);
      return std::vector<float>(worker.rays[0]->dir_y, worker.rays[0]->dir_y + n);
    };
    EXPECT_EQ(scatter(0.01f), scatter(0.99f));
  }
}

}  // namespace
}  // namespace skywave
