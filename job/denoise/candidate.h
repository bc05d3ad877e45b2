// Clean pictures before one is chosen: light with its error.
#pragma once

#include <cstdint>
#include <vector>

#include "job/denoise/denoised.h"
#include "job/denoise/outliers.h"
#include "job/denoise/planes.h"

namespace skywave {

// A clean picture, textures divided out, with its estimated squared error.
struct Candidate {
  explicit Candidate(std::uint32_t size)
      : light(size, soa::Touch::kLater), squared_error(size, soa::Touch::kLater) {}
  soa::Table<TexturePlanes> light;
  soa::Table<ErrorPlanes> squared_error;
};

// Returns the planes of a half, without values.
soa::Table<HalfPlanes> NewHalf(const PlaneShape& shape);

// Returns the mean of halves, without its error.
Candidate MeanOfHalves(const DenoiserPlanes& planes, const HalfPlanes (&halves)[2]);

// Returns the mean of halves that were filtered pixel by pixel, or not at all, with its error.
Candidate WithError(const DenoiserPlanes& planes, const HalfPlanes (&halves)[2]);

// Writes the estimated squared error of a picture whose halves were cleaned to `clean`, each by
// itself: what they differ by is their variance, and the product of what both have changed is the
// square of their common bias, since the noise of one half knows nothing of the other's. Both are
// means over many pixels: a network errs alike over whole regions, by less than the noise of few.
void EstimateWide(const DenoiserPlanes& planes, const HalfTables& clean,
                  const ErrorPlanes& squared_error);

// Replaces a plane, whose rim is written, by its means over the pixels around, `around` on each
// side; the rim means nothing then.
void AverageAround(const PlaneShape& shape, int around, std::vector<float>& plane);

// Returns the picture that a candidate shows: textures multiplied back, and outliers spread.
Denoised PictureOf(const DenoiserPlanes& planes, const OutlierExcess& outliers,
                   const Candidate& clean, bool with_error);

}  // namespace skywave
