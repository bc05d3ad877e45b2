// The planes that the denoiser works on, and how a picture becomes planes.
#pragma once

#include "job/denoise/input.h"
#include "kernels/cross_filter.h"
#include "wavefront/soa.h"

namespace skywave {

struct DenoiserPlanes {
  explicit DenoiserPlanes(const PlaneShape& shape);

  PlaneShape shape;
  soa::Table<TexturePlanes> texture;
  soa::Table<HalfPlanes> halves[2];
  soa::Table<FeaturePlanes> features;
};

// Writes row `y` of the planes of the picture, without rims.
void ReadRow(const DenoiserInput& input, int y, DenoiserPlanes& planes);
// Writes the slopes of the depth in row `y`, when all rows have been read.
void FindSlopes(const PlaneShape& shape, int y, const FeaturePlanes& features);

// Writes the rim of a plane: the nearest pixel of the picture, or one value.
void RepeatEdge(const PlaneShape& shape, float* plane);
void FillRim(const PlaneShape& shape, float value, float* plane);

}  // namespace skywave
