// Bidirectional path tracing (Lafortune and Willems 1993; Veach and Guibas 1995). Each path has a
// sub-path from the camera and one from a light. All their vertices are connected with each other,
// with light samples and with the camera, and weighted by the power heuristic over all of these
// techniques (kernels/light_paths/bidirectional.h). Both sub-paths together have no more than
// max_depth surfaces; roulette is that of path tracing.
#include "wavefront/integrators/bdpt.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include "base/error.h"
#include "kernels/partition.h"
#include "wavefront/integrator.h"
#include "wavefront/render_option.h"
#include "wavefront/stages/bidirectional.h"
#include "wavefront/stages/light_stages.h"
#include "wavefront/stages/merging.h"
#include "wavefront/stages/path_stages.h"

namespace skywave {
namespace {

// Traces the light sub-paths of paths [0, n), splats their vertices and keeps them.
void TraceLightSubpaths(const FrameView& frame, std::uint32_t n, Worker& w, Film& film,
                        StageClock& clock) {
  BidirectionalTables& b = w.of<BidirectionalTables>();
  const auto& connections = frame.options.of<ConnectionOptions>();
  soa::Table<RayColumns>*rays = &w.rays[0], *next = &w.rays[1];
  if (!b.vertices.empty()) {
    EmitRays(frame, n, *rays, w, clock);
    LeaveLights(w.of<LightPathTables>().emission, n, b.light);
  }
  std::uint32_t bounce = 0;
  for (LightVertices& vertices : b.vertices) {
    ++bounce;
    vertices.ranges = {};
    if (n == 0) continue;
    IntersectLightPathSurfaces(frame, *rays, n, bounce, w, clock);
    ArriveAtSurfaces(w.surfaces, w.ranges.total(), b.light, vertices.at);
    if (connections.shows(bounce + 1, 1)) {
      ConnectSurfaces(frame, bounce, w, clock);
      WeighCameraConnections(frame, vertices.at, w, clock);
      SplatConnections(frame, bounce, w, film, clock);
    }
    const bool last = bounce == b.vertices.size();
    n = last ? 0
             : ScatterSubpaths(frame, kLightEnd, vertices.at, 0, bounce, *next, b.light, w, clock);
    KeepVertices(w, vertices);
    std::swap(rays, next);
  }
}

}  // namespace

void RenderBdptWave(const FrameView& frame, const WaveRange& range, Worker& w, Film& film) {
  StageClock clock(w.stats);
  BidirectionalTables& b = w.of<BidirectionalTables>();
  {
    const LensUniforms lens(w.scratch);
    GenerateRays(frame, range, FilmUniforms(w.scratch), lens, w.paths, b.eye_rays);
    LeaveCamera(frame, lens, range.count, w);
  }
  clock.Lap(Stage::kGenerate);
  TraceLightSubpaths(frame, range.count, w, film, clock);

  const auto& connections = frame.options.of<ConnectionOptions>();
  const bool merges = TechniquesOf(frame).eta_vcm > 0;
  // A technique that is shown alone is shown without weights too.
  const bool sees = (frame.options.mis || connections.shown) && frame.shines_on_bsdf_samples();
  const std::uint32_t max_depth = frame.options.max_depth;
  soa::Table<RayColumns>*rays = &b.eye_rays, *next = &w.rays[0];
  std::uint32_t n = range.count, bounce = 0;
  for (; n > 0; ++bounce) {
    SortedHits sorted =
        TraceAndSort(frame, kCameraEnd, *rays, n, bounce, /*only_delta=*/false, w, clock);
    MoveEscaped(*rays, sorted.queues->queue, n, w.escaped);
    const std::uint32_t eye = bounce + 2;  // vertices, with the surfaces to come
    if (connections.shows(0, eye)) AddHitLight(frame, *rays, n, sorted.escaped, bounce, w, clock);
    if (bounce == max_depth) break;
    PrepareHits(frame, kCameraEnd, *rays, n, std::move(sorted), w, clock);
    KeepAovs(frame, bounce, range.count, w, film, clock);
    ArriveAtSurfaces(w.surfaces, w.ranges.total(), b.eye, b.at);
    if (merges) MergeSurfaces(frame, bounce, w, clock);
    if (connections.shows(1, eye)) ConnectLights(frame, bounce, w, clock);
    for (std::uint32_t light = 0; bounce + light + 2 <= max_depth; ++light) {
      if (connections.shows(light + 2, eye)) ConnectVertices(frame, bounce, light, w, clock);
    }
    const bool last = bounce + 1 == max_depth;
    const std::uint32_t first_kind = last && !sees ? kFirstDeltaBsdf : 0;
    n = ScatterSubpaths(frame, kCameraEnd, b.at, first_kind, bounce, *next, b.eye, w, clock);
    std::swap(rays, next);
  }
  FinishWave(frame, range.count, bounce, w, film, clock);
}

void AddConnectionTables(const RenderOptions& options, Worker& worker) {
  AddLightPathTables(options, worker);
  worker.tables.Add<BidirectionalTables>(options.wave, options.max_depth);
}

void CheckConnections(const RenderOptions& options) {
  const std::string_view name = ToString(options.integrator);
  if (!options.mis && !options.of<ConnectionOptions>().shown) {
    throw OptionError("no-mis", "",
                      fmt::format("`integrator {}` would add what every technique brings in full; "
                                  "`integrator bdpt` with `paths S,T` shows one, unweighted",
                                  name));
  }
  if (options.max_depth > kMaxBidirectionalDepth) {
    throw OptionError("max-depth", fmt::format("{}", options.max_depth),
                      fmt::format("`integrator {}` keeps a table a bounce, for at most {}", name,
                                  kMaxBidirectionalDepth));
  }
}

namespace {

Codec<SubpathLengths> Lengths() {
  const Codec<std::uint32_t> number = Numbers(0u, ~0u);
  return {.values = "S,T, for example 1,2",
          .metavar = "S,T",
          .parse = [number](const std::string& text) -> std::optional<SubpathLengths> {
            const std::size_t comma = std::min(text.find(','), text.size());
            const auto light = number.parse(text.substr(0, comma));
            const auto eye = number.parse(text.substr(std::min(comma + 1, text.size())));
            if (!light || !eye) return std::nullopt;
            return SubpathLengths{.light = *light, .eye = *eye};
          },
          .print = [](const SubpathLengths& l) { return fmt::format("{},{}", l.light, l.eye); }};
}

std::span<const RenderOption> Options() {
  // clang-format off
  static const RenderOption table[] = {
      Refused("shows what single techniques bring", MakeRenderOption({.name = "paths", .group = "Paths", .help = "only paths of S vertices from the light and T from the eye; with --no-mis their weight is 1", .scope = OptionScope::kPixels, .example = "--integrator bdpt --paths 2,1 --no-mis", .default_text = "all"},
                       SKYWAVE_FIELD_OF(ConnectionOptions, shown), Lengths())),
  };
  // clang-format on
  return table;
}

void CheckSubpathLengths(const SubpathLengths& lengths, std::uint32_t max_depth) {
  const std::string value = fmt::format("{},{}", lengths.light, lengths.eye);
  const std::uint64_t vertices = std::uint64_t(lengths.light) + lengths.eye;
  if (lengths.eye == 0 || vertices < 2 || (lengths.light == 1 && lengths.eye == 1)) {
    throw OptionError("paths", value,
                      "there are paths of light vertices S and eye vertices T, the eye counted, "
                      "for T >= 2, and for T = 1 and S >= 2");
  }
  if (vertices - 2 > max_depth) {
    throw OptionError("paths", value,
                      fmt::format("such paths scatter at {} surfaces, and `max-depth` is {}",
                                  vertices - 2, max_depth));
  }
}

void Check(const RenderOptions& options) {
  const auto& shown = options.of<ConnectionOptions>().shown;
  if (shown) CheckSubpathLengths(*shown, options.max_depth);
  CheckConnections(options);
}

}  // namespace

IntegratorDescriptor BdptIntegrator() {
  return {.help = "paths from both ends, joined in every way: lamps in rooms, caustics",
          .light_paths = LightPaths::kStrategy,
          .has_splats = true,
          .options = Options,
          .check = Check,
          .add_tables = AddConnectionTables,
          .render_wave = RenderBdptWave};
}

}  // namespace skywave
