// A camera in a file that several tests render with.
#pragma once

namespace skywave::test {

// OpenCV's, at the origin; it looks along +z, with y down.
inline constexpr char kCameraFile[] =
    R"({"K": [[40, 0, 15.5], [0, 40, 11.5], [0, 0, 1]],
        "R": [[1, 0, 0], [0, 1, 0], [0, 0, 1]], "t": [0, 0, 0], "width": 32, "height": 24})";

}  // namespace skywave::test
