#include "scene/named_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

namespace skywave {
namespace {

namespace fs = std::filesystem;

std::optional<std::string> IfFile(const fs::path& path) {
  std::error_code ignored;
  return fs::is_regular_file(path, ignored) ? std::optional(path.string()) : std::nullopt;
}

fs::path FolderOf(const InputPosition& at) { return fs::path(at.path).parent_path(); }

}  // namespace

std::optional<std::string> FindNamedFile(const InputPosition& at, std::string name) {
  if (auto file = IfFile(FolderOf(at) / name)) return file;
  std::replace(name.begin(), name.end(), '\\', '/');
  return IfFile(FolderOf(at) / name);
}

std::optional<std::string> FindMovedFile(const InputPosition& at, std::string name,
                                         Warnings& warnings) {
  std::replace(name.begin(), name.end(), '\\', '/');
  auto file = IfFile(FolderOf(at) / fs::path(name).filename());
  if (file) {
    AddNote(warnings, at, fmt::format("there is no file \"{}\": {} is taken", name, *file));
  }
  return file;
}

std::optional<std::string> FindNamedOrMovedFile(const InputPosition& at, const std::string& name,
                                                Warnings& warnings) {
  if (auto file = FindNamedFile(at, name)) return file;
  return FindMovedFile(at, name, warnings);
}

}  // namespace skywave
