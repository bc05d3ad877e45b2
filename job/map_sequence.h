// Maps that move: a pattern names one file for each frame. "sky_####.exr" stands for sky_0007.exr
// at frame 7.
#pragma once

#include <cstdint>
#include <string>

#include "job/request.h"

namespace skywave {

// Returns whether the name of a file has a #.
bool HasNumber(const std::string& path);
// Returns a name with a number in place of its last run of #, with zeros in front up to the length
// of the run.
std::string NumberedFile(const std::string& path, std::int64_t number);

// Returns whether `path` is a pattern: the name of the file has a #, and there is no file of that
// very name.
bool IsMapSequence(const std::string& path);

// Returns the file of the request's map: that of its frame where the map is a sequence. Throws
// OptionError where there is no frame, or one that is no whole number.
std::string MapFile(const JobRequest& request);
// Returns the request's strategy, with the file of its frame where that has a #.
std::string StrategyOfFrame(const JobRequest& request);

}  // namespace skywave
