#include "scene/shapes/curves.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/constants.hpp>
#include <vector>

#include "scene/shapes/patches.h"

namespace skywave {
namespace {

// The length of the control polygon, which is at least that of the curve.
double PolygonLength(const CurveSegment& segment) {
  double length = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    length += glm::distance(segment.points[i], segment.points[i + 1]);
  }
  return length;
}

double AngleBetween(const glm::dvec3& a, const glm::dvec3& b) {
  return std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b));
}

int CountPieces(const CurveSegment& segment) {
  const auto& p = segment.points;
  // A quadratic deviates from its chord by an eighth of its second derivative, whose largest value
  // is at an end of a cubic, 6 times this.
  const double bend =
      std::max(glm::length(p[0] - 2.0 * p[1] + p[2]), glm::length(p[1] - 2.0 * p[2] + p[3]));
  const double width = std::max(segment.widths[0], segment.widths[1]);
  const double of_chords = std::sqrt(6 * bend / (8 * kCurveTolerance * width));
  // A curve turns by no more than its polygon.
  double turn = 0;
  glm::dvec3 before(0);
  for (std::size_t i = 0; i < 3; ++i) {
    const glm::dvec3 leg = p[i + 1] - p[i];
    if (leg == glm::dvec3(0)) continue;
    if (before != glm::dvec3(0)) turn += AngleBetween(before, leg);
    before = leg;
  }
  turn = std::max(turn, AngleBetween(segment.normals[0], segment.normals[1]));
  const double of_turn = turn / glm::radians(kCurveTurnDegrees);
  return int(std::clamp(std::ceil(std::max(of_chords, of_turn)), 1.0, double(kMaxCurvePieces)));
}

// Returns the number of sides of a tube, which is even.
int CountSides(std::span<const CurveSegment> segments) {
  double length = 0, width = 0;
  for (const CurveSegment& segment : segments) {
    length += PolygonLength(segment);
    width = std::max({width, segment.widths[0], segment.widths[1]});
  }
  const double sides = kMaxTubeSides * std::sqrt(std::min(width / length, 1.0));
  return 2 * int(std::ceil(std::max(sides, double(kMinTubeSides)) / 2));
}

// Returns the number of strips side by side of which a ribbon is made. Two triangles across all of
// one that turns would have the slope of its edges, by which the area grows, everywhere; with
// strips the area is off by a thousandth.
int CountStrips(const CurveSegment& segment) {
  constexpr double kStrips = 18;  // for an edge at 45 degrees to the curve
  constexpr int kMost = 64;
  const double width = std::max(segment.widths[0], segment.widths[1]);
  const double slope =
      AngleBetween(segment.normals[0], segment.normals[1]) * width / 2 / PolygonLength(segment);
  return int(std::clamp(std::ceil(kStrips * slope), 1.0, double(kMost)));
}

glm::dvec3 DerivativeAt(const CurveSegment& segment, double u) {
  const double s = 1 - u;
  const auto& p = segment.points;
  return 3.0 * (s * s * (p[1] - p[0]) + 2 * s * u * (p[2] - p[1]) + u * u * (p[3] - p[2]));
}

// Returns the direction of the curve, which where it stands still, as at an end whose control point
// is given twice, is that beside it.
glm::dvec3 TangentAt(const CurveSegment& segment, double u, double length) {
  glm::dvec3 derivative(0);
  for (const double beside : {0.0, 1e-3, 1e-2, 1e-1}) {
    derivative = DerivativeAt(segment, u < 0.5 ? u + beside : u - beside);
    if (glm::length(derivative) > 1e-6 * length) break;
  }
  return glm::normalize(derivative);
}

// Returns `v` made perpendicular to the unit vector `to`, of unit length, or any other such vector
// if it is parallel to it.
glm::dvec3 Across(const glm::dvec3& v, const glm::dvec3& to) {
  const glm::dvec3 across = v - to * glm::dot(to, v);
  if (glm::length(across) > 1e-9) return glm::normalize(across);
  const glm::dvec3 other = std::abs(to.x) < 0.5 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
  return glm::normalize(glm::cross(other, to));
}

