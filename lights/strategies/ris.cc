#include "lights/strategies/ris.h"

#include <algorithm>

#include "kernels/chunk.h"
#include "kernels/sampler.h"

namespace skywave {
namespace {

// Surfaces whose candidates are in flight together.
constexpr std::uint32_t kRows = 256;

// Surfaces of one BSDF are each offered candidate `index` of `count`.
struct CandidateCall {
  const ShadePoints& points;
  SurfaceColumns rows;  // at the chunk
  const BsdfKernels& bsdf;
  std::uint32_t n;
  LightCall light;
  std::uint32_t index, count;
  SampleIndexing indexing() const {
    return {.stride = light.requested * count, .offset = light.index * count + index};
  }
};

// Draws candidates by the BSDF: dir, radiance and the density of the map there. Rows that scatter
// nowhere get no light.
void DrawFromBsdf(const CandidateCall& call, const EnvStrategy& map, const LightColumns& out) {
  Chunk<UniformColumns, kRows> direction, lobe;
  const ShadePoints& points = call.points;
  const std::uint32_t pair = call.light.pair + 2 * kPairBlock;
  DrawUniforms(points.paths, call.rows.path, call.n, pair, call.indexing(), direction);
  if (call.bsdf.lobed) {
    DrawUniforms(points.paths, call.rows.path, call.n, pair + kPairBlock, call.indexing(), lobe);
  }
  Chunk<RayColumns, kRows> rays;
  const std::uint32_t drawn = call.bsdf.scatter(
      call.rows, points.materials, {.direction = direction, .lobe = lobe}, call.n, {}, rays, 0);
  Chunk<LightColumns, kRows> seen;  // radiance and density of the map, row for row with `rays`
  const EscapeColumns escaped = {.dir_x = rays->dir_x,
                                 .dir_y = rays->dir_y,
                                 .dir_z = rays->dir_z,
                                 .throughput_r = rays->throughput_r,
                                 .throughput_g = rays->throughput_g,
                                 .throughput_b = rays->throughput_b,
                                 .pdf = rays->pdf,
                                 .path = rays->path,
                                 .from = rays->from,
                                 .radiance_r = seen->r,
                                 .radiance_g = seen->g,
                                 .radiance_b = seen->b,
                                 .light_pdf = seen->pdf};
  map.EvaluateEscaped(points, drawn, 1, escaped);
  std::fill_n(out.r, call.n, 0.0f), std::fill_n(out.g, call.n, 0.0f),
      std::fill_n(out.b, call.n, 0.0f);
  std::fill_n(out.dir_x, call.n, 0.0f), std::fill_n(out.dir_y, call.n, 0.0f),
      std::fill_n(out.dir_z, call.n, 1.0f);
  std::fill_n(out.pdf, call.n, 0.0f);
  for (std::uint32_t i = 0; i < drawn; ++i) {
    const std::uint32_t row = rays->from[i];
    out.dir_x[row] = rays->dir_x[i], out.dir_y[row] = rays->dir_y[i],
    out.dir_z[row] = rays->dir_z[i];
    out.r[row] = seen->r[i], out.g[row] = seen->g[i], out.b[row] = seen->b[i];
    out.pdf[row] = seen->pdf[i];
  }
}

// Draws candidates from the map.
void DrawFromMap(const CandidateCall& call, const EnvStrategy& map, const LightColumns& out) {
  Chunk<UniformColumns, kRows> uniforms;
  DrawUniforms(call.points.paths, call.rows.path, call.n, call.light.pair + kPairBlock,
               call.indexing(), uniforms);
  map.Sample(call.points, uniforms, call.n, {}, out);
}

}  // namespace

void RisStrategy::Sample(const ShadePoints& points, const UniformColumns& uniforms, std::uint32_t,
                         LightCall light, const LightColumns& out) const {
  Chunk<ReservoirColumns, kRows> reservoirs;
  Chunk<LightColumns, kRows> candidates;
  Chunk<BsdfValueColumns, kRows> values;
  ForEachBsdfBlock(
      points.ranges, kDenseBsdfs, kRows, [&](const BsdfKernels& bsdf, const BsdfRows& at) {
        CandidateCall call = {.points = points,
                              .rows = Slice(points.surfaces, at.begin),
                              .bsdf = bsdf,
                              .n = at.n,
                              .light = light};
        StartReservoirs(uniforms.u + at.begin, call.n, reservoirs);
        const auto offer = [&](auto draw, std::uint32_t count) {
          call.count = count;
          for (call.index = 0; call.index < count; ++call.index) {
            draw(call, map_, candidates);
            call.bsdf.evaluate(call.rows, points.materials, candidates, call.n, values);
            OfferCandidates(candidates, values, counts_, call.n, reservoirs);
          }
        };
        offer(DrawFromMap, counts_.map);
        offer(DrawFromBsdf, counts_.bsdf);
        TakeFromReservoirs(reservoirs, call.n, light.samples(), Slice(out, at.begin));
      });
}

void RisStrategy::EvaluateEscaped(const ShadePoints& points, std::uint32_t n, float samples,
                                  const EscapeColumns& rows) const {
  map_.EvaluateEscaped(points, n, samples, rows);
  for (std::uint32_t i = 0; i < n; ++i) {
    if (rows.pdf[i] > 0) rows.radiance_r[i] = rows.radiance_g[i] = rows.radiance_b[i] = 0;
  }
}

StrategyFactory RisFactory() {
  static constexpr StrategyParameter kParameters[] = {
      {"map", "4", "candidates from the map, 1 to 256"},
      {"bsdf", "1", "candidates from the BSDF, 0 to 256"}};
  return {
      "ris", "the best of several candidates from map and BSDF (Talbot et al. 2005)", kParameters,
      [](const EnvironmentMap& map, const StrategyValues& values) -> std::unique_ptr<EnvStrategy> {
        return std::make_unique<RisStrategy>(
            map, CandidateCounts{.map = std::uint32_t(IntValue(values, "map", 1, 256)),
                                 .bsdf = std::uint32_t(IntValue(values, "bsdf", 0, 256))});
      }};
}

}  // namespace skywave
