// The lens of a realistic camera, as the kernel of camera rays reads it (Kolb, Mitchell and
// Hanrahan 1995, "A Realistic Camera Model for Computer Graphics"). Lengths are those of camera
// space; the axis begins at the film and ends in the scene.
#pragma once

#include <cstdint>

namespace skywave {

// What a point of the film sees of the lens, its exit pupil, is known for so many distances from
// the middle of the film.
inline constexpr std::uint32_t kPupils = 64;

struct LensView {
  // Interfaces between media, from the film to the scene: where each crosses the axis; its radius
  // of curvature, which is positive if its centre is on the side of the film, and 0 for a stop,
  // which is a hole in a plane; the square of half its diameter; and the index of refraction on the
  // side of the film over that on the other one.
  std::uint32_t interfaces = 0;
  const float *vertex = nullptr, *radius = nullptr, *aperture2 = nullptr, *eta = nullptr;
  // kPupils boxes in the plane of the first vertex, for points of the film on the x axis.
  const float *pupil_x = nullptr, *pupil_y = nullptr;           // least coordinates
  const float *pupil_width = nullptr, *pupil_height = nullptr;  // sizes
  // Throughput of a ray to the box, over the fourth power of its cosine to the axis.
  const float* pupil_weight = nullptr;
  float half_diagonal = 0;  // of the film, the distance of the last box
};

}  // namespace skywave
