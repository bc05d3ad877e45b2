#include "job/batch/report.h"

#include <nlohmann/json.hpp>

#include "base/json.h"
#include "base/version.h"
#include "job/picture.h"

namespace skywave {
namespace {

constexpr const char* kSummarySchema = "skywave-batch-1";

// `output` is the name of the EXR in the report.
nlohmann::ordered_json PictureJson(const BatchPicture& picture, const std::string& output) {
  nlohmann::ordered_json json = {
      {"index", picture.index}, {"output", output}, {"png", PngBeside(output)}};
  json["axes"] = nlohmann::ordered_json::object();
  for (const AxisValue& value : picture.axes) json["axes"][value.axis] = value.label;
  return json;
}

}  // namespace

nlohmann::ordered_json ListJson(const BatchPlan& plan) {
  nlohmann::ordered_json json = {{"schema", "skywave-batch-list-1"},
                                 {"job", plan.path},
                                 {"folder", plan.folder},
                                 {"all_pictures", plan.all_pictures}};
  json["pictures"] = nlohmann::ordered_json::array();
  for (const BatchPicture& picture : plan.pictures) {
    nlohmann::ordered_json item = PictureJson(picture, picture.output);
    item["options"] = nlohmann::ordered_json::object();
    for (const PictureOption& option : picture.options) item["options"][option.name] = option.text;
    json["pictures"].push_back(std::move(item));
  }
  return json;
}

nlohmann::ordered_json SummaryJson(const BatchPlan& plan, const BatchShare& share,
                                   const BatchSummary& summary) {
  nlohmann::ordered_json json = {{"schema", kSummarySchema},
                                 {"version", Version()},
                                 {"job", plan.path},
                                 {"share", {{"number", share.number}, {"count", share.count}}},
                                 {"all_pictures", plan.all_pictures},
                                 {"exit_code", summary.exit_code},
                                 {"stopped", summary.stopped},
                                 {"seconds", summary.seconds},
                                 {"samples", summary.samples()}};
  for (const PictureStatus status : ValuesOf<PictureStatus>()) {
    json[std::string(ToString(status))] = summary.Count(status);
  }
  json["pictures"] = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < plan.pictures.size(); ++i) {
    const PictureResult& result = summary.results[i];
    nlohmann::ordered_json item =
        PictureJson(plan.pictures[i], RelativeName(plan.folder, plan.pictures[i].output));
    item["status"] = ToString(result.status);
    item["seconds"] = {{"load", result.load_seconds},
                       {"render", result.render_seconds},
                       {"write", result.write_seconds}};
    item["samples"] = result.samples;
    if (result.noise) item["noise"] = *result.noise;
    if (!result.hash.empty()) item["hash"] = result.hash;
    if (!result.error.empty()) item["error"] = result.error;
    json["pictures"].push_back(std::move(item));
  }
  return json;
}

std::map<std::string, PictureResult> ResultsInJson(const std::string& text) {
  std::map<std::string, PictureResult> results;
  try {
    const nlohmann::json json = ParseJson(text);
    if (json.at("schema") != kSummarySchema) return {};
    for (const nlohmann::json& item : json.at("pictures")) {
      const nlohmann::json& seconds = item.at("seconds");
      PictureResult result = {.status = Parse<PictureStatus>(item.at("status").get<std::string>())
                                            .value_or(PictureStatus::kPending),
                              .load_seconds = seconds.at("load"),
                              .render_seconds = seconds.at("render"),
                              .write_seconds = seconds.at("write"),
                              .samples = item.at("samples"),
                              .hash = item.value("hash", "")};
      if (item.contains("noise")) result.noise = item["noise"].get<double>();
      results.emplace(item.at("output"), std::move(result));
    }
  } catch (const nlohmann::json::exception&) {
    return {};  // another program's file, which will be replaced
  }
  return results;
}

}  // namespace skywave
