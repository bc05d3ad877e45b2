// Portals, the openings through which the light of the map enters, as scenes give them: four
// corners, or a mesh of rectangles.
#pragma once

#include <array>
#include <vector>

#include "scene/scene.h"

namespace skywave {

// Returns the portal with these corners. As in pbrt-v4 they go round counter-clockwise for those
// whom the light reaches, if the axes are drawn right-handed. Throws InputError, without a
// position, unless they are those of a rectangle, to a thousandth of its sides.
Portal PortalOfCorners(const std::array<glm::vec3, 4>& corners);

// Returns the rectangles that a mesh is made of, each of two triangles. Their normals are on the
// side that the light reaches. Throws InputError, without a position, where there is anything else.
std::vector<Portal> PortalsOfMesh(const Mesh& mesh);

}  // namespace skywave
