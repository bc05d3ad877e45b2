// Reads and writes whole files. A file is either complete or absent: writers use a temporary name
// in the same folder, which is renamed to the target only once everything is on disk.
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <string_view>

namespace skywave {

// Returns the bytes of `path`. Throws InputError (kExitIo) if it cannot be read or has more than
// `max_bytes` bytes.
std::string ReadFile(const std::string& path, std::size_t max_bytes = std::size_t{8} << 30);

// Calls `write(temporary_path)`, flushes the file to disk, then renames it to `path`. If `write`
// throws or the rename fails, the temporary file is removed, `path` remains unchanged, and an
// InputError (kExitIo) gives the reason. Links are followed; a target that is not a regular file (a
// pipe, a terminal) is written into.
void WriteFileAtomically(const std::string& path,
                         const std::function<void(const std::string& temporary_path)>& write);
void WriteFileAtomically(const std::string& path, std::string_view bytes);

// Throws InputError (kExitIo) unless a file could be created at `path`. It is called before a long
// render, so that an unwritable output fails in the first second rather than the last.
void CheckWritable(const std::string& path);

// Throws InputError (kExitUsage) if both names denote the same existing file.
void CheckNotInput(const std::string& output, const std::string& input);

}  // namespace skywave
