#include "wavefront/stages/place.h"

#include <algorithm>

#include "kernels/sampler.h"

namespace skywave {
namespace {

// Returns the tables in which paths with objects are watched; null: they are not.
const PlaceTables* Watched(const FrameView& frame, const Worker& w) {
  if (frame.catchers == nullptr || frame.is_of_place()) return nullptr;
  return w.tables.find<PlaceTables>();
}

// Gives `light` of those of paths [0, n) that see `what` to a part of the light, and nothing of the
// others.
void KeepPart(LightPart part, std::uint32_t what, const RadianceColumns& light,
              const PathColumns& paths, std::uint32_t n, const PlaceTables& tables, Film& film) {
  const RadianceColumns& kept = tables.part;
  for (std::uint32_t i = 0; i < n; ++i) {
    const bool counts = (tables.paths->met[i] & what) != 0;
    kept.r[i] = counts ? light.r[i] : 0;
    kept.g[i] = counts ? light.g[i] : 0;
    kept.b[i] = counts ? light.b[i] : 0;
  }
  PathColumns of_part = paths;
  of_part.r = kept.r, of_part.g = kept.g, of_part.b = kept.b;
  film.AddLightPart(part, of_part, n);
}

// Keeps those of rays [0, n) for which is(row of its path) is true; returns their number.
template <class Is>
std::uint32_t KeepRays(const RayColumns& rays, std::uint32_t n, const Is& is) {
  std::uint32_t kept = 0;
  for (std::uint32_t i = 0; i < n; ++i) {
    if (!is(rays.path[i])) continue;
    RayColumns columns = rays;
    RayColumns::ForEachColumn(columns, [&](auto*& column) { column[kept] = column[i]; });
    ++kept;
  }
  return kept;
}

}  // namespace

void AddPlaceTables(const RenderOptions& options, Worker& worker) {
  if (Sums(options.aovs, AovSum::kDifference)) worker.tables.Add<PlaceTables>(options.wave);
}

void SeeObjects(const FrameView& frame, const RayColumns& rays, std::uint32_t n,
                std::uint32_t bounce, bool known, const Worker& w) {
  const PlaceTables* const tables = Watched(frame, w);
  if (tables == nullptr) return;
  const PlaceColumns& paths = tables->paths;
  const HitColumns& hits = w.hits;
  if (bounce == 0) std::fill_n(paths.met, n, 0);
  for (std::uint32_t i = 0; i < n; ++i) {
    if (hits.geom[i] == kNoHit) continue;
    const bool caught =
        known && frame.catchers[MaterialOf(frame.tracer.triangles[hits.triangle[i]])] != 0;
    if (bounce == 0) {
      paths.met[rays.path[i]] |= caught ? kSeesCatcher : kSeesObject;
    } else if (!caught) {
      paths.met[rays.path[i]] |= kObjectsMatter;
    }
  }
}

void BeforeShadows(const FrameView& frame, const Worker& w) {
  const PlaceTables* const tables = Watched(frame, w);
  if (tables == nullptr) return;
  const std::uint32_t n = w.ranges.light_sampled();
  for (std::uint32_t i = 0; i < n; ++i) tables->paths->open[i] = w.lights->t_far[i] >= 0;
}

void AfterShadows(const FrameView& frame, const Worker& w) {
  const PlaceTables* const tables = Watched(frame, w);
  if (tables == nullptr) return;
  const std::uint32_t n = w.ranges.light_sampled();
  for (std::uint32_t i = 0; i < n; ++i) {
    const bool stopped = tables->paths->open[i] != 0 && w.lights->t_far[i] < 0;
    if (stopped) tables->paths->met[w.surfaces->path[i]] |= kObjectsMatter;
  }
}

void SeeObjectLamps(const FrameView& frame, const LightReach& reach, const Worker& w) {
  if (frame.object_lamps == nullptr) return;
  const PlaceTables* const tables = Watched(frame, w);
  const std::uint32_t n = w.ranges.light_sampled();
  ForEachLocalLight(reach, n, [&](std::uint32_t i, std::size_t light) {
    if (frame.object_lamps[light] == 0) return;
    if (frame.is_of_place()) w.lights->t_far[i] = -1;
    if (tables != nullptr) tables->paths->met[w.surfaces->path[i]] |= kObjectsMatter;
  });
}

void KeepLightParts(const FrameView& frame, std::uint32_t n, const Worker& w, Film& film) {
  const PlaceTables* const tables = Watched(frame, w);
  if (tables == nullptr) return;
  const PlaceColumns& with = tables->paths;
  const PathColumns& paths = w.paths;
  KeepPart(LightPart::kObjects, kSeesObject, {paths.r, paths.g, paths.b}, paths, n, *tables, film);
  std::copy_n(paths.r, n, with.r);
  std::copy_n(paths.g, n, with.g);
  std::copy_n(paths.b, n, with.b);
}

std::uint32_t ReturnToPlace(const FrameView& place, const WaveRange& range, Worker& w) {
  const PlaceColumns& with = w.of<PlaceTables>().paths;
  GenerateRays(place, range, FilmUniforms(w.scratch), LensUniforms(w.scratch), w.paths, w.rays[0]);
  return KeepRays(w.rays[0], range.count, [&](std::uint32_t path) {
    return with.met[path] == (kSeesCatcher | kObjectsMatter);
  });
}

void KeepPlace(const FrameView& place, std::uint32_t n, const Worker& w, Film& film) {
  const PlaceTables& tables = w.of<PlaceTables>();
  const PlaceColumns& with = tables.paths;
  WeighByFilter(place, n, w);
  const PathColumns& paths = w.paths;
  for (std::uint32_t i = 0; i < n; ++i) {
    const bool same = (with.met[i] & kObjectsMatter) == 0;
    if (same) paths.r[i] = with.r[i], paths.g[i] = with.g[i], paths.b[i] = with.b[i];
    with.r[i] -= paths.r[i], with.g[i] -= paths.g[i], with.b[i] -= paths.b[i];
  }
  const RadianceColumns clean = {paths.r, paths.g, paths.b}, change = {with.r, with.g, with.b};
  KeepPart(LightPart::kClean, kSeesCatcher, clean, paths, n, tables, film);
  KeepPart(LightPart::kChange, kSeesCatcher, change, paths, n, tables, film);
}

}  // namespace skywave
