// Files that may be gzip-compressed (RFC 1952): pbrt scenes and PLY meshes are often kept so.
#pragma once

#include <cstddef>
#include <string>

namespace skywave {

// The bytes themselves, unpacked if they begin as gzip does; members that follow each other are
// joined. Throws InputError with the byte offset if they are cut or corrupt, or unpack to more than
// `max_bytes`. `path` is for messages.
std::string Gunzip(std::string bytes, const std::string& path,
                   std::size_t max_bytes = std::size_t{8} << 30);

}  // namespace skywave
