// Pictures of the sphere are resampled from one projection to another, and their light is kept.
#pragma once

#include <array>

#include "image/image.h"
#include "lights/maps/environment_map.h"

namespace skywave {

// Returns `image` in projection `to` and of width x height. Every pixel is the mean over its solid
// angle of the source interpolated between pixel centres, by as many samples as the ratio of the
// resolutions asks for; interpolation goes across the seam and the poles of a lat-long map, never
// across the rim of a disk or the edges of faces. The sphere integral of that is within about 1e-3
// of the source's (more for a source whose light is in a few pixels); in the end every channel is
// scaled so that it equals it to float rounding. Pixels without light are black. Light that falls
// between all samples goes to the pixel that has its direction. The same projection and size give
// an exact copy. Runs in parallel; the result does not depend on the threads. Throws InputError
// where CheckProjectionSize does.
Image Resample(const Image& image, Projection from, Projection to, int width, int height);

// Returns the lat-long version of a map: itself, or any other projection resampled to a size that
// keeps its angular resolution: as many columns as an angular map has, 4 columns for 3 of a ball, 2
// for each of an octahedral square, 4 for each pixel of a cube's edge. Throws InputError for a cube
// whose faces are not square.
Image ToLatLong(Image image, Projection projection);

// Returns the integral over the sphere per channel [radiance * sr]: every pixel times its solid
// angle. Pixels that the rim of a disk cuts count with the value of the nearest whole pixel, as
// they are read.
std::array<double, 3> SphereIntegral(const Image& image, Projection projection);

}  // namespace skywave
