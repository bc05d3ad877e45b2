#include "base/files.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>
#include <xxhash.h>

#include <array>
#include <atomic>
#include <cassert>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <map>
#include <memory>
#include <set>
#include <stdexcept>
#include <utility>
#include <vector>

#include "base/error.h"
#include "base/large_memory.h"

namespace skywave {
namespace {

struct CloseFile {
  void operator()(std::FILE* file) const { std::fclose(file); }
};
using FileHandle = std::unique_ptr<std::FILE, CloseFile>;

[[noreturn]] void ThrowIo(const std::string& path, const std::string& reason) {
  throw InputError(InputPosition::File(path), reason, kExitIo);
}

// Returns true for files that are written into rather than replaced: a terminal, a pipe, /dev/null.
bool IsSpecial(const std::string& path) {
  std::error_code ignored;
  return std::filesystem::exists(path, ignored) &&
         !std::filesystem::is_regular_file(path, ignored) &&
         !std::filesystem::is_directory(path, ignored);
}

// Returns the file that a link points to, so that the link survives.
std::string Target(const std::string& path) {
  std::error_code error;
  if (!std::filesystem::is_symlink(path, error)) return path;
  const std::filesystem::path target = std::filesystem::weakly_canonical(path, error);
  return error ? path : target.string();
}

void SyncToDisk(const std::string& path) {
  const int file = ::open(path.c_str(), O_RDONLY);
  if (file < 0) return;
  const bool synced = ::fsync(file) == 0;
  const int error = errno;
  ::close(file);
  if (!synced) throw std::runtime_error(std::strerror(error));
}

constexpr std::string_view kTemporaryEnding = ".part";
// File systems take names of 255 bytes. The stem leaves room for the number of a process and the
// ending.
constexpr std::size_t kLongestName = 255, kLongestStem = 230, kHashDigits = 16;

// Returns `name`, or its start and a hash of it where it has more than `most` bytes.
std::string Shortened(const std::string& name, std::size_t most) {
  if (name.size() <= most) return name;
  return fmt::format("{}{:0{}x}", name.substr(0, most - kHashDigits),
                     XXH3_64bits(name.data(), name.size()), kHashDigits);
}

// Returns what temporary names of the file `name` begin with.
std::string TemporaryStem(const std::string& name) { return Shortened(name, kLongestStem); }

std::string TemporaryName(const std::string& target) {
  const std::filesystem::path path = target;
  const std::string name =
      fmt::format("{}.{}{}", TemporaryStem(path.filename().string()), ::getpid(), kTemporaryEnding);
  return path.has_parent_path() ? (path.parent_path() / name).string() : name;
}

// Returns the stem of a temporary name, or nothing if `name` is none.
std::string_view StemOfTemporary(std::string_view name) {
  if (!name.ends_with(kTemporaryEnding)) return {};
  name.remove_suffix(kTemporaryEnding.size());
  const std::size_t dot = name.rfind('.');
  if (dot == std::string_view::npos || dot + 1 == name.size()) return {};
  const bool process = name.find_first_not_of("0123456789", dot + 1) == std::string_view::npos;
  return process ? name.substr(0, dot) : std::string_view();
}

// Holds a lock on the file `path`, if there is one and its file system has locks, until its end.
class FileLock {
 public:
  FileLock(const std::string& path, int open_flags, int lock_flags)
      : file_(::open(path.c_str(), open_flags, 0666)) {
    locked_ = file_ >= 0 && ::flock(file_, LOCK_EX | lock_flags) == 0;
    struct stat opened = {}, named = {};
    is_named_ = locked_ && ::fstat(file_, &opened) == 0 && ::stat(path.c_str(), &named) == 0 &&
                opened.st_dev == named.st_dev && opened.st_ino == named.st_ino;
  }
  ~FileLock() {
    if (file_ >= 0) ::close(file_);
  }
  FileLock(const FileLock&) = delete;
  FileLock& operator=(const FileLock&) = delete;
  bool locked() const { return locked_; }
  // Returns whether the locked file still has the name: another process that held the lock may have
  // renamed or removed it, and the name may be that of a newer file.
  bool is_named() const { return is_named_; }

