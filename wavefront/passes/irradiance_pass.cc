#include "wavefront/passes/irradiance_pass.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <span>
#include <tuple>
#include <utility>
#include <vector>

#include "kernels/sampler.h"
#include "wavefront/paths/camera_paths.h"
#include "wavefront/paths/pilot.h"
#include "wavefront/stages/irradiance_stages.h"
#include "wavefront/stages/path_stages.h"

namespace skywave {
namespace {

// The radius of a record is that many pixels of the pilot, at least and at most: smaller ones would
// not be seen, and larger ones miss small things (Ward et al. 1988).
constexpr float kLeastPixels = 1.5f, kMostPixels = 40;

// No more records are made than this; paths go on where one is missing.
constexpr std::size_t kMostRecords = 1 << 17;

// This many rays of records are kept at a time, or those of one record.
constexpr std::size_t kRaysAtATime = 1 << 17;
// A thread asks for this many points at a time.
constexpr std::size_t kPointsAtATime = 256;

// No pixel of a film has the place that seeds the rays of records, nor do light paths.
constexpr std::uint32_t kRecordColumn = ~1u;

// The coarsest grid takes a pixel of 32 x 32.
constexpr std::uint32_t kGrids = 5;

// A diffuse surface that the pilot has seen.
struct SeenPoint {
  Triple origin;               // the hit, lifted as rays that leave it need
  Triple geometric, shading;   // normals, on the side that is seen
  float pixel;                 // size of a pixel of the pilot there
  std::uint32_t round, index;  // index: of the pixel and the sample
};

// Returns the round in which a pixel of the pilot takes part. Grids are refined as an interlaced
// picture is; samples after the first are rounds after those of all grids.
std::uint32_t RoundOf(std::uint32_t x, std::uint32_t y, std::uint32_t sample) {
  const auto halvings =
      std::uint32_t(std::min(std::countr_zero(x | y | 1u << kGrids), int(kGrids)));
  const std::uint32_t odd = ((x >> halvings) & 1) + 2 * ((y >> halvings) & 1);
  if (sample > 0) return 3 * kGrids + 4 * sample + (x & 1) + 2 * (y & 1);
  return halvings == kGrids ? 0 : 3 * (kGrids - 1 - halvings) + odd;
}

// Follows camera paths `range` of the pilot to the first diffuse surfaces.
void SeePoints(const FrameView& pilot, const WaveRange& range, Worker& w,
               std::vector<SeenPoint>& points) {
  constexpr auto kDiffuse = std::uint32_t(BsdfKind::kLambert);
  // Indirect light needs another surface.
  const std::uint32_t most = std::max(pilot.options.max_depth, 1u) - 1;
  FollowToSurfaces(pilot, range, kDiffuse + 1, most, w, [&](const std::vector<float>& length) {
    const SurfaceColumns& s = w.surfaces;
    const std::uint32_t begin = w.ranges.begin[kDiffuse];
    for (std::uint32_t i = begin; i < begin + w.ranges.count(kDiffuse); ++i) {
      const std::uint32_t path = s.path[i], pixel = w.paths->pixel[path];
      const std::uint32_t sample = w.paths->sample[path];
      points.push_back(
          {.origin = {s.org_x[i], s.org_y[i], s.org_z[i]},
           .geometric = {s.ng_x[i], s.ng_y[i], s.ng_z[i]},
           .shading = {s.ns_x[i], s.ns_y[i], s.ns_z[i]},
           .pixel = PixelSize(pilot.camera, length[path]),
           .round = RoundOf(pixel % pilot.camera.width, pixel / pilot.camera.width, sample),
           .index = pixel * pilot.options.samples_per_pixel + sample});
    }
  });
}

// Traces rows [first, first + count) of the rays of `points`, grid.count() each, and what they see
// of indirect light. `number` is that of the first point's record.
void SampleHemispheres(const FrameView& pilot, const HemisphereGrid& grid,
                       std::span<const SeenPoint> points, std::size_t number, std::size_t first,
                       std::uint32_t count, Worker& w, HemisphereSample* samples,
                       Triple* directions) {
  StageClock clock(w.stats);
  const RayColumns& rays = w.rays[0];
  const PathColumns& paths = w.paths;
  for (std::uint32_t i = 0; i < count; ++i) {
    const std::size_t record = (first + i) / grid.count();
    paths.seed[i] = PixelSeed(kRecordColumn, std::uint32_t(number + record), pilot.options.seed);
    paths.sample[i] = std::uint32_t((first + i) % grid.count());
    paths.pixel[i] = 0;
    paths.r[i] = paths.g[i] = paths.b[i] = 0;
  }
  {
    const FilmUniforms place(w.scratch);
    DrawUniforms(paths, nullptr, count, kFilmPair, {}, place);
    for (std::uint32_t i = 0; i < count; ++i) {
      const SeenPoint& point = points[(first + i) / grid.count()];
      const Triple dir = DirectionInCell(grid, paths.sample[i], place->u[i], place->v[i],
                                         AxesAround(point.shading));
      directions[i] = dir;
      rays.org_x[i] = point.origin[0], rays.org_y[i] = point.origin[1];
      rays.org_z[i] = point.origin[2];
      rays.dir_x[i] = dir[0], rays.dir_y[i] = dir[1], rays.dir_z[i] = dir[2];
      rays.t_far[i] = std::numeric_limits<float>::infinity();
      rays.throughput_r[i] = rays.throughput_g[i] = rays.throughput_b[i] = 1;
      rays.pdf[i] = 0, rays.path[i] = i, rays.from[i] = 0;
    }
  }
  {
    const RayKeys keys = MakeRayKeys(pilot, w.paths, rays.path, count,
                                     SamplePair(1, SampleUse::kScatter), w.scratch);
    TraceClosest(pilot.tracer, RayKind::kBounce, rays, count, w.hits, keys->key);
  }
  for (std::uint32_t i = 0; i < count; ++i) {
    samples[i].distance =
        w.hits->geom[i] == kNoHit ? std::numeric_limits<float>::infinity() : rays.t_far[i];
    rays.t_far[i] = std::numeric_limits<float>::infinity();
  }
  // What the rays see at once is direct light, which counts elsewhere.
  Departure from = FromOwnSurfaces(pilot, w);
  const RadianceColumns& seen = w.of<IrradianceTables>().direct;
  from.paths.r = seen.r, from.paths.g = seen.g, from.paths.b = seen.b;
  FollowPaths(pilot, from, count, 1, w, /*film=*/nullptr, clock);
  for (std::uint32_t i = 0; i < count; ++i) {
    const Triple& normal = points[(first + i) / grid.count()].geometric;
    const float above =
        normal[0] * directions[i][0] + normal[1] * directions[i][1] + normal[2] * directions[i][2];
    // Below its triangle a ray meets that triangle itself, which is no neighbour.
    if (!(above > 0)) samples[i].distance = std::numeric_limits<float>::infinity();
    samples[i].radiance = above > 0 ? Triple{paths.r[i], paths.g[i], paths.b[i]} : Triple{};
  }
}

// Appends records of `points`, whose rays are kept together.
void Measure(const FrameView& pilot, std::span<const SeenPoint> points, float accuracy,
             const HemisphereGrid& grid, WorkerPool& pool, std::vector<IrradianceRecord>& records) {
  const std::size_t rays = points.size() * grid.count(), wave = pilot.options.wave;
  std::vector<HemisphereSample> samples(rays);
  std::vector<Triple> directions(rays);
  pool.ForEach((rays + wave - 1) / wave, [&](std::size_t i, Worker& w, RayRecorder*) {
    const RenderStats stats = w.stats;
    const std::size_t first = i * wave;
    SampleHemispheres(pilot, grid, points, records.size(), first,
                      std::uint32_t(std::min(wave, rays - first)), w, samples.data() + first,
                      directions.data() + first);
    w.stats = stats;
  });
  const std::size_t before = records.size();
  records.resize(before + points.size());
  pool.ForEach(points.size(), [&](std::size_t i, Worker&, RayRecorder*) {
    const SeenPoint& point = points[i];
    const auto part = [&](const auto& all) {
      return std::span(all).subspan(i * grid.count(), grid.count());
    };
    const MeasuredIrradiance measured =
        MeasureIrradiance(grid, AxesAround(point.shading), part(samples), part(directions));
    IrradianceRecord& record = records[before + i];
    record = measured.record;
    record.position = point.origin;
    const float wanted = accuracy * measured.distance;
    record.radius = std::clamp(wanted, kLeastPixels * point.pixel, kMostPixels * point.pixel);
    // A gradient is not followed farther than its record was meant to count.
    const float followed = std::min(1.0f, wanted / record.radius);
    for (Triple& gradient : record.move) {
      for (float& component : gradient) component *= followed;
    }
  });
}

}  // namespace

IrradianceCache MakeIrradianceCache(const FrameView& frame, WorkerPool& pool) {
  const IrradianceCacheOptions& options = frame.options.of<IrradianceCacheOptions>();
  FrameView pilot = PilotView(frame, *frame.strategy);
  pilot.options.mis = frame.options.mis;
  const HemisphereGrid grid = GridOf(options.rays);
  std::vector<SeenPoint> points = TracePilot<SeenPoint>(
      pilot, pool, [&](const WaveRange& range, Worker& worker, std::vector<SeenPoint>& some) {
        SeePoints(pilot, range, worker, some);
      });
  std::stable_sort(points.begin(), points.end(), [](const SeenPoint& a, const SeenPoint& b) {
    return std::tie(a.round, a.index) < std::tie(b.round, b.index);
  });
  std::vector<IrradianceRecord> records;
  IrradianceCache cache(records, options.accuracy);
  for (auto begin = points.cbegin(); begin != points.cend() && records.size() < kMostRecords;) {
    const auto end = std::find_if(
        begin, points.cend(), [&](const SeenPoint& point) { return point.round != begin->round; });
    const std::span<const SeenPoint> round(begin, end);
    std::vector<std::uint8_t> known(round.size());
    pool.ForEach((round.size() + kPointsAtATime - 1) / kPointsAtATime,
                 [&](std::size_t block, Worker&, RayRecorder*) {
                   const std::size_t first = block * kPointsAtATime;
                   const std::size_t last = std::min(first + kPointsAtATime, round.size());
                   for (std::size_t i = first; i < last; ++i) {
                     Triple irradiance;
                     known[i] = cache.Interpolate(round[i].origin, round[i].shading, irradiance);
                   }
                 });
    std::vector<SeenPoint> unknown;
    for (std::size_t i = 0; i < round.size(); ++i) {
      if (known[i] == 0 && records.size() + unknown.size() < kMostRecords) {
        unknown.push_back(round[i]);
      }
    }
    const std::size_t at_a_time = std::max<std::size_t>(1, kRaysAtATime / grid.count());
    for (std::size_t i = 0; i < unknown.size(); i += at_a_time) {
      const std::size_t some = std::min(at_a_time, unknown.size() - i);
      Measure(pilot, std::span(unknown).subspan(i, some), options.accuracy, grid, pool, records);
    }
    if (!unknown.empty()) cache = IrradianceCache(records, options.accuracy);
    begin = end;
  }
  return cache;
}

}  // namespace skywave
