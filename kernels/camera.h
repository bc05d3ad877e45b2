// This kernel turns positions on the film into camera rays in world space.
#pragma once

#include <cstdint>

#include "kernels/columns.h"
#include "kernels/lens.h"

namespace skywave {

inline constexpr std::uint32_t kFilterCells = 1024;

// A beam consists of the camera rays of one sample number in a block of pixels; they follow each
// other in tables and are traced together. Blocks are those of the whole film, whatever part of it
// is rendered, so films are made of whole blocks and pictures are cut out of them.
inline constexpr std::uint32_t kBeamWidth = 4, kBeamHeight = 2;  // [pixels]
inline constexpr std::uint32_t kBeamRays = kBeamWidth * kBeamHeight;
// Rounds `rows` up to whole beams.
constexpr std::uint32_t WholeBeams(std::uint32_t rows) {
  return (rows + kBeamRays - 1) / kBeamRays * kBeamRays;
}

// Perspective and orthographic cameras may have a thin lens. The spherical ones see all directions:
// kLatLong maps them as a lat-long map does, kEqualArea to the square of Clarberg 2008, "Fast
// Equal-Area Mapping of the (Hemi)Sphere using SIMD", whose middle looks straight up. kFisheye is
// equidistant: the angle to the axis grows with the distance from the middle of the film (Blender's
// "Fisheye Equidistant"), in the circle that touches the shorter side; outside of it nothing is
// seen. kRealistic follows rays through the elements of a lens.
enum class CameraKind : std::uint32_t {
  kPerspective,
  kOrthographic,
  kLatLong,
  kEqualArea,
  kFisheye,
  kRealistic
};
// Those that every scene can have.
inline constexpr CameraKind kCameraKinds[] = {CameraKind::kPerspective, CameraKind::kOrthographic,
                                              CameraKind::kLatLong, CameraKind::kEqualArea,
                                              CameraKind::kFisheye};

// True if the film is a plane in front of the camera (or behind its lens), so that depth has an
// axis.
constexpr bool HasPlaneFilm(CameraKind kind) {
  return kind == CameraKind::kPerspective || kind == CameraKind::kOrthographic;
}

// Kernels read a camera in this form, all in world space. Film positions (x, y) are in pixels from
// the top left corner of the whole film.
struct CameraView {
  CameraKind kind = CameraKind::kPerspective;
  float origin[3];
  // Perspective: (x, y) looks along corner + x * right + y * down. Orthographic: the ray begins at
  // that point and looks along forward. All others: right, down and forward are unit axes, but
  // those of a realistic camera, which are as long as a unit of its lens.
  float corner[3], right[3], down[3], forward[3];
  // Half axes of the lens, and the distance of the plane in focus in units of the directions above.
  // A lens_radius of 0 means no lens.
  float lens_x[3], lens_y[3];
  float lens_radius = 0, focal_distance = 1;
  std::uint32_t width = 1, height = 1;              // the part that is kept, whole blocks [pixels]
  std::uint32_t first_column = 0, first_row = 0;    // its corner in the whole film [pixels]
  std::uint32_t whole_width = 1, whole_height = 1;  // [pixels], for spherical cameras and fisheye
  // Fisheye: angle of a pixel, and angle from the axis to the rim of the circle [turns], <= 1/2.
  // Realistic: the angle on the axis.
  float turns_per_pixel = 0, rim_turns = 0;
  // Realistic: the lens, and the side of a pixel in camera space.
  const LensView* realistic = nullptr;
  float pixel_side = 0;
  // The inverse of the pixel filter's cumulative distribution maps a uniform number to an offset
  // from the pixel's centre [pixels], linearly within each of kFilterCells cells.
  const float* filter_offset = nullptr;  // kFilterCells + 1 entries

  bool has_lens() const { return lens_radius > 0 || realistic != nullptr; }
};

// Writes rows [0, n) of `rays`: one ray with throughput 1 per path, in path order. `film` holds the
// uniforms of pair kFilmPair; `lens` those of kLensPair, which are read if the camera has a lens.
// The pixel filter is sampled, so a sample belongs to one pixel with weight 1. Points on the lens
// are uniform over its disk. The throughput of a realistic camera is what its lens lets pass. Where
// that is nothing, and outside the fisheye's circle, the throughput is 0 and the ray is closed
// (negative t_far).
void GenerateCameraRays(const CameraView& camera, const PathColumns& paths,
                        const UniformColumns& film, const UniformColumns& lens, std::uint32_t n,
                        const RayColumns& rays);

}  // namespace skywave
