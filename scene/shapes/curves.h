// Tessellates curves with a width (hair, grass, cables) into tubes and ribbons.
#pragma once

#include <array>
#include <cstddef>
#include <glm/glm.hpp>
#include <span>

#include "scene/scene.h"

namespace skywave {

// A cubic Bezier curve. Its width (the diameter of a tube) changes evenly from end to end.
struct CurveSegment {
  std::array<glm::dvec3, 4> points;
  std::array<double, 2> widths;
  // Ribbons: unit normals at the ends, between which that of the ribbon turns evenly.
  std::array<glm::dvec3, 2> normals = {};
};

enum class CurveForm { kTube, kRibbon };

// A segment is cut into pieces whose chords are within this share of its width of the curve, as
// pbrt-v4 subdivides its curves, and along which it turns by few degrees on average; but into so
// many at most.
inline constexpr double kCurveTolerance = 0.05, kCurveTurnDegrees = 4;
inline constexpr int kMaxCurvePieces = 1024;
// A tube as wide as it is long has the most sides, and a longer one fewer: seen at a length of 1000
// pixels, its outline is less than 0.2 pixels off. With the least, a white tube loses 0.6 % of its
// light, because its normals lean from its sides.
inline constexpr int kMinTubeSides = 12, kMaxTubeSides = 96;

// Returns a point of the Bezier curve of four control points.
glm::dvec3 BezierPoint(const glm::dvec3* points, double u);

// Returns how many triangles TessellateCurve makes at most. All points are finite, and no width is
// negative.
std::size_t CurveTriangles(std::span<const CurveSegment> segments, CurveForm form);

// Returns the surface of a curve, segment by segment: segments that meet at an angle are not
// joined, and ends are open, as pbrt has them. Those without length are left out.
//
// A tube has the normals of round cones. Its edges are so far outside of the circle that a straight
// one of constant width has the area of a cylinder, and the mean width of its outline over all
// views. The normal of a ribbon is `normals` made perpendicular to the curve. u goes from 0 to 1
// along each segment. v goes across a ribbon along tangent x normal, and round a tube from 0 to 1
// and back, so that every view shows all of it.
Mesh TessellateCurve(std::span<const CurveSegment> segments, CurveForm form);

}  // namespace skywave
