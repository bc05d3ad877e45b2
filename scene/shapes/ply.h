// Reads triangle meshes in the PLY format (Turk, "The PLY Polygon File Format", 1994): ascii,
// binary little and big endian.
//
// The reader takes x y z, nx ny nz and u v (or s t, texture_u texture_v, texture_s texture_t) of
// "vertex", each of any scalar type, and the list vertex_indices (or vertex_index) of "face".
// Polygons become fans around their first corner, which is right for convex ones. Other elements
// and properties are skipped by their size.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "scene/scene.h"

namespace skywave {

// Throws InputError with the byte offset (ascii and headers: the line) for every inconsistency:
// counts that the file cannot hold, short or overlong data, indices out of range, faces of fewer
// than three corners, positions or normals that are NaN or infinite. Never allocates more than a
// small multiple of the file's size. Winding follows the normals if there are any. The file may be
// gzip-compressed. `polygons` gets the number of faces before they are cut into triangles.
Mesh ReadPly(const std::string& path, std::size_t* polygons = nullptr);

// Parses the same from memory; `path` appears in messages.
Mesh ParsePly(std::string_view bytes, const std::string& path, std::size_t* polygons = nullptr);

}  // namespace skywave
