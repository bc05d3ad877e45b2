// Measures photon maps on one thread and on several: rates of both, and the ratio.
//
//   photon_scaling_bench [repetitions = 5] [threads = all]
//
// A repetition measures every work on one thread, on all, on all and on one, so that a machine that
// becomes slower meanwhile is fair to both; rates use the median time. Exit code 64: usage.
#include <fmt/format.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "base/clock.h"
#include "base/granted.h"
#include "bench/photon_points.h"
#include "job/job.h"
#include "scene/builtin/builtin.h"
#include "wavefront/passes/photon_pass.h"
#include "wavefront/records/photon_map.h"
#include "wavefront/render.h"

namespace skywave {
namespace {

constexpr std::uint32_t kPoints = 1000000, kQueries = 1 << 19, kNeighbors = 50, kBlock = 16;

// Work done by the threads of the calling arena; `run` returns the number of items.
struct Work {
  std::string name;
  std::function<std::uint64_t(int threads)> run;
};

// Traces light paths, sorts photons and builds trees.
Work TracePass(const char* scene) {
  JobRequest request;
  request.integrator = Integrator::kPhoton;
  request.options.of<PhotonOptions>().indirect = 400000;
  const auto job = std::make_shared<RenderJob>(BuiltinScene(scene), request);
  return {fmt::format("pass, {} [photons]", scene), [job](int threads) {
            FrameView frame = job->frame();
            frame.options.threads = threads;
            WorkerPool pool(frame.options);
            std::uint64_t photons = 0;
            pool.Run([&] {
              const PhotonMaps maps =
                  TracePhotons(frame, PhotonPasses(frame.options).front(), pool);
              photons = std::uint64_t(maps.caustic.size()) + maps.indirect.size();
            });
            return photons;
          }};
}

Work BuildTree(const Points& points) {
  return {"tree of 1e6 [photons]",
          [&points](int) { return std::uint64_t(TreeOf(points).view().count); }};
}

Work FindNeighbors(const PointTree& tree, const Points& queries) {
  return {"50 nearest of 1e6 [queries]", [&tree, &queries](int) {
            const float distance = 0.02f;  // three times the radius that holds 50 photons
            tbb::parallel_for(
                tbb::blocked_range<std::uint32_t>(0, kQueries, 1 << 12),
                [&](const auto& range) {
                  const soa::Table<NeighborColumns> found(kBlock * NearestRoom(kNeighbors));
                  std::uint32_t count[kBlock];
                  for (std::uint32_t i = range.begin(); i < range.end(); i += kBlock) {
                    FindNearest(tree.view(), &queries.axes[0][i], &queries.axes[1][i],
                                &queries.axes[2][i], kBlock, kNeighbors, distance * distance, found,
                                count);
                  }
                },
                tbb::simple_partitioner());
            return std::uint64_t{kQueries};
          }};
}

// Renders both passes of a frame: photons and camera.
Work RenderPass(const char* scene, std::uint32_t gather) {
  JobRequest request;
  request.integrator = Integrator::kPhoton;
  request.width = 320, request.height = 240, request.samples_per_pixel = 4;
  request.options.of<PhotonOptions>().gather = gather;
  const auto job = std::make_shared<RenderJob>(BuiltinScene(scene), request);
  return {fmt::format("picture, {}, gather {} [samples]", scene, gather), [job](int threads) {
            FrameView frame = job->frame();
            frame.options.threads = threads;
            Film film = job->MakeFilm();
            RenderFrame(frame, film);
            return std::uint64_t(frame.options.width) * std::uint64_t(frame.options.height) *
                   frame.options.samples_per_pixel;
          }};
}

double Seconds(const Work& work, int threads, std::uint64_t& items) {
  tbb::task_arena arena(threads);
  arena.initialize();
  const auto start = Clock::now();
  arena.execute([&] { items = work.run(threads); });
  return SecondsSince(start);
}

double Median(std::vector<double> values) {
  const auto middle = values.begin() + std::ptrdiff_t(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

int Main(int repetitions, int threads) {
  const Points points = MakePoints(kPoints, false, 1), queries = MakePoints(kQueries, false, 2);
  const PointTree tree = TreeOf(points);
  const Work works[] = {TracePass("lamps"),     TracePass("three-spheres"),
                        BuildTree(points),      FindNeighbors(tree, queries),
                        RenderPass("lamps", 0), RenderPass("lamps", 8)};
  fmt::print("{} repetitions, medians [million a second]\n{:<44}{:>10}{:>10}{:>9}\n", repetitions,
             "", "1 thread", fmt::format("{} threads", threads), "scaling");
  for (const Work& work : works) {
    std::vector<double> of_one, of_all;
    std::uint64_t items = 0;
    Seconds(work, threads, items);  // touches the memory before anything is timed
    for (int i = 0; i < repetitions; ++i) {
      of_one.push_back(Seconds(work, 1, items));
      of_all.push_back(Seconds(work, threads, items));
      of_all.push_back(Seconds(work, threads, items));
      of_one.push_back(Seconds(work, 1, items));
    }
    const double one = 1e-6 * double(items) / Median(of_one);
    const double all = 1e-6 * double(items) / Median(of_all);
    fmt::print("{:<44}{:>10.3f}{:>10.3f}{:>9.2f}\n", work.name, one, all, all / one);
    std::fflush(stdout);
  }
  return 0;
}

}  // namespace
}  // namespace skywave

int main(int argc, char** argv) {
  const int repetitions = argc > 1 ? std::atoi(argv[1]) : 5;
  const int threads = argc > 2 ? std::atoi(argv[2]) : skywave::GrantedHere().threads;
  if (argc > 3 || repetitions < 1 || threads < 1) {
    fmt::print(stderr, "photon_scaling_bench [repetitions] [threads]\n");
    return 64;
  }
  return skywave::Main(repetitions, threads);
}
