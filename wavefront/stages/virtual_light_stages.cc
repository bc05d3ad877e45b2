#include "wavefront/stages/virtual_light_stages.h"

#include <algorithm>

#include "kernels/accumulate.h"
#include "kernels/light_paths/bidirectional.h"
#include "kernels/light_paths/flux.h"
#include "wavefront/records/virtual_lights.h"
#include "wavefront/stages/bidirectional.h"
#include "wavefront/stages/path_stages.h"

namespace skywave {
namespace {

// Evaluates the current surfaces towards the light, and the light towards them.
void EvaluateEnds(const MaterialView& materials, std::uint32_t kind, std::uint32_t n, Worker& w) {
  VirtualLightTables& t = w.of<VirtualLightTables>();
  ForEachBsdf(w.ranges, kDenseBsdfs, [&](const BsdfKernels& bsdf, const BsdfRows& at) {
    const SurfaceColumns rows = Slice(w.surfaces.columns(), at.begin);
    const LightColumns to = Slice(w.lights.columns(), at.begin);
    bsdf.evaluate(rows, materials, to, at.n, Slice(t.seen.forward.columns(), at.begin));
    if (bsdf.transmits) MoveToSide(to, at.n, rows);
  });
  SurfaceRanges ranges;
  std::fill(ranges.begin + kind + 1, ranges.begin + kBsdfKinds + 1, n);
  if (Bsdfs()[kind].transmits) MoveToSide(t.to_eye, n, t.light.surfaces);
  EvaluateBackward(materials, t.light.surfaces, ranges, t.to_eye, t.turned,
                   t.seen_by_light.backward);
}

// Divides what rows [0, n) gain by the number of light paths, and bounds the geometry term.
void BoundGains(const VirtualLights& set, std::uint32_t n, const LightColumns& lights) {
  const auto share = float(1 / double(set.light_paths));
  const float bound2 = set.distance * set.distance;
  for (std::uint32_t i = 0; i < n; ++i) {
    const float distance2 = lights.t_far[i] * lights.t_far[i];
    const float scale = distance2 < bound2 ? share * (distance2 / bound2) : share;
    lights.r[i] *= scale, lights.g[i] *= scale, lights.b[i] *= scale;
  }
}

}  // namespace

void AddVirtualLights(const FrameView& frame, std::uint32_t bounce, Worker& w, StageClock& clock) {
  const std::uint32_t n = w.ranges.light_sampled();
  if (n == 0) return;
  const VirtualLights& set = *frame.find<VirtualLights>();
  VirtualLightTables& t = w.of<VirtualLightTables>();
  const SurfaceColumns& s = w.surfaces;
  // The light is repeated for every surface, in its row.
  for (std::uint32_t i = 0; i < n; ++i) t.light.row_of_path->index[s.path[i]] = i;
  const ConnectionEnds ends = {t.seen.forward, t.seen.backward, t.seen_by_light.forward,
                               t.seen_by_light.backward};
  // Their rays have numbers after those of light samples.
  std::uint32_t event =
      SamplePair(bounce, SampleUse::kLight) + kPairBlock * frame.light_shares().total();
  for (const VirtualLight& light : set.lights) {
    event += kPairBlock;
    if (light.depth + bounce + 1 > frame.options.max_depth) continue;
    RepeatVirtualLight(light, n, t.light.surfaces);
    AimAtVertices(s, n, t.light.view(), t.partner->index, w.lights, t.to_eye);
    EvaluateEnds(frame.geometry->materials(), light.kind, n, w);
    JoinVertices(s, t.light.at, n, {.mis = {.enabled = false}}, t.light.view(), t.partner->index,
                 ends, w.lights);
    BoundGains(set, n, w.lights);
    TraceLights(frame, ShadowTarget::kLight,
                MakeRayKeys(frame, w.paths, s.path, n, event, w.scratch), w, clock);
    AddUnoccludedRadiance(w.lights, s.path, n, w.paths);
    clock.Lap(Stage::kAccumulate);
  }
}

}  // namespace skywave
