// Tessellates shapes for readers and built-in scenes: closed (except for Quad and Revolve's open
// ends), wound outwards, with unit normals of the smooth surface. y is the axis of round shapes.
#pragma once

#include <functional>
#include <glm/glm.hpp>
#include <span>

#include "scene/scene.h"

namespace skywave {

// The edges of an icosahedron are cut into this many segments: 20 * 32^2 = 20480 triangles. An edge
// then spans about 2 degrees and deviates from the true silhouette by 1.5e-4 of the radius, less
// than a tenth of a pixel for a sphere that fills a 1080-line picture.
inline constexpr int kSphereFrequency = 32;

// Returns a geodesic sphere about the origin: an icosahedron whose faces are split into frequency^2
// triangles each, all vertices on the sphere. It has 10 frequency^2 + 2 vertices, no poles and no
// seam.
Mesh Sphere(float radius, int frequency = kSphereFrequency);

// Returns the square |x|, |z| <= half_size at y = 0, facing up: two triangles, uv in [0, 1].
Mesh Quad(float half_size);

// Returns a box with round edges, centred at the origin; `radius` <= the least of half_size. Each
// rounding has `segments` steps.
Mesh RoundedBox(const glm::vec3& half_size, float radius, int segments);

// Returns the surface of the profile (distance from the axis, height) revolved about y in
// `segments` steps. The outside is on the right of the profile's direction: an outer wall runs
// upwards. Points on the axis become one vertex. Normals come from the smooth profile (central
// differences).
Mesh Revolve(std::span<const glm::vec2> profile, int segments);

// Returns the (p, q) torus knot as a tube: p turns about the axis and q through the hole of a torus
// with the given radii. It has `rings` segments along and `sides` around the tube. (1, 0) is a
// plain torus.
Mesh TorusKnot(int p, int q, float major_radius, float minor_radius, float tube_radius, int rings,
               int sides);

// Moves every position of a sphere-like mesh along its normal by `height`(position), then
// recomputes the normals from the moved triangles.
void Displace(Mesh& mesh, const std::function<float(const glm::vec3&)>& height);

}  // namespace skywave
