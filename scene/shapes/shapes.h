// Tessellated shapes for readers and built-in scenes: closed (but for Quad and Revolve's open
// ends), wound outwards, with unit normals of the smooth surface. y is the axis of round shapes.
#pragma once

#include <functional>
#include <glm/glm.hpp>
#include <span>

#include "scene/scene.h"

namespace skywave {

// The edges of an icosahedron are cut into this many: 20 * 32^2 = 20480 triangles. An edge then
// spans about 2 degrees and leaves the true silhouette by 1.5e-4 of the radius: less than a tenth
// of a pixel for a sphere that fills a 1080-line picture.
inline constexpr int kSphereFrequency = 32;

// A geodesic sphere about the origin: an icosahedron whose faces are split into frequency^2
// triangles each, all vertices on the sphere. 10 frequency^2 + 2 vertices. No poles, no seam.
Mesh Sphere(float radius, int frequency = kSphereFrequency);

// The square |x|, |z| <= half_size at y = 0, facing up. Two triangles, uv in [0, 1].
Mesh Quad(float half_size);

// A box with round edges, centred at the origin; `radius` <= the least of half_size. Each rounding
// has `segments` steps.
Mesh RoundedBox(const glm::vec3& half_size, float radius, int segments);

// The surface of the profile (distance from the axis, height) turned about y, in `segments` steps.
// The profile runs so that the outside is on its right: upwards for an outer wall. Points on the
// axis become one vertex. Normals come from the smooth profile (central differences).
Mesh Revolve(std::span<const glm::vec2> profile, int segments);

// The (p, q) torus knot: p turns about the axis and q through the hole of a torus with the given
// radii, as a tube. `rings` along, `sides` around. (1, 0) is a plain torus.
Mesh TorusKnot(int p, int q, float major_radius, float minor_radius, float tube_radius, int rings,
               int sides);

// Moves every position of a sphere-like mesh along its normal by `height`(position), then takes
// normals from the moved triangles.
void Displace(Mesh& mesh, const std::function<float(const glm::vec3&)>& height);

}  // namespace skywave
