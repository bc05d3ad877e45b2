// The planes that the denoiser works on, and how a picture becomes planes.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "image/image.h"
#include "kernels/cross_filter.h"
#include "wavefront/soa.h"

namespace skywave {

// The values of the channels that the denoiser reads, one per pixel.
struct DenoiserInput {
  const Image& image;
  float brightness;  // a power of two near the mean magnitude of its values
  std::span<const float> samples;
  std::span<const float> variance[3];
  std::span<const float> half[3], half_samples, half_variance[3];
  std::span<const float> albedo[3], normal[3], depth, coverage;
};

// Finds and checks them; see Denoise for errors.
DenoiserInput FindInput(const std::string& name, const Image& image,
                        std::span<const NamedChannel> layers);

// One row is one pixel of a plane.
struct TexturePlanes {
  float *r, *g, *b;  // what the picture was divided by

  template <class Self, class F>
  static constexpr void ForEachColumn(Self& self, F f) {
    f(self.r), f(self.g), f(self.b);
  }
};

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
