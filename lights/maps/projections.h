// Projections map directions to points in the pictures of map files and back.
//
// Image points are (u, v) in [0, 1]^2 of the whole picture, u to the right, v down; pixel (i, j) of
// W x H covers [i, i + 1) / W x [j, j + 1) / H. Directions are unit vectors in map space: x right,
// y forward, z up (kernels/lights/environment.h). Seen from inside the sphere no projection but the
// ball, a reflection, is mirrored.
//
//   latlong           forward in the middle, right at u = 3/4, up along the top edge
//   angular           (Debevec 1998) forward in the middle, right to the right, up up; distance
//                     from the middle is the angle from forward, back is the whole rim
//   mirror-ball       a photograph, by a far camera that looks forward, of a mirroring ball that
//                     fills the picture: back (the camera) in the middle, forward the whole rim,
//                     right to the right, up up. Equal areas.
//   horizontal-cross  4:3; left, front, right, back in the middle row, up above and down below
//   vertical-cross    3:4; left, front, right in the second row, up above and down below front,
//                     back below down, upside down, so that it continues where down ends
//   cube-strip        6:1; right, left, up, down, front, back, each as in horizontal-cross
//   cube-column       1:6; left, right, up, down, front, back, one below the other, as OpenEXR's
//                     cube-face maps: up and down are upside down beside those of horizontal-cross
//   octahedral        square of equal areas (Clarberg 2008) as pbrt-v4 reads it: up in the middle,
//                     down in the corners, back at the middle of the right edge, left at that of
//                     the bottom edge: what `imgtool makeequiarea` makes of a lat-long
#pragma once

#include <string>

#include "base/names.h"
#include "lights/maps/environment_map.h"
#include "lights/vector3.h"

namespace skywave {

template <>
inline constexpr auto kEnumNames<Projection> =
    std::to_array<Named<Projection>>({{Projection::kLatLong, "latlong"},
                                      {Projection::kAngular, "angular"},
                                      {Projection::kMirrorBall, "mirror-ball"},
                                      {Projection::kHorizontalCross, "horizontal-cross"},
                                      {Projection::kVerticalCross, "vertical-cross"},
                                      {Projection::kCubeStrip, "cube-strip"},
                                      {Projection::kCubeColumn, "cube-column"},
                                      {Projection::kOctahedral, "octahedral"}});

// Detects a projection by its shape: 2:1 is lat-long, a square is Debevec's angular map, 4:3 a
// horizontal and 3:4 a vertical cube cross, 1:6 a column of faces. Throws InputError for any other
// shape, naming `path` and the flag that decides.
Projection DetectProjection(const Image& image, const std::string& path);

struct ImagePoint {
  double u, v;
};

// Returns the point of a direction; where it has several (the rim of an angular map, the edges of
// faces), one of them.
ImagePoint PointOfDirection(Projection projection, const Vector3& direction);

// Returns nothing where the picture has no light: outside the disk or the arms of a cross.
std::optional<Vector3> DirectionOfPoint(Projection projection, ImagePoint point);

// Returns the solid angle per area of the picture at a point [sr], 0 where the picture has no
// light. Its integral over the picture is 4 pi.
double SolidAngleDensity(Projection projection, ImagePoint point);

// Returns the solid angle of pixel (x, y) [sr]: exact where a closed form exists, else to about
// 1e-6 of a pixel's. The pixels of a picture add up to 4 pi (to 1e-5 where a disk cuts them).
double PixelSolidAngle(Projection projection, int width, int height, int x, int y);

// Throws InputError, naming the sizes that fit, unless a picture of width x height can be of this
// projection: crosses and strips are made of square faces. Others may have any size.
void CheckProjectionSize(Projection projection, int width, int height);

// Returns the number of rows of the lat-long map of the same angular resolution; fewer for squares
// where that would have more than 2^28 texels.
int LatLongHeight(Projection projection, int width, int height);

// Sets the size that keeps the number of texels of a lat-long map of height `latlong_height` around
// the equator, with half as many more for an octahedral square, whose texels are no squares there:
// the default of a conversion.
void DefaultSize(Projection projection, int latlong_height, int& width, int& height);

}  // namespace skywave
