// Reads triangle meshes in the PLY format (Turk, "The PLY Polygon File Format", 1994): ascii,
// binary little and big endian.
//
// The reader takes x y z, nx ny nz, u v (or s t, texture_u texture_v, texture_s texture_t) and red
// green blue (or diffuse_red and so on) of "vertex", each of any scalar type, and the lists
// vertex_indices (or vertex_index) and texcoord (u, v of each corner) of "face"; or the lists
// vertex_indices of "tristrips", which are strips of triangles that end by -1. Polygons become fans
// around their first corner, which is right for convex ones. Other elements and properties are
// skipped by their size.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "base/error.h"
#include "scene/scene.h"
#include "scene/warnings.h"

namespace skywave {

// What a file has besides its mesh.
struct PlyReport {
  std::size_t polygons = 0;        // faces before they are cut into triangles
  std::size_t bad_normals = 0;     // vertices whose normal was NaN or infinite
  std::size_t small_faces = 0;     // of fewer than three corners, which are left out
  std::size_t trailing_bytes = 0;  // after the last element
  std::string texture;             // the file that a comment of MeshLab names, or nothing
  std::string unknown;             // PlyHeader::unknown
};

// Throws InputError with the byte offset (ascii and headers: the line) for every inconsistency:
// counts that the file cannot hold, short data, indices out of range, positions that are NaN or
// infinite. A vertex whose normal is NaN or infinite
// gets that of the faces around it. Never allocates more than a small multiple of the file's size.
// Winding follows the normals if there are any. The file may be gzip-compressed.
Mesh ReadPly(const std::string& path, PlyReport* report = nullptr);
// The same of a file that may have vertices alone, about the place `origin` of its space.
Mesh ReadPlyPoints(const std::string& path, PlyReport* report, const glm::dvec3& origin);

// Parse the same from memory; `path` appears in messages.
Mesh ParsePly(std::string_view bytes, const std::string& path, PlyReport* report = nullptr);
Mesh ParsePlyPoints(std::string_view bytes, const std::string& path, PlyReport* report,
                    const glm::dvec3& origin);

// Warns of what was not taken as the file has it.
void WarnOfPly(const PlyReport& report, const InputPosition& position, Warnings& warnings);

}  // namespace skywave