 private:
  int file_;
  bool locked_ = false, is_named_ = false;
};

// RemoveUnfinishedFiles sets this: a temporary file that is made now would be left behind.
std::atomic<bool> process_ends = false;
static_assert(std::atomic<bool>::is_always_lock_free, "handlers of signals may set this");

// Makes a temporary file and locks it. RemoveLeftovers of another process may remove it before it
// is locked; then it is made again. Not every file system has locks or distinguishes files, so the
// last attempt has to do. A file that cannot be made is reported by its writer. Throws if the
// process is about to end, whose handler may have looked for the file before it was there.
std::unique_ptr<FileLock> MakeLocked(const std::string& temporary) {
  for (int attempts = 10;; --attempts) {
    auto lock = std::make_unique<FileLock>(temporary, O_RDWR | O_CREAT | O_CLOEXEC, 0);
    if (process_ends) throw std::runtime_error("the process is about to end");
    if (lock->is_named() || !lock->locked() || attempts == 1) return lock;
  }
}

// A temporary file that RemoveUnfinishedFiles has to know.
struct UnfinishedFile {
  std::string name;
  pid_t writer;  // a process that was forked meanwhile has this record too
};
// There are as many writers as threads that write, a handful; the files of more are left to
// RemoveLeftovers.
std::array<std::atomic<UnfinishedFile*>, 64> unfinished_files;
static_assert(std::atomic<UnfinishedFile*>::is_always_lock_free, "handlers of signals use these");

// Keeps a file among the unfinished ones until its end.
class UnfinishedFileScope {
 public:
  explicit UnfinishedFileScope(const std::string& name)
      : file_(new UnfinishedFile{name, ::getpid()}) {
    for (auto& place : unfinished_files) {
      UnfinishedFile* nobody = nullptr;
      if (!place.compare_exchange_strong(nobody, file_)) continue;
      place_ = &place;
      return;
    }
  }
  ~UnfinishedFileScope() {
    UnfinishedFile* own = file_;
    // A handler that has taken the record is reading it, and the process is about to end.
    if (place_ == nullptr || place_->compare_exchange_strong(own, nullptr)) delete file_;
  }
  UnfinishedFileScope(const UnfinishedFileScope&) = delete;
  UnfinishedFileScope& operator=(const UnfinishedFileScope&) = delete;

 private:
  UnfinishedFile* file_;
  std::atomic<UnfinishedFile*>* place_ = nullptr;
};

// A file that is written under a temporary name. Errors give its own name.
class OutputFile {
 public:
  OutputFile(const std::string& path, const std::string& temporary)
      : path_(path), file_(std::fopen(temporary.c_str(), "wb")) {
    if (!file_) Fail();
  }
  void Write(std::string_view bytes) {
    if (std::fwrite(bytes.data(), 1, bytes.size(), file_.get()) != bytes.size()) Fail();
  }
  void Rewind() {
    if (std::fseek(file_.get(), 0, SEEK_SET) != 0) Fail();
  }
  void Close() {
    if (std::fclose(file_.release()) != 0) Fail();
  }

 private:
  [[noreturn]] void Fail() const {
    ThrowIo(path_, std::string("cannot be written: ") + std::strerror(errno));
  }