// The normal of a ribbon turns about a fixed axis.
glm::dvec3 NormalAt(const CurveSegment& segment, double u) {
  const auto& [n0, n1] = segment.normals;
  const double angle = AngleBetween(n0, n1), sine = std::sin(angle);
  if (sine < 1e-6) return angle < 1 || u < 0.5 ? n0 : n1;
  return (std::sin((1 - u) * angle) * n0 + std::sin(u * angle) * n1) / sine;
}

// A cross section of a curve.
struct Section {
  glm::dvec3 centre, tangent;
  glm::dvec3 side;      // unit; of a ribbon: its normal, as it is asked for
  double width, slope;  // slope: that of the radius along the curve
};

// Appends the tube about sections, `sides` round it.
void AddTube(const std::vector<Section>& sections, int sides, Mesh& mesh) {
  const auto pieces = int(sections.size()) - 1;
  const double step = glm::two_pi<double>() / sides;
  const double reach = step / 2 / std::sin(step / 2);  // of an edge, by the radius
  AddPatch(
      pieces, sides,
      [&](double u, double v) {
        const Section& at = sections[std::size_t(std::lround(u * pieces))];
        const double angle = step * double(std::lround(v * sides) % sides);
        const glm::dvec3 radial =
            std::cos(angle) * at.side + std::sin(angle) * glm::cross(at.side, at.tangent);
        return SurfacePoint{at.centre + reach * at.width / 2 * radial,
                            radial - at.slope * at.tangent,
                            {u, 1 - std::abs(1 - 2 * v)}};
      },
      mesh);
}

void AddRibbon(const std::vector<Section>& sections, int strips, Mesh& mesh) {
  const auto pieces = int(sections.size()) - 1;
  AddPatch(
      pieces, strips,
      [&](double u, double v) {
        const Section& at = sections[std::size_t(std::lround(u * pieces))];
        const glm::dvec3 normal = Across(at.side, at.tangent);
        return SurfacePoint{
            at.centre + (v - 0.5) * at.width * glm::cross(normal, at.tangent), normal, {u, 1 - v}};
      },
      mesh);
}

}  // namespace

glm::dvec3 BezierPoint(const glm::dvec3* points, double u) {
  const double s = 1 - u;
  return s * s * s * points[0] + 3 * s * s * u * points[1] + 3 * s * u * u * points[2] +
         u * u * u * points[3];
}

std::size_t CurveTriangles(std::span<const CurveSegment> segments, CurveForm form) {
  const int sides = CountSides(segments);
  std::size_t triangles = 0;
  for (const CurveSegment& segment : segments) {
    if (!(PolygonLength(segment) > 0)) continue;
    const int across = form == CurveForm::kTube ? sides : CountStrips(segment);
    triangles += 2 * std::size_t(CountPieces(segment)) * std::size_t(across);
  }
  return triangles;
}

Mesh TessellateCurve(std::span<const CurveSegment> segments, CurveForm form) {
  const int sides = CountSides(segments);
  Mesh mesh;
  std::vector<Section> sections;
  glm::dvec3 side(0);  // goes on with the curve, and does not turn about it
  for (const CurveSegment& segment : segments) {
    const double length = PolygonLength(segment);
    if (!(length > 0)) continue;
    const int pieces = CountPieces(segment);
    sections.clear();
    for (int i = 0; i <= pieces; ++i) {
      const double u = double(i) / pieces;
      const glm::dvec3 tangent = TangentAt(segment, u, length);
      const double speed = std::max(glm::length(DerivativeAt(segment, u)), 1e-6 * length);
      side = form == CurveForm::kTube ? Across(side, tangent) : NormalAt(segment, u);
      sections.push_back({BezierPoint(segment.points.data(), u), tangent, side,
                          glm::mix(segment.widths[0], segment.widths[1], u),
                          (segment.widths[1] - segment.widths[0]) / 2 / speed});
    }
    form == CurveForm::kTube ? AddTube(sections, sides, mesh)
                             : AddRibbon(sections, CountStrips(segment), mesh);
  }
  return mesh;
}

}  // namespace skywave
