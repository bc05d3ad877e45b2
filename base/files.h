// Whole files in and out. A file is either complete or not there: writers go to a temporary name in
// the same folder, which is renamed over the target only once everything is on disk.
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <string_view>

namespace skywave {

// The bytes of `path`. Throws InputError (kExitIo) when it cannot be read or has more than
// `max_bytes` bytes.
std::string ReadFile(const std::string& path, std::size_t max_bytes = std::size_t{8} << 30);

// Calls `write(temporary_path)`, brings the file to disk, then renames the temporary file to
// `path`. When `write` throws or the rename fails the temporary file is removed, `path` stays as it
// was, and an InputError (kExitIo) tells why. Links are followed; what is no regular file (a pipe,
// a terminal) is written into.
void WriteFileAtomically(const std::string& path,
                         const std::function<void(const std::string& temporary_path)>& write);
void WriteFileAtomically(const std::string& path, std::string_view bytes);

// Throws InputError (kExitIo) unless a file could be created at `path`: asked before a long render,
// so that an unwritable output is found in the first second and not in the last.
void CheckWritable(const std::string& path);

// Throws InputError (kExitUsage) if both names are the same existing file.
void CheckNotInput(const std::string& output, const std::string& input);

}  // namespace skywave
