#include "batch/report.h"

namespace skywave {
namespace {

nlohmann::ordered_json PictureJson(const BatchPicture& picture) {
  nlohmann::ordered_json json = {
      {"index", picture.index}, {"output", picture.output}, {"png", PngOf(picture.output)}};
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
    nlohmann::ordered_json item = PictureJson(picture);
    item["options"] = nlohmann::ordered_json::object();
    for (const PictureOption& option : picture.options) item["options"][option.name] = option.text;
    json["pictures"].push_back(std::move(item));
  }
  return json;
}

}  // namespace skywave
