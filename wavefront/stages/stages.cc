#include "wavefront/stages/stages.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "kernels/accumulate.h"
#include "kernels/lights/directional.h"
#include "kernels/lights/environment.h"
#include "kernels/partition.h"
#include "kernels/sampler.h"
#include "kernels/surface/layers.h"
#include "kernels/surface/surface.h"
#include "kernels/surface/texture.h"

namespace skywave {

struct LinkView;  // wavefront/stages/links.h, which lies above

namespace {

// Returns the column from `row` on; null stays null.
const float* At(const float* column, std::uint32_t row) {
  return column == nullptr ? nullptr : column + row;
}

// Starts paths beam by beam: the samples of a block of pixels, then those of the next block of the
// tile. Seeds are those of the pixels of the whole film, so that a part of it has the same noise.
void StartPaths(const RenderOptions& options, const CameraView& camera, const WaveRange& range,
                const PathColumns& paths) {
  assert(range.first % kBeamRays == 0 && range.count % kBeamRays == 0);
  assert(range.tile.width % kBeamWidth == 0 && range.tile.height % kBeamHeight == 0);
  const std::uint32_t spp = options.samples_per_pixel;
  auto number = std::uint32_t(range.first / kBeamRays / spp);
  auto sample = std::uint32_t(range.first / kBeamRays % spp);
  const std::uint32_t across = range.tile.width / kBeamWidth;
  for (std::uint32_t row = 0; row < range.count; sample = 0, ++number) {
    const std::uint32_t block = range.blocks.empty() ? number : range.blocks[number];
    const std::uint32_t block_x = block % across, block_y = block / across;
    std::uint32_t seed[kBeamRays], pixel[kBeamRays];
    for (std::uint32_t i = 0; i < kBeamRays; ++i) {
      const std::uint32_t x = range.tile.x + block_x * kBeamWidth + i % kBeamWidth;
      const std::uint32_t y = range.tile.y + block_y * kBeamHeight + i / kBeamWidth;
      seed[i] = PixelSeed(camera.first_column + x, camera.first_row + y, options.seed);
      pixel[i] = y * camera.width + x;
    }
    for (; sample < spp && row < range.count; ++sample, row += kBeamRays) {
      std::copy_n(seed, kBeamRays, paths.seed + row);
      std::copy_n(pixel, kBeamRays, paths.pixel + row);
      std::fill_n(paths.sample + row, kBeamRays, options.first_sample + sample);
    }
  }
  std::fill_n(paths.r, range.count, 0.0f);
  std::fill_n(paths.g, range.count, 0.0f);
  std::fill_n(paths.b, range.count, 0.0f);
}

// Returns whether a stage asks which local lights samples go to (ForEachLocalLight).
bool TellsLightsApart(const FrameView& frame) {
  return frame.light_groups != nullptr || frame.object_lamps != nullptr ||
         frame.find<LinkView>() != nullptr;
}

// Draws light samples for the first `n` rows.
LightReach SampleRows(const FrameView& frame, const ShadePoints& points, const LightShares& shares,
                      LightCall call, std::uint32_t n, const LightUniforms& uniforms,
                      const Scratch& scratch, const LightColumns& lights,
                      const LightPlaces& places) {
  const LightPlan& plan = shares.plan;
  const std::uint32_t index = call.index;
  if (index >= shares.first_drawn()) {
    DrawUniforms(points.paths, points.surfaces.path, n, call.pair,
                 {.stride = plan.drawn, .offset = index - shares.first_drawn()}, uniforms);
    call.index -= shares.each;
  } else if (plan.random_fixed || shares.is_of_each(index)) {
    // Every fixed sample is a separate integral, so it has a sequence of its own.
    call.pair += kPairBlock * (index + 1);
    DrawUniforms(points.paths, points.surfaces.path, n, call.pair, {}, uniforms);
  }
  const LightChoice local = shares.ChoiceOf(frame.local_lights, index);
  if (local.share < 1) {
    SampleStrategy(*frame.strategy, points, uniforms, local.share, n, call, scratch, lights);
  }
  if (local.share <= 0) return {};
  LightReach reach(scratch);
  ReachColumns written = reach;
  if (!TellsLightsApart(frame)) written.light = nullptr;
  const HitColumns& on_triangles = places;
  SampleLocalLights(frame.local_lights, local, points.surfaces, uniforms, n,
                    shares.local_samples(index), lights, written,
                    frame.local_lights.has_alpha ? &on_triangles : nullptr);
  return reach;
}

}  // namespace

void GenerateRays(const FrameView& frame, const WaveRange& range, const FilmUniforms& film,
                  const LensUniforms& lens, const PathColumns& paths, const RayColumns& rays) {
  StartPaths(frame.options, frame.camera, range, paths);
  DrawUniforms(paths, nullptr, range.count, kFilmPair, {}, film);
  if (frame.camera.has_lens()) DrawUniforms(paths, nullptr, range.count, kLensPair, {}, lens);
  GenerateCameraRays(frame.camera, paths, film, lens, range.count, rays);
}

RayKeys MakeRayKeys(const FrameView& frame, const PathColumns& paths, const std::uint32_t* rows,
                    std::uint32_t n, std::uint32_t event, const Scratch& scratch) {
  if (!frame.geometry->has_alpha()) return {};
  RayKeys keys(scratch);
  DrawRayKeys(paths, rows, n, event, keys->key);
  return keys;
}

std::uint32_t SortHits(const Geometry& geometry, const RayColumns& rays, const HitColumns& hits,
                       std::uint32_t n, bool only_delta, const RayQueues& queues,
                       SurfaceRanges& ranges) {
  std::uint32_t count[kBsdfKinds + 1] = {};
  ClassifyHits(hits, geometry.triangles(), geometry.bsdfs(), only_delta ? rays.pdf : nullptr, n,
               queues->queue, count);
  for (std::uint32_t kind = 0; kind < kBsdfKinds; ++kind) {
    ranges.begin[kind + 1] = ranges.begin[kind] + count[kind];
  }
  assert(ranges.total() + count[kMissQueue] <= n);
  return count[kMissQueue];
}

void MoveSurfaces(const Geometry& geometry, const RayColumns& rays, const HitColumns& hits,
                  const RayQueues& queues, std::uint32_t n, const SurfaceRanges& ranges,
                  const SurfaceColumns& surfaces) {
  const bool instanced = geometry.instances() != nullptr;
  ForEachBsdf(ranges, kAllBsdfs, [&](const BsdfKernels&, const BsdfRows& rows) {
    const SurfaceColumns to = Slice(surfaces, rows.begin);
    MoveHits(rays, hits, queues->queue, rows.kind, n, to);
    if (instanced) MoveInstances(hits, queues->queue, rows.kind, n, to);
  });
}

void TextureSurfaces(const FrameView& frame, const PathEnd& end, const SurfaceRanges& ranges,
                     const SurfaceColumns& surfaces) {
  const MaterialView view = frame.geometry->materials();
  const MaterialRecord* const materials = view.records;
  const TextureView textures = frame.geometry->textures();
  const float angle = end.transport == Transport::kFlux ? 0 : PixelAngle(frame.camera);
  if (!textures.empty()) {
    TextureColors(textures, materials, angle, ranges.total(), surfaces);
  }
  if (const std::uint32_t* const colors = frame.geometry->vertex_colors()) {
    TintByVertices(colors, ranges.total(), surfaces);
  }
  if (const NormalMapView bases = frame.geometry->base_normal_maps(); !bases.empty()) {
    WriteBaseNormals(textures, bases, angle, ranges.total(), surfaces);
  }
  if (const NormalMapView maps = frame.geometry->normal_maps(); !maps.empty()) {
    BendNormals(textures, maps, angle, ranges.total(), surfaces);
  }
  ForEachBsdf(ranges, kAllBsdfs, [&](const BsdfKernels& bsdf, const BsdfRows& at) {
    const std::uint32_t n = at.n;
    const SurfaceColumns rows = Slice(surfaces, at.begin);
    if (frame.geometry->absorbs() && bsdf.inside) AbsorbInside(materials, n, rows);
    if (view.glass_layers && bsdf.glass_layers) {
      PrepareGlassLayers(textures, materials, angle, n, rows);
    }
    switch (bsdf.varying) {
      case Varying::kNothing:
        break;
      case Varying::kRoughness:
        PrepareMetallicRoughness(textures, materials, angle, n, rows);
        break;
      case Varying::kAlpha:
        if (view.two_widths && bsdf.two_widths) {
          PrepareTangents(frame.geometry->tangents(), frame.geometry->instances(), n, rows);
          PrepareTwoWidths(textures, materials, *bsdf.across, false, angle, n, rows);
        } else if (view.varied) {
          PrepareMetallicRoughness(textures, materials, angle, n, rows);
        }
        break;
      case Varying::kCoatWidths:
        if (view.varied) PrepareCoatWidths(textures, materials, angle, n, rows);
        break;
      case Varying::kSecondColor:
        if (view.varied) PrepareSecondColor(textures, materials, angle, n, rows);
        break;
      case Varying::kLayers: {
        const std::uint32_t* const tangents = frame.geometry->tangents();
        if (tangents != nullptr) {
          PrepareTangents(tangents, frame.geometry->instances(), n, rows);
        }
        PrepareLayers(textures, materials, tangents, angle, n, rows);
        break;
      }
      case Varying::kTangent:
        PrepareTangents(frame.geometry->tangents(), frame.geometry->instances(), n, rows);
        if (view.varied && bsdf.across) {
          PrepareTwoWidths(textures, materials, *bsdf.across, true, angle, n, rows);
        }
        break;
    }
  });
}

void AddEscaped(const FrameView& frame, const ShadePoints& from, const std::uint32_t* met,
                const EscapeColumns& escaped, std::uint32_t n, const PathColumns& paths) {
  if (n == 0 || !frame.has_environment()) return;
  // Texels of a strategy whose lights stand for a part of the map are without that part.
  if (met != nullptr && frame.strategy->unbiased()) {
    for (std::uint32_t i = 0; i < n; ++i) {
      const bool sees_texels = (met[escaped.path[i]] & kMetDense) != 0;
      if (escaped.pdf[i] == 0 && sees_texels) escaped.pdf[i] = kSeesTexels;
    }
  }
  const float samples = frame.light_shares().strategy_samples(frame.light_samples());
  frame.strategy->EvaluateEscaped(from, n, samples, escaped);
  AddEscapedRadiance(escaped, n, frame.mis(), paths);
}

void AddEmitted(const FrameView& frame, const RayColumns& rays, const HitColumns& hits,
                std::uint32_t n, const SurfaceColumns& left, const EmitterHits& emitter_hits,
                const PathColumns& paths) {
  if (!frame.has_emitters()) return;
  const LightShares shares = frame.light_shares();
  const std::uint32_t count =
      IntersectEmitters(frame.local_lights, shares.ChoiceOfHits(frame.local_lights), rays, hits, n,
                        shares.hit_samples(frame.local_lights), left, emitter_hits);
  AddEscapedRadiance(emitter_hits, count, frame.mis(), paths);
}

void SampleStrategy(const EnvStrategy& strategy, const ShadePoints& points,
                    const LightUniforms& uniforms, float local_share, std::uint32_t n,
                    const LightCall& call, const Scratch& scratch, const LightColumns& lights) {
  if (local_share <= 0) return strategy.Sample(points, uniforms, n, call, lights);
  const SplitRemainder remainder(scratch);
  SplitUniforms(uniforms->u, n, local_share, remainder->u);
  strategy.Sample(points, {.u = remainder->u, .v = uniforms->v}, n, call, lights);
}

LightReach SampleLights(const FrameView& frame, const ShadePoints& points,
                        const LightShares& shares, std::uint32_t pair, std::uint32_t index,
                        const LightUniforms& uniforms, const Scratch& scratch,
                        const LightColumns& lights, const LightPlaces& places) {
  const std::uint32_t n = points.ranges.light_sampled();
  const LightCall call = {.index = index,
                          .requested = frame.light_samples(),
                          .pair = pair,
                          .share = shares.of_strategy};
  return SampleRows(frame, points, shares, call, n, uniforms, scratch, lights, places);
}

void WeighByFilter(const FrameView& frame, std::uint32_t n, const Worker& w) {
  if (frame.filter.factor == nullptr) return;
  const FilmUniforms film(w.scratch);
  DrawUniforms(w.paths, nullptr, n, kFilmPair, {}, film);
  const PathColumns& paths = w.paths;
  for (std::uint32_t i = 0; i < n; ++i) {
    const float weight = frame.filter.WeightAt(film->u[i], film->v[i]);
    paths.r[i] *= weight, paths.g[i] *= weight, paths.b[i] *= weight;
  }
}

void EvaluateLights(const FrameView& frame, const SurfaceColumns& surfaces,
                    const SurfaceRanges& ranges, const LightReach& reach, std::uint32_t index,
                    const LightColumns& lights, const ControlRows& control) {
  const MaterialView materials = frame.geometry->materials();
  const auto* const known_light = frame.find<ControlView>();
  const MisPolicy mis = frame.mis();
  ForEachBsdf(ranges, kDenseBsdfs, [&](const BsdfKernels& bsdf, const BsdfRows& rows) {
    const SurfaceColumns at = Slice(surfaces, rows.begin);
    const LightColumns lights_at = Slice(lights, rows.begin);
    if (known_light == nullptr) {
      bsdf.evaluate_lights(at, materials, rows.n, mis, lights_at);
      return;
    }
    const LightControl known = {.irradiance = known_light->irradiance,
                                .weight = At(control.weight, rows.begin),
                                .with_integral = index == 0,
                                .reach = reach.limited() ? reach->distance + rows.begin : nullptr,
                                .out = Slice(control.out, rows.begin)};
    bsdf.evaluate_controlled_lights(at, materials, rows.n, mis, known, lights_at);
  });
  if (reach.limited()) LimitShadows(reach->distance, ranges.light_sampled(), lights);
}

void CloseTransparentSamples(const FrameView& frame, const LightPlaces& places, const RayKeys& keys,
                             std::uint32_t n, float* t_far) {
  for (std::uint32_t i = 0; i < n; ++i) {
    if (t_far[i] < 0 || places->geom[i] == kNoHit) continue;
    const std::uint32_t triangle = places->triangle[i];
    if (triangle < frame.geometry->first_with_alpha()) continue;
    if (!StopsRay(frame.geometry->opacity(), keys->key[i], triangle, places->u[i], places->v[i])) {
      t_far[i] = -1;
    }
  }
}

std::uint32_t Scatter(const FrameView& frame, const ShadePoints& points, const Scattering& how,
                      const Scratch& scratch, const RayColumns& rays, const ControlRows& control) {
  const auto* const known_light = frame.find<ControlView>();
  assert(known_light == nullptr || control.out.r != nullptr);
  const DirectionUniforms direction(scratch);
  const LobeUniforms lobe(scratch);
  const bool roulette = how.bounce >= kFirstRouletteBounce;
  const auto draw = [&](const BsdfRows& at, SampleUse use, const UniformColumns& uniforms) {
    DrawUniforms(points.paths, points.surfaces.path + at.begin, at.n,
                 how.end.pairs + SamplePair(how.bounce, use), how.end.split, uniforms);
  };
  MaterialView materials = points.materials;
  materials.flux = how.end.transport == Transport::kFlux;
  std::uint32_t appended = 0;
  const BsdfSpan bsdfs = {.first = how.first_kind, .end = kBsdfKinds};
  ForEachBsdf(points.ranges, bsdfs, [&](const BsdfKernels& bsdf, const BsdfRows& at) {
    draw(at, SampleUse::kScatter, direction);
    if (bsdf.lobed || roulette) draw(at, SampleUse::kLobe, lobe);
    const LightControl known = {
        .irradiance = known_light != nullptr ? known_light->irradiance : IrradianceView{},
        .weight = At(control.weight, at.begin),
        .out = control.out};
    const ScatterPolicy policy = {.roulette = roulette,
                                  .first_row = at.begin,
                                  .transport = how.end.transport,
                                  .control = known_light != nullptr ? &known : nullptr};
    const std::uint32_t first = appended;
    appended = bsdf.scatter(Slice(points.surfaces, at.begin), materials,
                            {.direction = direction, .lobe = lobe}, at.n, policy, rays, appended);
    if (known_light != nullptr && bsdf.delta) {
      for (float* column : {control.out.r, control.out.g, control.out.b}) {
        std::fill(column + first, column + appended, 0.0f);
      }
    }
  });
  return appended;
}

}  // namespace skywave
