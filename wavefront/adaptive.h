// Decides where a picture needs samples: how many each block of beams should have so that the
// picture has a wanted relative error at the least cost.
//
// The relative error E of a picture is the root of the mean, over its pixels and channels, of the
// variance of the picture over m^2 + (M / 10)^2. Here m is the mean of the picture nearby and M
// that of the whole picture, so places darker than a tenth of it hardly count as darker than that.
// If r_b is the relative variance of a sample in block b, n_b samples each give E^2 = mean(r_b /
// n_b). The fewest samples in all that reach E are n_b = s_b mean(s) / E^2 with s_b = sqrt(r_b)
// (Neyman 1934). Equal errors everywhere, n_b = r_b / E^2, would take as many samples as equal
// numbers everywhere.
//
// Rare bright samples raise the mean and the variance of a block together, so blocks that stop
// because their own samples look good are too dark on average (Kirk and Arvo 1991). Therefore no
// block decides for itself: blocks are coloured like a chessboard, and what a block should have is
// estimated from blocks of the other colour alone, whose samples are independent of its own. A
// block's neighbours are those of the other colour among the 3 x 5 around it, 12 x 10 pixels.
#pragma once

#include <vector>

#include "wavefront/film/film.h"

namespace skywave {

// Returns how many samples each block of beams of the film should have for the relative error
// `error`, row by row. The film keeps the variance of samples, and has `samples` by pixel, two at
// least. Infinity stands for a block about which no other block has information.
std::vector<double> WantedSamples(const Film& film, const SampleCounts& samples, double error);

}  // namespace skywave
