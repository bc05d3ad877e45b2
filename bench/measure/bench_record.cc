#include "bench/measure/bench_record.h"

#include <limits>
#include <nlohmann/json.hpp>

#include "bench/measure/json_input.h"
#include "bench/measure/speed.h"

namespace skywave {
namespace {

constexpr std::string_view kMachineKeys[] = {"processor",    "compiler",       "build",
                                             "instructions", "embree_config",  "microcode",
                                             "governor",     "virtual_machine"};
constexpr std::string_view kSettingKeys[] = {"threads", "wave"};

int Whole(const JsonInput& value) {
  return int(value.whole_number(0, std::uint64_t(std::numeric_limits<int>::max())));
}

void AddCounts(const JsonInput& from, SceneRecord& scene) {
  if (from.has("samples")) scene.samples = from.at("samples").number();
  for (const auto& [kind, rays] : from.at("rays").members())
    scene.rays += rays.at("count").number();
}

std::vector<double> Processor(const JsonInput& from) {
  if (!from.has("repetitions") || !from.at("repetitions").has("processor")) return {};
  return from.at("repetitions").at("processor").positive_numbers();
}

// The doubts of a scene whose times are `from`; results of versions that did not look have none.
std::vector<std::string> Doubts(const JsonInput& from, std::size_t renders) {
  std::vector<std::string> doubts;
  if (from.has("conditions") && !from.at("conditions").is_null()) {
    const JsonInput conditions = from.at("conditions");
    const auto share = [&](const char* key) -> std::optional<double> {
      if (!conditions.has(key) || conditions.at(key).is_null()) return {};
      return conditions.at(key).number();
    };
    Conditions read = {.waiting = share("waiting"), .stolen = share("stolen"), .throttled = {}};
    if (share("throttled")) {
      read.throttled = conditions.at("throttled").whole_number(0, JsonInput::kMostWhole);
    }
    doubts = read.disturbances();
  }
  if (!from.has("deviation")) return doubts;
  const JsonInput deviation = from.at("deviation");
  if (deviation.at("limit").is_null()) return doubts;
  const double relative = deviation.at("relative").number(), limit = deviation.at("limit").number();
  if (relative > limit) doubts.push_back(UnsteadyText(renders, relative, limit));
  return doubts;
}

}  // namespace

BenchRecord RecordOf(const nlohmann::json& json, const std::string& file) {
  const JsonInput root(json, file);
  const bool suite =
      root.schema({kSuiteSchema, kSceneSchema}, "a result of skywave bench --json") == kSuiteSchema;
  BenchRecord record = {
      .file = file,
      .subject = suite ? root.at("suite").text() + " suite" : root.at("command").text(),
      .version = root.at("version").text()};
  if (root.has("machine")) {
    const JsonInput machine = root.at("machine");
    for (const std::string_view key : kMachineKeys) {
      if (machine.has(key)) record.settings.emplace_back(key, machine.at(key).text());
    }
  }
  const JsonInput settings = suite ? root.at("settings") : root;
  for (const std::string_view key : kSettingKeys) {
    if (!settings.has(key)) continue;
    record.settings.emplace_back(key, std::to_string(Whole(settings.at(key))));
  }
  record.threads = Whole(settings.at("threads"));
  if (!suite) {
    SceneRecord scene = {.name = root.has("scene") ? root.at("scene").text() : "picture",
                         .render = root.at("render_seconds").positive_numbers(),
                         .processor = Processor(root)};
    scene.doubts = Doubts(root, scene.render.size());
    if (root.has("picture_hash")) scene.picture = root.at("picture_hash").text();
    AddCounts(root, scene);
    record.scenes.push_back(std::move(scene));
    return record;
  }
  for (const JsonInput& from : root.at("scenes").items()) {
    SceneRecord scene = {.name = from.at("name").text(),
                         .picture = from.at("picture").at("expected").text(),
                         .render = from.at("repetitions").at("render").positive_numbers(),
                         .processor = Processor(from)};
    scene.doubts = Doubts(from, scene.render.size());
    AddCounts(from, scene);
    record.scenes.push_back(std::move(scene));
  }
  if (record.scenes.empty()) root.at("scenes").Fail("is empty");
  return record;
}

SuiteSummary SummaryOf(const nlohmann::json& json, const std::string& file) {
  const JsonInput root(json, file);
  root.schema({kSuiteSchema}, "a result of skywave bench --json");
  const JsonInput summary = root.at("summary");
  const auto value = [&](const char* key) {
    const JsonInput figure = summary.at(key);
    return figure.is_null() ? 0.0 : figure.number();
  };
  return {.msamples_per_s = value("msamples_per_s"),
          .mrays_per_s = value("mrays_per_s"),
          .embree_fraction = value("embree_fraction"),
          .scaling_2 = value("scaling_2")};
}

BenchRecord ReadRecord(const std::string& path) { return RecordOf(ReadJson(path), path); }

}  // namespace skywave
