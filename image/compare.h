// How far two pictures are apart (thesis 8.1 and the usual measures).
#pragma once

#include "image/image.h"

namespace skywave {

struct ImageDifference {
  double mean_a = 0, mean_b = 0;     // mean luminance of each
  double mse = 0;                    // mean over pixels of (dr^2 + dg^2 + db^2) / 3
  double rmse = 0;                   // sqrt(mse)
  double relative_mse = 0;           // mean of d^2 / (b^2 + 0.01), b the reference
  double mean_absolute = 0;          // mean of |d| over pixels and channels
  double psnr = 0;                   // [dB] of the clipped sRGB pictures, peak 1
  double thesis_euclidean = 0;       // (T 8.1): mean of (|dr| + |dg| + |db|)^2, the thesis's "Euclidean"
  double thesis_luminance = 0;       // (T 8.1): mean of (0.212671 dr + 0.715160 dg + 0.072169 db)^2
  double max_absolute = 0;           // largest |d| of any channel
  int max_x = 0, max_y = 0;          // where it is
  std::size_t different_pixels = 0;  // pixels whose bits differ
};

// Compares `image` with `reference`; both must have the same size (InputError names the sizes).
ImageDifference Compare(const Image& image, const Image& reference);

// False-colour map of the relative error per pixel, |d| / (b + 0.01) from 0 (dark) to `full_scale`.
std::vector<std::uint8_t> ErrorMap(const Image& image, const Image& reference,
                                   double full_scale = 1.0);

}  // namespace skywave
