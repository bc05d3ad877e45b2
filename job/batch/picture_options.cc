#include "job/batch/picture_options.h"

#include <algorithm>

namespace skywave {

PictureRequest RequestOf(const std::string& path, const std::vector<PictureOption>& options) {
  const auto request = std::make_shared<PictureRequest>();
  std::vector<std::pair<std::string, std::string>> values;
  for (const PictureOption& option : options) values.emplace_back(option.name, option.text);
  try {
    SetOptions(BindAll(PictureOptions(), request), values);
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
