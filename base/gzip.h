// Unpacks gzip-compressed files (RFC 1952), a common form of pbrt scenes and PLY meshes.
#pragma once

#include <cstddef>
#include <string>

namespace skywave {

// Returns the bytes, unpacked if they begin with the gzip signature; consecutive members are
// concatenated. Throws InputError with the byte offset if they are truncated or corrupt, or unpack
// to more than `max_bytes`. `path` appears in messages.
std::string Gunzip(std::string bytes, const std::string& path,
                   std::size_t max_bytes = std::size_t{8} << 30);

}  // namespace skywave
