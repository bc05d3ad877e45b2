#include "job/batch/picture_request.h"

#include <algorithm>

#include "job/options.h"
#include "job/picture.h"

namespace skywave {

std::vector<BoundOption> BindPictureOptions(const std::shared_ptr<PictureRequest>& request) {
  const std::shared_ptr<JobRequest> job(request, &request->job);
  const std::shared_ptr<RenderLimits> limits(request, &request->limits);
  const std::shared_ptr<ExposureRequest> exposure(request, &request->exposure);
  const std::shared_ptr<ExrFormat> format(request, &request->format);
  std::vector<BoundOption> bound;
  for (const JobOption& option : JobOptions()) bound.push_back(Bind(option, job));
  for (const auto& option : LimitOptions()) bound.push_back(Bind(option, limits));
  for (const auto& option : ExposureOptions()) bound.push_back(Bind(option, exposure));
  for (const auto& option : ExrFormatOptions()) bound.push_back(Bind(option, format));
  return bound;
}

PictureRequest RequestOf(const std::string& path, const std::vector<PictureOption>& options) {
  const auto request = std::make_shared<PictureRequest>();
  std::vector<std::pair<std::string, std::string>> values;
  for (const PictureOption& option : options) values.emplace_back(option.name, option.text);
  try {
    SetOptions(BindPictureOptions(request), values);
  } catch (const OptionError& error) {
    throw AtOption(path, options, error);
  }
  return *request;
}

InputError AtOption(const std::string& path, const std::vector<PictureOption>& options,
                    const OptionError& error) {
  const std::string& name = error.options().front().name;
  const auto given = std::find_if(options.begin(), options.end(),
                                  [&](const PictureOption& option) { return option.name == name; });
  const std::size_t line = given == options.end() ? 0 : given->line;
  return {InputPosition::Line(path, line), std::string(error.what())};
}

}  // namespace skywave
