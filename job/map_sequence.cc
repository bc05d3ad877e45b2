#include "job/map_sequence.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdint>
#include <filesystem>

#include "base/error.h"

namespace skywave {

bool HasNumber(const std::string& path) {
  return std::filesystem::path(path).filename().string().find('#') != std::string::npos;
}

std::string NumberedFile(const std::string& path, std::int64_t number) {
  const std::size_t last = path.rfind('#');
  const std::size_t before = path.find_last_not_of('#', last);
  const std::size_t first = before == std::string::npos ? 0 : before + 1;
  return fmt::format("{}{:0{}}{}", path.substr(0, first), number, last - first + 1,
                     path.substr(last + 1));
}

bool IsMapSequence(const std::string& path) {
  std::error_code ignored;
  return HasNumber(path) && !std::filesystem::exists(path, ignored);
}

std::string MapFile(const JobRequest& request) {
  const std::string& path = request.environment.path;
  if (!IsMapSequence(path)) return path;
  if (!request.read.frame) {
    throw OptionError("env", path,
                      "there is no such file; if its #s stand for the number of a frame, give "
                      "`frame N` as well");
  }
  const double frame = *request.read.frame;
  if (frame != std::floor(frame)) {
    throw OptionError({{"frame", fmt::format("{}", frame)}, {"env", path}},
                      "only whole frames have a map");
  }
  return NumberedFile(path, std::int64_t(frame));
}

std::string StrategyOfFrame(const JobRequest& request) {
  if (!request.read.frame || !HasNumber(request.strategy)) return request.strategy;
  return NumberedFile(request.strategy, std::int64_t(std::floor(*request.read.frame)));
}

}  // namespace skywave
