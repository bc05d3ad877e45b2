// Camera rays: from positions on the film to rays in the world.
#pragma once

#include <cstdint>

#include "kernels/columns.h"

namespace skywave {

inline constexpr std::uint32_t kFilterCells = 1024;

// A pinhole, as a kernel needs it: the ray through film position (x, y) [pixels, from the top left
// corner] has direction corner + x * right + y * down before normalisation.
struct CameraView {
  float origin[3];
  float corner[3], right[3], down[3];  // world space
  std::uint32_t width;                 // [pixels]
  // Inverse of the pixel filter's cumulative distribution, kFilterCells cells: an offset from the
  // pixel's centre [pixels] for a uniform number, linear in between.
  const float* filter_offset;  // kFilterCells + 1 entries
};

// Writes rows [0, n) of `rays`: one ray a path with throughput 1, in path order. `film`: uniforms
// of pair kFilmPair. The pixel filter is sampled, so a sample belongs to one pixel with weight 1.
void GenerateCameraRays(const CameraView& camera, const PathColumns& paths,
                        const UniformColumns& film, std::uint32_t n, const RayColumns& rays);

}  // namespace skywave
