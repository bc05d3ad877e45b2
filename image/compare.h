// Measures the difference between two pictures (thesis 8.1 and the usual measures).
#pragma once

#include <span>

#include "image/image.h"

namespace skywave {

// This floor keeps the relative measures finite where the reference is black [radiance,
// radiance^2].
inline constexpr double kRelativeFloor = 0.01;

// dr, dg, db are the differences image - reference of one pixel; d is any one of them. Channels
// whose bits are equal differ by 0, even if they are NaN or infinite; any other NaN makes the means
// NaN.
struct ImageDifference {
  double mean_a = 0, mean_b = 0;  // mean luminance of image and reference
  double mse = 0;                 // mean over pixels of (dr^2 + dg^2 + db^2) / 3
  double rmse = 0;                // sqrt(mse)
  // mean over pixels and channels of d^2 / (b^2 + kRelativeFloor), b the reference
  double relative_mse = 0;
  double mean_absolute = 0;  // mean over pixels and channels of |d|
  // [dB] 10 log10(1 / mse) of both pictures clipped to [0, 1] and sRGB-encoded, not rounded to 8
  // bits; infinite if these are equal.
  double psnr = 0;
  // (T 8.1) mean over pixels of (|dr| + |dg| + |db|)^2, which the thesis calls Euclidean. Its
  // figures are those of dr^2 + dg^2 + db^2, which is 3 * mse (docs/reproduction_tables.md).
  double squared_channel_sum = 0;
  // (T 8.1) mean over pixels of (0.212671 |dr| + 0.715160 |dg| + 0.072169 |db|)^2.
  double thesis_luminance = 0;
  double max_absolute = 0;           // largest |d|; a NaN counts as infinite
  int max_x = 0, max_y = 0;          // the first pixel with that difference
  std::size_t different_pixels = 0;  // pixels whose bits differ
};

// Compares `image` with `reference`, which must have the same size (InputError names the sizes).
ImageDifference Compare(const Image& image, const Image& reference);

// Throws InputError, which names the sizes, unless both pictures have the same one.
void RequireSameSize(const Image& image, const Image& reference);

// Returns false colours of a measure per pixel, 8-bit RGB, from 0 (dark) to `full_scale` and above
// (bright); NaN is bright.
std::vector<std::uint8_t> FalseColors(std::span<const float> values, double full_scale = 1.0);

// Returns a false-colour map of the relative error per pixel, 8-bit RGB, rows from the top: the
// mean |d| of the channels over the mean |b| + kRelativeFloor, from 0 (dark) to `full_scale` and
// above (bright).
std::vector<std::uint8_t> ErrorMap(const Image& image, const Image& reference,
                                   double full_scale = 1.0);

// Returns a false-colour map of the squared error per pixel, likewise: the mean d^2 of the
// channels, by its logarithm from a millionth of `full_scale`^2 and below (dark) to that and above
// (bright).
std::vector<std::uint8_t> LogErrorMap(const Image& image, const Image& reference,
                                      double full_scale = 1.0);

}  // namespace skywave