  const std::string& path_;
  FileHandle file_;
};

thread_local FilesRead* files_read = nullptr;

}  // namespace

FilesRead::FilesRead() : before_(std::exchange(files_read, this)) {}
FilesRead::~FilesRead() { files_read = before_; }

void FilesRead::CheckAreNot(std::span<const std::string> outputs) const {
  for (const std::string& output : outputs) {
    std::error_code ignored;
    if (!std::filesystem::exists(output, ignored)) continue;
    for (const std::string& input : names_) CheckNotInput(output, input);
  }
}

void RefuseUtf16(std::string_view text, const std::string& path) {
  if (!text.starts_with("\xFF\xFE") && !text.starts_with("\xFE\xFF")) return;
  throw InputError(InputPosition::File(path), "is text in UTF-16: save it as UTF-8");
}

std::string ReadFile(const std::string& path, std::size_t max_bytes) {
  if (files_read != nullptr) files_read->names_.push_back(path);
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) ThrowIo(path, "is a folder, not a file");
  const FileHandle file(std::fopen(path.c_str(), "rb"));
  if (!file) ThrowIo(path, std::string("cannot be opened: ") + std::strerror(errno));
  const auto refuse = [&] {
    ThrowIo(path, "is larger than the limit of " + std::to_string(max_bytes) + " bytes");
  };
  std::string bytes;
  // The buffer is reserved at once if the size is known; growing it would hold large files twice.
  const auto size = std::filesystem::file_size(path, ignored);
  if (!ignored && size > max_bytes) refuse();
  if (!ignored) bytes.reserve(size);
  AdviseHugePages(bytes.data(), bytes.capacity());
  char chunk[1 << 16];
  while (const std::size_t got = std::fread(chunk, 1, sizeof chunk, file.get())) {
    if (bytes.size() + got > max_bytes) refuse();
    bytes.append(chunk, got);
  }
  if (std::ferror(file.get()))
    ThrowIo(path, std::string("cannot be read: ") + std::strerror(errno));
  return bytes;
}

void WriteFileAtomically(const std::string& path,
                         const std::function<void(const std::string&)>& write,
                         const std::function<void()>& before_rename) {
  if (IsSpecial(path)) {
    write(path);
    if (before_rename) before_rename();
    return;
  }
  const std::string target = Target(path);
  const std::string temporary = TemporaryName(target);
  const UnfinishedFileScope unfinished(temporary);
  try {
    const std::unique_ptr<FileLock> lock = MakeLocked(temporary);
    write(temporary);
    SyncToDisk(temporary);
    if (before_rename) before_rename();
    std::filesystem::rename(temporary, target);
  } catch (const InputError&) {
    std::remove(temporary.c_str());
    throw;
  } catch (const std::exception& error) {
    std::remove(temporary.c_str());
    ThrowIo(path, std::string("cannot be written: ") + error.what());
  }
}

void WriteFileInPieces(const std::string& path,
                       const std::function<void(const PieceWriter& out)>& write) {
  WriteFileAtomically(path, [&](const std::string& temporary) {
    OutputFile file(path, temporary);
    write([&](std::string_view piece) { file.Write(piece); });
    file.Close();
  });
}

void WriteFileStartLast(const std::string& path, std::size_t start_bytes,
                        const std::function<std::string(const PieceWriter& out)>& write,
                        const std::function<void()>& before_rename) {
  const auto at_once = [&](const std::string& special) {  // which cannot be gone back in
    std::string bytes(start_bytes, '\0');
    const std::string start = write([&](std::string_view piece) { bytes += piece; });
    OutputFile file(path, special);
    file.Write(bytes.replace(0, start_bytes, start));
    file.Close();
  };
  const auto start_last = [&](const std::string& temporary) {
    OutputFile file(path, temporary);
    file.Write(std::string(start_bytes, '\0'));
    const std::string start = write([&](std::string_view piece) { file.Write(piece); });
    assert(start.size() == start_bytes);
    file.Rewind();
    file.Write(start);
    file.Close();
  };
  if (IsSpecial(path)) return WriteFileAtomically(path, at_once, before_rename);
  WriteFileAtomically(path, start_last, before_rename);
}

void WriteFileAtomically(const std::string& path, std::string_view bytes) {
  WriteFileInPieces(path, [&](const PieceWriter& out) { out(bytes); });
}

std::string NameBeside(const std::string& path, std::string_view ending) {
  std::filesystem::path beside = path;
  const std::string stem = Shortened(beside.stem().string(), kLongestName - ending.size());
  return beside.replace_filename(stem + std::string(ending)).string();
}

