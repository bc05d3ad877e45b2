// Vertex connection and merging (Georgiev, Krivanek, Davidovic and Slusallek 2012). It adds one
// technique to bidirectional path tracing: every surface of the eye is merged with the light
// vertices of a first pass (passes/merging_pass.cc) that are near it. The stage order is that of
// bdpt.cc.
#include <fmt/format.h>

#include "base/error.h"
#include "wavefront/integrator.h"
#include "wavefront/integrators/bdpt.h"
#include "wavefront/passes/merging_pass.h"
#include "wavefront/passes/photon_options.h"
#include "wavefront/stages/bidirectional.h"

namespace skywave {
namespace {

void Check(const RenderOptions& options) {
  CheckConnections(options);
  if (options.of<PhotonOptions>().indirect == 0) {
    throw OptionError("photons", "0",
                      "`integrator vcm` merges with light vertices, which are its photons; without "
                      "them it is `integrator bdpt`");
  }
  CheckPhotonPasses(options, /*vertices=*/true);
}

void CheckScene(const RenderOptions& options, const Geometry&, const SceneSphere& sphere) {
  const float distance = options.of<PhotonOptions>().distance;
  if (distance > sphere.radius) {
    throw OptionError("photon-distance", fmt::format("{}", distance),
                      fmt::format("`integrator vcm` would merge what is farther apart than half of "
                                  "the scene, whose radius is {}",
                                  sphere.radius));
  }
}

void AddTables(const RenderOptions& options, Worker& worker) {
  AddConnectionTables(options, worker);
  worker.tables.Add<MergeTables>();
}

void ForEachPass(const FrameView& frame, WorkerPool& pool, PhotonCounts& counts,
                 const RenderPass& render) {
  const MergePlan plan = PlanMerging(frame, pool);
  Merging merging;
  const auto trace = [&](FrameView& view, const PhotonPass& pass) {
    merging.eta_vcm = plan.MergedArea(pass);
    view.Show(&merging);
    PhotonMaps maps;
    maps.indirect = TraceVertices(view, plan, pass, pool);
    return maps;
  };
  ForEachPhotonPass(frame, trace, counts, render);
}

}  // namespace

IntegratorDescriptor VcmIntegrator() {
  return {
      .help = "bdpt with merging: caustics in mirrors and behind glass too; converges with `spp`",
      .light_paths = LightPaths::kStrategy,
      .has_splats = true,
      .pass_each_sample = true,
      .options = VertexOptionTable,
      .check = Check,
      .check_scene = CheckScene,
      .add_tables = AddTables,
      .for_each_pass = ForEachPass,
      .describe_passes = DescribePhotons,
      .render_wave = RenderBdptWave};
}

}  // namespace skywave
