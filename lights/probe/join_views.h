// Photographs of a mirror ball from several sides become one map (T 5.1; Debevec 1998): where the
// camera stands in one of them, another one shows what is behind it, and what is stretched along
// the rim of one lies in the middle of another.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "image/image.h"
#include "lights/vector3.h"

namespace skywave {

// A photograph of a mirror ball that fills it (Projection::kMirrorBall).
struct BallView {
  std::string name;  // for messages
  Image image;       // finite, not negative
};

struct JoinOptions {
  double camera = 0.35;  // radius of what is cut out around each camera [rad], above 0
  // How far the camera went around the ball, to its right, from the first view to the second, and
  // from each to the next [rad], within half a radian, and tilted by no more; unset: anywhere.
  std::optional<double> turn;
  int height = 0;  // of the map; 0: that of the resolution of the first view
};

// The images of the axes right, forward and up.
using Rotation = std::array<Vector3, 3>;
inline Vector3 Rotated(const Rotation& r, const Vector3& v) {
  return v.x * r[0] + v.y * r[1] + v.z * r[2];
}
inline Vector3 RotatedBack(const Rotation& r, const Vector3& v) {
  return {Dot(r[0], v), Dot(r[1], v), Dot(r[2], v)};
}

// Returns how far the camera went around the ball, to its right, from where it looks forward [rad]:
// it stands at -forward.
double AngleAround(const Rotation& map_from_view);

struct PlacedView {
  Rotation map_from_view = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  std::array<double, 3> gain = {1, 1, 1};  // factors that make it as bright as the first one
  double agreement = 1;  // correlation of the logarithms of its luminance with those of the first
};

struct JoinedViews {
  Image latlong;  // as the first view has it: its camera looks forward
  std::vector<PlacedView> placed;
  double unseen = 0;  // solid angle that every view has within JoinOptions::camera [sr]
};

// Finds by which rotation each view agrees best with the first one, among all there are, and how
// much brighter it is; each direction of the map is the mean of all, weighted by their resolution
// there, without the surroundings of their cameras. Deterministic. Throws InputError with a name
// for fewer than two views, one that is black or no square, and one that agrees with the first
// nowhere.
JoinedViews JoinViews(const std::vector<BallView>& views, const JoinOptions& options);

}  // namespace skywave
