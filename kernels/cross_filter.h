// These kernels average pixels that are equal within their noise: a statistical denoiser.
//
// The samples of a pixel come in two halves. Whether pixel j may be averaged with pixel i is
// decided by one half, and what is averaged are the values of the other: so a pixel is not chosen
// for being bright by chance, and nothing that is chosen is favoured (Rousselle et al. 2012; NFOR,
// Bitterli et al. 2016). The decision is a test of equal means (Sakai et al. 2024): with the
// squared distance of the colours in units of its variance,
//
//   z = |c_i - c_j|^2 / (v_i + v_j),
//
// whose expectation is 1 for equal pixels, and its mean over 3 x 3 such pairs around i and j. A
// pixel that is much noisier than i says little about i and weighs less, by the ratio of variances;
// geometry and textures are compared by features that have little noise.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace skywave {

// The planes of a picture have a rim, so that a filter may look beyond the picture's edge.
struct PlaneShape {
  static constexpr int kRim = 16;  // pixels, on each side
  int width = 0, height = 0;       // of the picture

  // A row ends with room for a whole vector.
  std::size_t pitch() const { return (std::size_t(width) + 15) / 16 * 16 + 2 * kRim; }
  std::size_t size() const { return pitch() * (std::size_t(height) + 2 * kRim); }
  // Returns the place of a pixel, which may be in the rim.
  std::size_t at(int x, int y) const {
    return std::size_t(y + kRim) * pitch() + std::size_t(x + kRim);
  }
};

// One row is one pixel of a plane. The rim repeats the edge of the picture.
struct HalfPlanes {
  // Mean of half of the samples, textures divided out, in units of the picture's brightness.
  float *r, *g, *b;
  float* noise;  // variance of r, plus those of g and b

  template <class Self, class F>
  static constexpr void ForEachColumn(Self& self, F f) {
    f(self.r), f(self.g), f(self.b), f(self.noise);
  }
};

// A pair further apart than this, squared and in units of its variance, is not averaged, whatever
// its neighbours say; nor is a pixel with what a fit says of it (kernels/feature_fit.h).
inline constexpr float kFarApart = 4;
// Noise that is less than this is none.
inline constexpr float kNoNoise = 1e-20f;

// What the picture was divided by, in its own colours: albedo where there are surfaces.
struct TexturePlanes {
  float *r, *g, *b;

  template <class Self, class F>
  static constexpr void ForEachColumn(Self& self, F f) {
    f(self.r), f(self.g), f(self.b);
  }
};

// Feature differences, in units of the rejection threshold. Border pixels get a coverage that never
// matches, kNoCoverage.
inline constexpr float kCoverageUnit = 0.15f;
inline constexpr float kDepthUnit = 0.02f;  // of the distance
inline constexpr float kNoCoverage = 1e4f;
struct FeaturePlanes {
  float *normal_x, *normal_y, *normal_z;
  float *albedo_r, *albedo_g, *albedo_b;
  float *depth, *depth_dx, *depth_dy;  // logarithm, and its change from pixel to pixel
  float* coverage;

  template <class Self, class F>
  static constexpr void ForEachColumn(Self& self, F f) {
    f(self.normal_x), f(self.normal_y), f(self.normal_z);
    f(self.albedo_r), f(self.albedo_g), f(self.albedo_b);
    f(self.depth), f(self.depth_dx), f(self.depth_dy);
    f(self.coverage);
  }
};

// A pixel is averaged with those at multiples of `stride`, at most `radius` of them away in x and
// y.
struct FilterLevel {
  int radius, stride;
};
inline constexpr FilterLevel kFilterLevels[] = {{1, 1}, {2, 2}, {2, 6}};

// A part of the picture, small enough for the second-level cache.
struct FilterTile {
  static constexpr int kWidth = 64, kHeight = 8;
  int x, y, width, height;
};

// Writes the noise of row `y`, raised where a pixel has missed the rare bright samples of its
// neighbours and with them their variance: it gets at least the geometric mean of the 3 x 3 pixels
// around it, and at least a share of their mean, the larger the fewer `samples` it has. Pixels that
// both halves see much brighter count less for that. A pixel without any noise, as where no sample
// found light, gets the mean. `samples` and `noise` are planes.
void SmoothNoise(const PlaneShape& shape, const HalfPlanes& half, const HalfPlanes& other,
                 const float* samples, int y, float* noise);

// Replaces the values of row `y` of a plane, all positive, by `scale` times their natural
// logarithms.
void TakeLogarithms(const PlaneShape& shape, int y, float scale, float* plane);

// Filters a tile: writes the average of both halves, each weighted by the other one, and its noise.
// The rim of `out` is not written.
void CrossFilter(const PlaneShape& shape, const FeaturePlanes& features, const HalfPlanes (&in)[2],
                 const FilterLevel& level, const FilterTile& tile, const HalfPlanes (&out)[2]);

// What another frame of an animation shows of the surfaces of a tile, at their places in this one:
// planes of the size of the tile, of which the rim is written one pixel wide. Where it does not
// show them, coverage is kNoCoverage.
struct BroughtTile {
  PlaneShape shape;
  FeaturePlanes features;
  HalfPlanes halves[2];
};

// Averages a tile over frames: writes the mean of what is equal within its noise, each half
// weighted by the other one, and its noise. The rim of `out` is not written.
void AverageFrames(const PlaneShape& shape, const FeaturePlanes& features,
                   const HalfPlanes (&in)[2], std::span<const BroughtTile> others,
                   const FilterTile& tile, const HalfPlanes (&out)[2]);

// One row is one pixel of a plane.
struct ErrorPlanes {
  float *r, *g, *b;

  template <class Self, class F>
  static constexpr void ForEachColumn(Self& self, F f) {
    f(self.r), f(self.g), f(self.b);
  }
};

// Writes the estimated squared error of the mean of the `filtered` halves of `noisy`, for one row.
//
// The variance is what differs between the halves. The bias is what both have in common: with x the
// noisy and f the filtered halves, (f_0 - x_1)(f_1 - x_0) has the squared bias as its expectation,
// because the noise of the two halves is independent, except for the share of x in its own average.
// Both are means over the neighbourhood, of 3 x 3 and of 5 x 5 pixels, whichever is larger.
void EstimateError(const PlaneShape& shape, const HalfPlanes (&noisy)[2],
                   const HalfPlanes (&filtered)[2], const FilterTile& tile,
                   const ErrorPlanes& squared_error);

}  // namespace skywave
