// Maps that move: a pattern names one file for each frame. "sky_####.exr" stands for sky_0007.exr
// at frame 7.
#pragma once

#include <string>

#include "job/request.h"

namespace skywave {

// Returns whether `path` is a pattern: the name of the file has a #, and there is no file of that
// very name.
bool IsMapSequence(const std::string& path);

// Returns the file of the request's map: that of its frame where the map is a sequence. The last
// run of # in the name becomes the number of the frame, with zeros in front up to the length of the
// run. Throws OptionError where there is no frame, or one that is no whole number.
std::string MapFile(const JobRequest& request);

}  // namespace skywave
