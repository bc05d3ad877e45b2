// Sums of pictures, each of them with factors of its own.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "image/image.h"

namespace skywave {

// Returns a picture for each of `rows`: the sum of `images`, which are not none and have one size,
// times the row's factors of their red, green and blue. Sums are made in double and rounded once.
// The images are read once for all rows, in parallel.
std::vector<Image> WeightedSums(std::span<const Image> images,
                                std::span<const std::vector<std::array<float, 3>>> rows);

}  // namespace skywave