void SyncFolderOf(const std::string& path) {
  const std::filesystem::path folder = std::filesystem::path(Target(path)).parent_path();
  const int file =
      ::open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (file < 0) return;
  ::fsync(file);
  ::close(file);
}

std::size_t RemoveLeftovers(std::span<const std::string> targets) {
  std::map<std::filesystem::path, std::set<std::string, std::less<>>> stems;  // by folder
  for (const std::string& target : targets) {
    const std::filesystem::path path = Target(target);
    stems[path.has_parent_path() ? path.parent_path() : "."].insert(
        TemporaryStem(path.filename().string()));
  }
  std::size_t removed = 0;
  for (const auto& [folder, of_folder] : stems) {
    // A folder that cannot be read to its end keeps what was not seen.
    std::error_code unread, ignored;
    for (std::filesystem::directory_iterator entry(folder, unread), end; !unread && entry != end;
         entry.increment(unread)) {
      const std::filesystem::path& path = entry->path();
      if (!of_folder.contains(StemOfTemporary(path.filename().string()))) continue;
      const FileLock lock(path.string(), O_RDWR | O_CLOEXEC, LOCK_NB);
      if (lock.is_named() && std::filesystem::remove(path, ignored)) ++removed;
    }
  }
  return removed;
}

void RemoveUnfinishedFiles() noexcept {
  const int error = errno;
  process_ends = true;
  for (auto& place : unfinished_files) {
    const UnfinishedFile* const file = place.exchange(nullptr);
    if (file != nullptr && file->writer == ::getpid()) ::unlink(file->name.c_str());
  }
  errno = error;
}

namespace {

// Throws unless a file could be created at `path`; returns false if what is there is written into.
bool CheckCreatable(const std::string& path) {
  const std::filesystem::path folder = std::filesystem::path(path).parent_path();
  std::error_code ignored;
  if (!folder.empty() && !std::filesystem::is_directory(folder, ignored)) {
    ThrowIo(path, "cannot be written: there is no folder " + folder.string());
  }
  if (std::filesystem::is_directory(path, ignored)) ThrowIo(path, "is a folder, not a file");
  if (IsSpecial(path)) {
    if (::access(path.c_str(), W_OK) == 0) return false;
    ThrowIo(path, std::string("cannot be written: ") + std::strerror(errno));
  }
  const std::string temporary = TemporaryName(Target(path));
  std::FILE* file = std::fopen(temporary.c_str(), "wb");
  if (!file) ThrowIo(path, std::string("cannot be written: ") + std::strerror(errno));
  std::fclose(file);
  std::remove(temporary.c_str());
  return true;
}

}  // namespace

void CheckAllWritable(std::span<const std::string> paths) {
  std::vector<std::string> created;
  for (const std::string& path : paths) {
    if (!path.empty() && CheckCreatable(path)) created.push_back(path);
  }
  RemoveLeftovers(created);
}

FileAndLayer SplitFileName(const std::string& name) {
  const std::size_t colon = name.rfind(':');
  if (colon == std::string::npos || colon == 0 || colon + 1 == name.size()) return {name, ""};
  const std::string path = name.substr(0, colon);
  std::error_code ignored;
  const bool layer =
      std::filesystem::is_regular_file(path, ignored) && !std::filesystem::exists(name, ignored);
  return layer ? FileAndLayer{path, name.substr(colon + 1)} : FileAndLayer{name, ""};
}

void CheckNotInput(const std::string& output, const std::string& input) {
  std::error_code ignored;
  if (!std::filesystem::equivalent(output, SplitFileName(input).path, ignored)) return;
  throw InputError(InputPosition::File(output), "is an input of this command; write elsewhere",
                   kExitUsage);
}

void CheckOutputs(std::span<const std::string> outputs, std::span<const std::string> inputs) {
  for (const std::string& output : outputs) {
    for (const std::string& input : inputs) CheckNotInput(output, input);
  }
  CheckAllWritable(outputs);
}

void CheckWritable(const std::string& path) { CheckAllWritable({&path, 1}); }

}  // namespace skywave
