// Tells where a picture needs samples: how many each block of beams should have so that the picture
// has a wanted relative error at the least cost.
//
// The relative error E of a picture is the root of the mean, over its pixels and channels, of the
// variance of the picture over m^2 + (M / 10)^2: m is the mean of the picture nearby and M that of
// the whole picture, so that places darker than a tenth of it count as if they were as bright as
// that. With relative variances r_b of a sample in blocks b, sum(r_b / n_b) is the error of n_b
// samples. It is E^2 at the least sum(n_b) for n_b = s_b mean(s) / E^2, s_b = sqrt(r_b): Neyman's
// allocation. Equal errors everywhere, n_b = r_b / E^2, take as many samples as without any choice.
//
// Who stops where samples happen to look good keeps what is too dark, since rare bright samples
// raise mean and variance together. So no block decides about itself: blocks are coloured like a
// chessboard, and what a block should have is estimated from blocks of the other colour alone,
// whose samples are independent of its own. Nearby are the blocks of the other colour among the
// 3 x 5 around a block, 12 x 10 pixels.
#pragma once

#include <vector>

#include "wavefront/film/film.h"

namespace skywave {

// Returns how many samples each block of beams of the film should have for the relative error
// `error`, row by row. The film keeps the variance of samples, and has `samples` by pixel, two at
// least. Infinity stands for a block of which no other one knows anything.
std::vector<double> WantedSamples(const Film& film, const SampleCounts& samples, double error);

}  // namespace skywave
