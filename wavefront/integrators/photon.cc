// Photon mapping (Jensen 1996, T 4.3). A first pass stores photons (passes/photon_pass.cc). The
// second one takes direct light as `direct` does. At the surfaces that take light samples, caustics
// come from the caustic map and other light from the indirect map, which is looked up there or
// where the rays of a final gather hit the next surfaces, or later ones behind short rays. BSDFs
// with a density count as diffuse, however narrow their lobe, and mirrors and glass as specular.
// There are no more than max_depth surfaces on both sides of a photon together.
#include <algorithm>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "base/error.h"
#include "wavefront/integrator.h"
#include "wavefront/passes/footprint.h"
#include "wavefront/passes/photon_options.h"
#include "wavefront/passes/photon_pass.h"
#include "wavefront/paths/final_gather.h"
#include "wavefront/stages/light_stages.h"
#include "wavefront/stages/path_stages.h"
#include "wavefront/stages/photon_stages.h"

namespace skywave {
namespace {

void RenderPhotonWave(const FrameView& frame, const WaveRange& range, Worker& w, Film& film) {
  StageClock clock(w.stats);
  soa::Table<RayColumns>*rays = &w.rays[0], *next = &w.rays[1];
  GenerateRays(frame, range, FilmUniforms(w.scratch), LensUniforms(w.scratch), w.paths, *rays);
  clock.Lap(Stage::kGenerate);

  const PhotonMaps& maps = *frame.find<PhotonMaps>();
  std::uint32_t n = range.count, bounce = 0;
  bool delta_rays = true;
  for (; n > 0; ++bounce) {
    if (bounce == frame.options.max_depth || !delta_rays) {
      IntersectLights(frame, *rays, n, bounce, w, clock);
      break;
    }
    IntersectSurfaces(frame, *rays, n, bounce, /*only_delta=*/true, w, clock);
    KeepAovs(frame, bounce, range.count, w, film, clock);
    LightSurfaces(frame, bounce, w, clock);
    const std::uint32_t left = frame.options.max_depth - bounce;
    AddPhotons(frame, maps.caustic, left, w, clock);
    if (frame.options.of<PhotonOptions>().gather > 0) {
      GatherPhotons(frame, bounce, w, clock);
    } else {
      AddPhotons(frame, maps.indirect, left, w, clock);
    }
    n = ScatterSurfaces(frame, kCameraEnd, frame.first_bsdf_that_sees_light(), bounce, *next, w,
                        clock);
    delta_rays = w.ranges.total() > w.ranges.light_sampled();
    std::swap(rays, next);
  }
  FinishWave(frame, range.count, bounce, w, film, clock);
}

void Check(const RenderOptions& options) {
  const auto& photons = options.of<PhotonOptions>();
  if (photons.indirect == 0 && photons.caustic == 0) {
    throw OptionError({{"photons", "0"}, {"caustic-photons", "0"}},
                      "`integrator photon` needs photons; for direct light alone use `integrator "
                      "direct`");
  }
  CheckPhotonPasses(options, /*vertices=*/false);
}

void CheckScene(const RenderOptions& options, const Geometry& geometry, const SceneSphere&) {
  if (options.of<PhotonOptions>().indirect == 0 && !geometry.has_deltas()) {
    throw OptionError("photons", "0",
                      "without mirrors and glass there are no caustics, so `integrator photon` "
                      "would store nothing; for direct light alone use `integrator direct`");
  }
}

void AddTables(const RenderOptions& options, Worker& worker) {
  AddLightPathTables(options, worker);
  worker.tables.Add<PhotonTables>(options.wave, options.of<PhotonOptions>().neighbors);
}

// The radii of the first pass in which there are photons of a kind, from which those of all passes
// follow. A part of a picture may begin with a later pass, so earlier ones are asked too.
class FirstRadii {
 public:
  // None is larger than `largest`.
  FirstRadii(const RenderOptions& options, const Geometry& geometry, float largest)
      : largest_(largest),
        passes_(PhotonPasses(options)),
        missing_caustic_(options.of<PhotonOptions>().caustic > 0 && geometry.has_deltas()),
        missing_indirect_(options.of<PhotonOptions>().indirect > 0) {}

  // Returns the maps of `pass`, traced by `trace`, with their radii.
  template <class Trace>
  PhotonMaps MapsOf(const PhotonPass& pass, const Trace& trace) {
    std::optional<PhotonMaps> maps;
    for (; missing() && passes_[asked_].samples.first <= pass.samples.first; ++asked_) {
      maps = trace(passes_[asked_]);
      Take(std::min(maps->caustic.radius, largest_), missing_caustic_, caustic_);
      Take(std::min(maps->indirect.radius, largest_), missing_indirect_, indirect_);
      if (passes_[asked_].samples != pass.samples) maps.reset();
    }
    if (!maps) maps = trace(pass);
    maps->caustic.radius = caustic_ * pass.shrink;
    maps->indirect.radius = indirect_ * pass.shrink;
    maps->indirect.near = std::min(maps->indirect.near, maps->indirect.radius);
    return std::move(*maps);
  }

 private:
  bool missing() const {
    return (missing_caustic_ || missing_indirect_) && asked_ < passes_.size();
  }
  static void Take(float found, bool& is_missing, float& radius) {
    if (is_missing && found > 0) radius = found, is_missing = false;
  }

  float largest_;
  std::vector<PhotonPass> passes_;
  std::size_t asked_ = 0;
  bool missing_caustic_, missing_indirect_;
  float caustic_ = 0, indirect_ = 0;
};

void ForEachPass(const FrameView& frame, WorkerPool& pool, PhotonCounts& counts,
                 const RenderPass& render) {
  const auto& photons = frame.options.of<PhotonOptions>();
  const bool bounded = photons.progressive() && photons.distance <= 0;
  FirstRadii radii(frame.options, *frame.geometry,
                   bounded ? PixelRadius(frame, pool) : std::numeric_limits<float>::infinity());
  const auto trace = [&](const FrameView& view, const PhotonPass& pass) {
    return radii.MapsOf(pass, [&](const PhotonPass& one) { return TracePhotons(view, one, pool); });
  };
  ForEachPhotonPass(frame, trace, counts, render);
}

}  // namespace

IntegratorDescriptor PhotonIntegrator() {
  return {.help = "photon maps with a final gather; biased, `progressive N` converges",
          .light_samples = LightSamples::kRequested,
          .light_paths = LightPaths::kAny,
          .biased = true,
          .mixes_light = true,
          .options = PhotonOptionTable,
          .check = Check,
          .check_scene = CheckScene,
          .add_tables = AddTables,
          .for_each_pass = ForEachPass,
          .describe_passes = DescribePhotons,
          .render_wave = RenderPhotonWave};
}

}  // namespace skywave
