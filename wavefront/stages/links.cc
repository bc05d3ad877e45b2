#include "wavefront/stages/links.h"

#include <algorithm>
#include <limits>

#include "scene/geometry.h"

namespace skywave {
namespace {

// Whether the shadow ray of surface i is traced with those of a link of shadows, or with those of
// none (0).
bool IsOf(const LinkView& view, const LinkColumns& rows, std::uint32_t link, std::uint32_t i) {
  const std::uint32_t of_shadows = rows.links[i] & view.of_shadows;
  return link == 0 ? of_shadows == 0 : (of_shadows & link) != 0;
}

// Returns the links of what a ray has met: of a lamp, or of the environment if it met nothing.
std::uint32_t LinksOfHit(const FrameView& frame, const LinkView& view, const HitColumns& hits,
                         std::uint32_t i) {
  if (hits.geom[i] == kNoHit) return view.of_environment;
  if (!frame.has_emitters()) return 0;
  const std::uint32_t light = frame.local_lights.light_of_triangle[hits.triangle[i]];
  return light == kNoLight ? 0 : view.of_light[light];
}

}  // namespace

void AddLinkTables(const RenderOptions& options, Worker& worker) {
  if (options.of<LinkOptions>().count > 0) worker.tables.Add<LinkTables>(options.wave);
}

const LinkColumns* LinkRows(const FrameView& frame, const Worker& w) {
  if (frame.find<LinkView>() == nullptr) return nullptr;
  const LinkTables* const tables = w.tables.find<LinkTables>();
  if (tables == nullptr) return nullptr;
  const LinkColumns& rows = tables->rows;
  return &rows;
}

void LinkSamples(const FrameView& frame, const LightReach& reach, const Worker& w) {
  const LinkColumns* const rows = LinkRows(frame, w);
  if (rows == nullptr) return;
  const LinkView& view = *frame.find<LinkView>();
  const std::uint32_t n = w.ranges.light_sampled();
  std::fill_n(rows->links, n, view.of_environment);
  ForEachLocalLight(
      reach, n, [&](std::uint32_t i, std::size_t light) { rows->links[i] = view.of_light[light]; });
  const LightColumns& lights = w.lights;
  for (std::uint32_t i = 0; i < n; ++i) {
    const std::uint32_t links = rows->links[i];
    const std::uint32_t material = frame.geometry->MaterialOfRecord(w.surfaces->triangle[i]);
    if ((links & view.unlit[material]) != 0) {
      lights.r[i] = lights.g[i] = lights.b[i] = 0;
    } else if ((links & view.of_shadows) != 0 && lights.pdf[i] > 0 && lights.pdf[i] < kPunctual) {
      // No BSDF sample counts that meets the light: this is all of it.
      const float irradiance = 1 / lights.pdf[i];
      lights.r[i] *= irradiance, lights.g[i] *= irradiance, lights.b[i] *= irradiance;
      lights.pdf[i] = std::numeric_limits<float>::infinity();
    }
  }
}

void OpenShadows(const LinkView& view, const LinkColumns& kept, std::uint32_t links,
                 std::uint32_t n, float* t_far) {
  for (std::uint32_t i = 0; i < n; ++i) t_far[i] = IsOf(view, kept, links, i) ? kept.t_far[i] : -1;
}

void KeepShadows(const LinkView& view, const LinkColumns& kept, std::uint32_t links,
                 std::uint32_t n, const float* t_far) {
  for (std::uint32_t i = 0; i < n; ++i) {
    if (IsOf(view, kept, links, i)) kept.t_far[i] = t_far[i];
  }
}

void HideLights(const FrameView& frame, const RayColumns& rays, std::uint32_t n,
                std::uint32_t bounce, const SurfaceColumns& left, const Worker& w) {
  const LinkColumns* const rows = LinkRows(frame, w);
  if (rows == nullptr) return;
  const LinkView& view = *frame.find<LinkView>();
  for (std::uint32_t i = 0; i < n; ++i) {
    const std::uint32_t links = bounce == 0 ? 0 : LinksOfHit(frame, view, w.hits, i);
    rows->seen[i] = 1;
    if (links == 0) continue;
    const std::uint32_t material = frame.geometry->MaterialOfRecord(left.triangle[rays.from[i]]);
    const bool is_sampled = (links & view.of_shadows) != 0 && rays.pdf[i] > 0;
    if ((links & view.unlit[material]) == 0 && !is_sampled) continue;
    rows->seen[i] = 0;
    rows->r[i] = rays.throughput_r[i];
    rows->g[i] = rays.throughput_g[i];
    rows->b[i] = rays.throughput_b[i];
    rays.throughput_r[i] = rays.throughput_g[i] = rays.throughput_b[i] = 0;
  }
}

void ShowLights(const FrameView& frame, const RayColumns& rays, std::uint32_t n, const Worker& w) {
  const LinkColumns* const rows = LinkRows(frame, w);
  if (rows == nullptr) return;
  for (std::uint32_t i = 0; i < n; ++i) {
    if (rows->seen[i] != 0) continue;
    rays.throughput_r[i] = rows->r[i];
    rays.throughput_g[i] = rows->g[i];
    rays.throughput_b[i] = rows->b[i];
  }
}

}  // namespace skywave
