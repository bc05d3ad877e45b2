// Measures copies of a scene or of the suite, one thread each.
#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "base/files.h"
#include "base/json.h"
#include "base/version.h"
#include "bench/measure/copies.h"
#include "bench/measure/statistics.h"
#include "cli/bench/flags.h"
#include "cli/bench/report.h"
#include "cli/print.h"
#include "job/job.h"
#include "wavefront/render.h"

namespace skywave {
namespace {

// What each copy renders: the scene, or those of the suite, whose pictures are known.
struct CopyScene {
  std::string name;
  JobRequest request;
  const SuiteScene* known = nullptr;
};

std::vector<CopyScene> CopyScenes(const BenchFlags& flags) {
  JobRequest base = flags.request;
  base.options.threads = 1;
  if (flags.has_scene()) return {{.name = base.scene, .request = base}};
  std::vector<CopyScene> scenes;
  for (const SuiteScene& scene : SuiteScenes(flags.full)) {
    scenes.push_back({std::string(scene.name), SuiteRequest(scene, base), &scene});
  }
  return scenes;
}

// Returns {"samples", "seconds"} of a scene as JSON; all copies render at the same time.
// The file `output` must not be one that the scene is read from.
nlohmann::json MeasureCopy(const CopyScene& scene, int repetitions, const std::string& output,
                           CopyBarrier& barrier) {
  const FilesRead inputs;
  const RenderJob job(scene.request);
  inputs.CheckAreNot(std::array{output});
  Film film = job.MakeFilm();
  const FrameResult first = RenderFrame(job.frame(), film);
  if (scene.known != nullptr) {
    const Fingerprint found = FingerprintOf(film, scene.known->samples_per_pixel);
    const PictureCheck check =
        CheckPicture(scene.known->expected, found, KnownHash(*scene.known, scene.request));
    if (check == PictureCheck::kWrong) {
      throw InputError(InputPosition::File(scene.name),
                       "not the picture that the suite expects, so there is no score",
                       kExitWrongPicture);
    }
  }
  const auto render = [&] {
    Film again = job.MakeFilm();
    return RenderFrame(job.frame(), again).seconds;
  };
  std::vector<double> seconds;
  barrier.Meet();
  for (int i = 0; i < repetitions; ++i) seconds.push_back(render());
  while (!barrier.Finish()) render();
  return {{"samples", first.stats.samples}, {"seconds", seconds}};
}

double RateOf(const nlohmann::json& measured) {
  return measured.at("samples").get<double>() /
         Median(measured.at("seconds").get<std::vector<double>>()) * 1e-6;
}

}  // namespace

int BenchCopies(const BenchFlags& flags) {
  if (!flags.json.empty()) CheckWritable(flags.json);
  const std::vector<CopyScene> scenes = CopyScenes(flags);
  const int copies = *flags.copies, repetitions = RepetitionsOf(flags);
  const std::vector<CopyResult> results =
      RunCopies(copies, ProcessorsByCore(), [&](CopyBarrier& barrier) {
        nlohmann::json measured = nlohmann::json::array();
        for (const std::size_t i : PartsOfCopy(barrier.copy(), scenes.size(), flags.rotate)) {
          measured[i] = MeasureCopy(scenes[i], repetitions, flags.json, barrier);
        }
        return JsonText(measured);
      });

  nlohmann::ordered_json json = {{"schema", "skywave-bench-copies-1"},
                                 {"version", Version()},
                                 {"subject", flags.has_scene() ? flags.request.scene
                                             : flags.full      ? "full suite"
                                                               : "quick suite"},
                                 {"repetitions", repetitions},
                                 {"rotate", flags.rotate}};
  std::vector<double> sums(scenes.size(), 0), each;
  std::size_t pinned = 0;
  Print(stdout, "{} copies of one thread, {} repetitions, Msamples/s\n{:>6}{:>11}", copies,
        repetitions, "copy", "processor");
  for (const CopyScene& scene : scenes) Print(stdout, "  {:>14}", scene.name);
  for (std::size_t copy = 0; copy < results.size(); ++copy) {
    const CopyResult& result = results[copy];
    const auto measured = ParseJson(result.text);
    nlohmann::ordered_json& entry = json["copies"].emplace_back(nlohmann::ordered_json::object());
    entry["processor"] = nullptr;
    if (result.processor) entry["processor"] = *result.processor;
    pinned += result.processor.has_value();
    Print(stdout, "\n{:>6}{:>11}", copy + 1,
          result.processor ? std::to_string(*result.processor) : "any");
    std::vector<double> rates;
    for (std::size_t i = 0; i < scenes.size(); ++i) {
      rates.push_back(RateOf(measured[i]));
      sums[i] += rates.back();
      Print(stdout, "  {:>14.3f}", rates.back());
      entry["scenes"].push_back({{"name", scenes[i].name},
                                 {"msamples_per_s", rates.back()},
                                 {"render", measured[i].at("seconds")}});
    }
    each.push_back(GeometricMean(rates));
    entry["msamples_per_s"] = each.back();
  }
  Print(stdout, "\n{:>17}", "sum");
  for (const double sum : sums) Print(stdout, "  {:>14.3f}", sum);
  const double total = GeometricMean(sums);
  if (pinned < results.size()) {
    Print(stderr, "note: {} of {} copies could not be pinned to a processor\n",
          results.size() - pinned, results.size());
  }
  Print(stdout, "\nCOPIES copies={} pinned={} msamples_per_s={:.3f} least={:.3f} most={:.3f}\n",
        copies, pinned, total, *std::min_element(each.begin(), each.end()),
        *std::max_element(each.begin(), each.end()));
  if (flags.json.empty()) return 0;
  json["machine"] = Json(DescribeMachine(flags.request.embree_config));
  json["summary"] = {{"msamples_per_s", total}, {"pinned", pinned}};
  WriteFileAtomically(flags.json, JsonText(json, 2) + "\n");
  return 0;
}

}  // namespace skywave
