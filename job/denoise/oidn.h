// Open Image Denoise, Intel's neural network, where it is installed. It is loaded when it is asked
// for, by its C interface of version 2, so nothing of it is needed to build or run.
#pragma once

#include <string>
#include <vector>

#include "base/error.h"

namespace skywave {

// The library is there and has failed, as when it has no memory.
class OidnError : public InputError {
 public:
  explicit OidnError(const std::string& why);
};

// Looks for the library in the file or folder that the environment variable SKYWAVE_OIDN names,
// where the system finds libraries, and in the package pyoidn of the Python that this program is
// installed in, of an active virtual environment, of the user or of the system. Returns its
// version, "2.5.1"; empty: there is none that works.
std::string OidnVersion();

// Throws OptionError with the places that were looked at, and how to get the library, if there is
// none.
void RequireOidn();

// Three floats per pixel, row by row from the top.
struct OidnPicture {
  int width, height;
  const std::vector<float>& color;   // radiance
  const std::vector<float>& albedo;  // in [0, 1], of first surfaces
  const std::vector<float>& normal;  // of them, world space
};

// Returns the clean picture of a noisy one whose features have no noise, by its network for high
// dynamic range of the highest quality. The bytes do not depend on threads. Throws OptionError if
// there is no library, and OidnError if it fails.
std::vector<float> DenoiseByOidn(const OidnPicture& picture);

}  // namespace skywave
