// Reads and writes whole files. A file is either complete or absent: writers use a temporary name
// in the same folder, which is renamed to the target only once everything is on disk.
#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace skywave {

// What some programs write before UTF-8.
inline constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
// Throws InputError for text that is UTF-16, as its first bytes say.
void RefuseUtf16(std::string_view text, const std::string& path);

// Returns the bytes of `path`. Throws InputError (kExitIo) if it cannot be read or has more than
// `max_bytes` bytes.
std::string ReadFile(const std::string& path, std::size_t max_bytes = std::size_t{8} << 30);

// Calls `write(temporary_path)`, flushes the file to disk, then renames it to `path`. The temporary
// file, "PATH.PROCESS.part", is locked meanwhile, so `write` may not replace it. If `write` throws
// or the rename fails, the temporary file is removed, `path` remains unchanged, and an InputError
// (kExitIo) gives the reason. Links are followed; a target that is not a regular file (a pipe, a
// terminal) is written into. `before_rename` is called when the temporary file is on disk and
// counts as a part of the writing: if it throws, `path` remains unchanged. A second file that it
// writes is replaced just before `path`. Then only the last rename can fail, where `path` is a
// mount point, immutable, or another user's file in a sticky folder: the old `path` remains, beside
// the new second file.
void WriteFileAtomically(const std::string& path,
                         const std::function<void(const std::string& temporary_path)>& write,
                         const std::function<void()>& before_rename = {});
void WriteFileAtomically(const std::string& path, std::string_view bytes);

// The same for bytes that `write` passes on piece by piece.
using PieceWriter = std::function<void(std::string_view piece)>;
void WriteFileInPieces(const std::string& path,
                       const std::function<void(const PieceWriter& out)>& write);

// The same for a file whose first `start_bytes` bytes are known only when all others are there:
// `write` passes on what follows them, and returns them.
void WriteFileStartLast(const std::string& path, std::size_t start_bytes,
                        const std::function<std::string(const PieceWriter& out)>& write,
                        const std::function<void()>& before_rename = {});

// Returns the name of a file beside `path`: the same with `ending` (".checkpoint") in place of its
// own. Where that is more than file systems take, a hash stands for its end.
std::string NameBeside(const std::string& path, std::string_view ending);

// Flushes the folder of `path` to disk, so that the name of a file that has just been written
// survives a loss of power. A folder that cannot be flushed is left as it is.
void SyncFolderOf(const std::string& path);

// Removes the temporary files of `targets` that writers have left because they were killed, and
// returns their number. A writer holds a lock (flock) on its file, which ends with its process, on
// this machine or on another one that shares the folder; so a file is removed only if it can be
// locked. Where a file system has no locks, nothing is removed.
std::size_t RemoveLeftovers(std::span<const std::string> targets);

// Removes the temporary files that this process is writing at the moment. A handler of a signal may
// call it, right before the process ends: afterwards all pending and new writes fail.
void RemoveUnfinishedFiles() noexcept;

// Throws InputError (kExitIo) unless a file could be created at `path`. It is called before a long
// render, so that an unwritable output fails in the first second rather than the last. Also removes
// what killed writers of `path` have left.
void CheckWritable(const std::string& path);
// The same for each of `paths` that is not empty; reads each of their folders once.
void CheckAllWritable(std::span<const std::string> paths);

// A file, and the layer of it that is meant; empty: what the file shows.
struct FileAndLayer {
  std::string path, layer;
};
// Takes a name "FILE:LAYER" apart, where there is such a file and none of the whole name.
FileAndLayer SplitFileName(const std::string& name);

// Throws InputError (kExitUsage) if both names denote the same existing file, or `input` a layer of
// it.
void CheckNotInput(const std::string& output, const std::string& input);
// Checks what a command is going to write, before it works: none of `outputs` may be one of the
// files `inputs` that it reads, and each has to be writable. Empty names are left out.
void CheckOutputs(std::span<const std::string> outputs, std::span<const std::string> inputs);

// Remembers the files that ReadFile reads on this thread while it exists: a scene names textures,
// maps and meshes that are on no command line. If there are several, the last one remembers.
class FilesRead {
 public:
  FilesRead();
  ~FilesRead();
  FilesRead(const FilesRead&) = delete;
  FilesRead& operator=(const FilesRead&) = delete;

  const std::vector<std::string>& names() const { return names_; }
  // Throws as CheckNotInput does if one of `outputs` is one of them.
  void CheckAreNot(std::span<const std::string> outputs) const;

 private:
  friend std::string ReadFile(const std::string& path, std::size_t max_bytes);
  std::vector<std::string> names_;
  FilesRead* before_;
};

}  // namespace skywave
