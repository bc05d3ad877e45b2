#include "job/picture_request.h"

#include <string>
#include <vector>

#include "job/options.h"
#include "job/picture.h"

namespace skywave {
namespace {

// Appends `options`, which set a part of the request.
template <class Options, class Part>
void Append(const Options& options, Part PictureRequest::*part,
            std::vector<OptionOf<PictureRequest>>& all) {
  for (const OptionOf<Part>& option : options) {
    OptionOf<PictureRequest> lifted = {static_cast<const OptionInfo&>(option), {}, {}};
    lifted.set = [set = option.set, part](PictureRequest& request,
                                          const std::vector<std::string>& texts) {
      return set(request.*part, texts);
    };
    lifted.get = [get = option.get, part](const PictureRequest& request) {
      return get(request.*part);
    };
    all.push_back(std::move(lifted));
  }
}

}  // namespace

std::span<const OptionOf<PictureRequest>> PictureOptions() {
  static const std::vector<OptionOf<PictureRequest>> options = [] {
    std::vector<OptionOf<PictureRequest>> all;
    Append(JobOptions(), &PictureRequest::job, all);
    Append(LimitOptions(), &PictureRequest::limits, all);
    Append(ExposureOptions(), &PictureRequest::exposure, all);
    Append(ExrFormatOptions(), &PictureRequest::format, all);
    return all;
  }();
  return options;
}

}  // namespace skywave
