// Vertex connection and merging (Georgiev, Krivanek, Davidovic and Slusallek 2012). It adds one
// technique to bidirectional path tracing: every surface of the eye is merged with the light
// vertices of a first pass (passes/merging_pass.cc) that are near it. The stage order is that of
// bdpt.cc.
#include <fmt/format.h>

#include "base/error.h"
#include "wavefront/integrator.h"
#include "wavefront/integrators/bdpt.h"
#include "wavefront/passes/merging_pass.h"

namespace skywave {
namespace {

void Check(const RenderOptions& options) {
  CheckConnections(options);
  if (options.photons.indirect == 0) {
    throw OptionError("photons", "0",
                      "`integrator vcm` merges with light vertices, which are its photons; without "
                      "them it is `integrator bdpt`");
  }
}

void CheckScene(const RenderOptions& options, const Geometry&, const SceneSphere& sphere) {
  if (options.photons.distance > sphere.radius) {
    throw OptionError("photon-distance", fmt::format("{}", options.photons.distance),
                      fmt::format("`integrator vcm` would merge what is farther apart than half of "
                                  "the scene, whose radius is {}",
                                  sphere.radius));
  }
}

void AddTables(const RenderOptions& options, Worker& worker) {
  AddConnectionTables(options, worker);
  worker.merging.emplace();
}

void ForEachPass(const FrameView& frame, WorkerPool& pool, PhotonCounts& counts,
                 const RenderPass& render) {
  const MergePlan plan = PlanMerging(frame, pool);
  const auto trace = [&](FrameView& view, const PhotonPass& pass) {
    view.eta_vcm = plan.MergedArea(pass);
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
      .stores = StoredLight::kVertices,
      .pass_each_sample = true,
      .check = Check,
      .check_scene = CheckScene,
      .add_tables = AddTables,
      .for_each_pass = ForEachPass,
      .render_wave = RenderBdptWave};
}

}  // namespace skywave
