// skywave bench: how fast a scene renders, and how much of that is Embree.
#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <vector>

#include "base/files.h"
#include "cli/commands.h"
#include "cli/job_flags.h"
#include "wavefront/render.h"
#include "wavefront/replay.h"

namespace skywave {
namespace {

struct BenchFlags {
  JobRequest request;
  int repetitions = 5;
  std::string json;
};

double Median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const std::size_t half = values.size() / 2;
  return values.size() % 2 == 1 ? values[half] : 0.5 * (values[half - 1] + values[half]);
}

// Rays that a replay may keep in memory: 24 bytes each.
constexpr double kMaxRecordedRays = 5e7;

int BenchMain(BenchFlags& flags) {
  if (!flags.json.empty()) CheckWritable(flags.json);
  const RenderJob job(flags.request);
  for (const std::string& note : job.notes()) fmt::print(stderr, "note: {}\n", note);
  FrameView frame = job.frame();
  const RenderOptions& options = job.options();

  // First a frame that records its rays; it also warms the caches.
  std::vector<RayRecorder> recorders;
  Film film = job.MakeFilm();
  const FrameResult recorded = RenderFrame(frame, film, nullptr, &recorders);
  if (double(recorded.stats.total_rays()) > kMaxRecordedRays) {
    fmt::print(stderr, "note: {:.0f} million rays kept for the replay; use fewer --spp\n",
               double(recorded.stats.total_rays()) * 1e-6);
  }

  // Then renders and replays in turn, so that a slow minute slows both.
  std::vector<double> render, closest[4], occlusion[4];
  for (int repetition = 0; repetition < flags.repetitions; ++repetition) {
    Film again = job.MakeFilm();
    render.push_back(RenderFrame(frame, again).seconds);
    for (int b = 0; b < 4; ++b) {
      const ReplayTime time =
          Replay(job.geometry().scene(), kBackends[b], recorders, options.threads);
      closest[b].push_back(time.closest);
      occlusion[b].push_back(time.occlusion);
    }
  }

  const RenderStats& stats = recorded.stats;
  const double seconds = Median(render);
  double best_closest = 1e300, best_occlusion = 1e300;
  fmt::print("{:<10}{:>16}{:>18}   raw Embree, {} threads, medians of {}\n", "backend",
             "closest [s]", "occlusion [s]", recorded.threads, flags.repetitions);
  for (int b = 0; b < 4; ++b) {
    fmt::print("{:<10}{:>16.4f}{:>18.4f}\n", ToString(kBackends[b]), Median(closest[b]),
               Median(occlusion[b]));
    best_closest = std::min(best_closest, Median(closest[b]));
    best_occlusion = std::min(best_occlusion, Median(occlusion[b]));
  }
  const double fraction = (best_closest + best_occlusion) / seconds;
  const double msamples = double(stats.samples) / seconds * 1e-6;
  const double mrays = double(stats.total_rays()) / seconds * 1e-6;
  fmt::print("render    {:>16.4f} s ({:.4f} to {:.4f}), backend {}\n", seconds,
             *std::min_element(render.begin(), render.end()),
             *std::max_element(render.begin(), render.end()), ToString(options.backend));
  fmt::print("SUMMARY msamples_per_s={:.3f} mrays_per_s={:.3f} embree_fraction={:.3f}\n", msamples,
             mrays, fraction);
  if (!flags.json.empty()) {
    nlohmann::ordered_json json;
    json["schema"] = "skywave-bench-1";
    json["version"] = SKYWAVE_VERSION;
    json["command"] = RepeatCommand(flags.request, options);
    json["threads"] = recorded.threads;
    json["wave"] = options.wave;
    json["render_seconds"] = render;
    for (int b = 0; b < 4; ++b) {
      json["replay_seconds"][std::string(ToString(kBackends[b]))] = {{"closest", closest[b]},
                                                                     {"occlusion", occlusion[b]}};
    }
    json["rays"] = {
        {"camera", stats.rays[0]}, {"bounce", stats.rays[1]}, {"shadow", stats.rays[2]}};
    json["summary"] = {
        {"msamples_per_s", msamples}, {"mrays_per_s", mrays}, {"embree_fraction", fraction}};
    WriteFileAtomically(flags.json, json.dump(2) + "\n");
  }
  return 0;
}

}  // namespace

void AddBenchCommand(CLI::App& program, Run& run) {
  CLI::App* command =
      program.add_subcommand("bench", "Speed of a scene, and the share of it that is Embree's own");
  const auto flags = std::make_shared<BenchFlags>();
  flags->request.samples_per_pixel = 8;
  AddJobFlags(*command, flags->request);
  command->add_option("--repetitions", flags->repetitions, "of renders and replays, in turn")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  command->add_option("--json", flags->json, "write every repetition to this file");
  command->footer(
      "The rays of one frame (8 samples a pixel unless --spp says otherwise) are recorded and\n"
      "replayed raw through every way to call Embree; embree_fraction is the best replay's time\n"
      "over the render's.\n\n"
      "Example:\n  skywave bench gallery --repetitions 9");
  command->callback([flags, &run] { run = [flags] { return BenchMain(*flags); }; });
}

}  // namespace skywave
