// What the stages hand to the kernels.
#include "wavefront/stages.h"

#include <gtest/gtest.h>

#include "kernels/sampler.h"
#include "tests/support/render_scenes.h"
#include "wavefront/worker.h"

namespace skywave {
namespace {

// A BSDF that chooses between lobes gets uniforms of its own at every bounce, not those that
// another queue or bounce left behind.
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
  constexpr float kPoison = 2;
  for (const BsdfKind kind : {BsdfKind::kConductor, BsdfKind::kDielectric}) {
    SCOPED_TRACE(Bsdfs()[std::size_t(kind)].name);
    EXPECT_TRUE(Bsdfs()[std::size_t(kind)].lobed);
    Worker worker(kRows);
    SurfaceRanges ranges;
    for (auto k = std::uint32_t(kind); k < kBsdfKinds; ++k) ranges.begin[k + 1] = kRows;
    for (std::uint32_t i = 0; i < kRows; ++i) {
      worker.paths->seed[i] = 17 * i, worker.paths->sample[i] = i;
      worker.surfaces->path[i] = i;
      worker.surfaces->material[i] = std::uint32_t(kind);
      worker.surfaces->ns_y[i] = worker.surfaces->ng_y[i] = worker.surfaces->wo_y[i] = 1;
      worker.lobe->u[i] = worker.lobe->v[i] = kPoison;
    }
    Scatter(job.frame(), kCameraEnd, worker.paths, worker.surfaces, ranges, 0, /*bounce=*/0,
            worker.uniforms, worker.lobe, worker.rays[0]);
    for (std::uint32_t i = 0; i < kRows; ++i) EXPECT_LT(worker.lobe->u[i], 1.0f) << i;
  }
}

}  // namespace
}  // namespace skywave
