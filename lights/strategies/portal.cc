#include "lights/strategies/portal.h"

#include <algorithm>

#include "base/error.h"
#include "kernels/chunk.h"

namespace skywave {
namespace {

// Surfaces whose samples are in flight together.
constexpr std::uint32_t kRows = 256;

float BaseOf(const Texels& texels) {
  double compensate = 0;
  return BaseLuminance(texels, compensate);
}

}  // namespace

PortalStrategy::PortalStrategy(const EnvironmentMap& map, std::uint32_t texels, double share)
    : texels_(map),
      inversion_(texels_, BaseOf(texels_)),
      portals_(texels_, map.portals, texels),
      share_(float(share)) {}

void PortalStrategy::Sample(const ShadePoints& points, const UniformColumns& uniforms,
                            std::uint32_t n, LightCall call, const LightColumns& out) const {
  const PortalsView portals = portals_.view();
  const InversionView inversion = inversion_.view();
  for (std::uint32_t begin = 0; begin < n; begin += kRows) {
    const std::uint32_t rows = std::min(kRows, n - begin);
    const SurfaceColumns surfaces = Slice(points.surfaces, begin);
    const LightColumns lights = Slice(out, begin);
    Chunk<PortalPickColumns, kRows> picks;
    PickPortals(portals, surfaces, uniforms.u + begin, share_, rows, surfaces.light_norm, picks);
    SamplePortals(portals, surfaces, picks, uniforms.v + begin, rows, lights);

    // The rows without a portal are drawn by importance, side by side.
    Chunk<UniformColumns, kRows> rest;
    Chunk<LightColumns, kRows> drawn;
    std::uint32_t row[kRows], count = 0;
    for (std::uint32_t i = 0; i < rows; ++i) {
      if (picks->portal[i] != kNoPortal) continue;
      rest->u[count] = picks->u[i], rest->v[count] = uniforms.v[begin + i];
      row[count++] = i;
    }
    if (count > 0) SampleTexels(texels_.view(), inversion, rest, count, 1, drawn);
    for (std::uint32_t k = 0; k < count; ++k) {
      lights.dir_x[row[k]] = drawn->dir_x[k], lights.dir_y[row[k]] = drawn->dir_y[k],
      lights.dir_z[row[k]] = drawn->dir_z[k];
    }

    // Radiance and densities are those that a ray in that direction finds.
    const EscapeColumns seen = {.dir_x = lights.dir_x,
                                .dir_y = lights.dir_y,
                                .dir_z = lights.dir_z,
                                .pdf = drawn->pdf,
                                .radiance_r = lights.r,
                                .radiance_g = lights.g,
                                .radiance_b = lights.b,
                                .light_pdf = lights.pdf};
    std::fill_n(drawn->pdf, rows, 1.0f);
    skywave::EvaluateEscaped(texels_.view(), {.inversion = &inversion}, rows, 1, seen);
    MixPortalDensity(portals, surfaces, surfaces.light_norm,
                     {lights.dir_x, lights.dir_y, lights.dir_z}, share_, call.samples(), rows,
                     lights.pdf);
  }
}

void PortalStrategy::EvaluateEscaped(const ShadePoints& points, std::uint32_t n, float samples,
                                     const EscapeColumns& rows) const {
  const InversionView inversion = inversion_.view();
  skywave::EvaluateEscaped(texels_.view(), {.inversion = &inversion}, n, 1, rows);
  MixPortalDensity(portals_.view(), points.surfaces, points.surfaces.light_norm,
                   {rows.dir_x, rows.dir_y, rows.dir_z, rows.from, rows.pdf}, share_, samples, n,
                   rows.light_pdf);
}

StrategyFactory PortalFactory() {
  static constexpr StrategyParameter kParameters[] = {
      {"texels", "1024", "rows and columns of the map as a portal sees it, 16 to 4096"},
      {"share", "0.125",
       "part of the samples by importance for light that comes in elsewhere, 0 to 0.9"}};
  return {
      "portal", "what a surface sees of the map through portals (Bitterli et al. 2015)",
      kParameters,
      [](const EnvironmentMap& map, const StrategyValues& values) -> std::unique_ptr<EnvStrategy> {
        if (map.portals.empty()) {
          throw OptionError("strategy", "portal",
                            "the scene has no portals; give the rectangles through which light "
                            "comes in by `portal`");
        }
        return std::make_unique<PortalStrategy>(map,
                                                std::uint32_t(IntValue(values, "texels", 16, 4096)),
                                                NumberValue(values, "share", 0, 0.9));
      },
      true};
}

}  // namespace skywave
