// Files that other files name.
#pragma once

#include <optional>
#include <string>

#include "base/error.h"
#include "scene/warnings.h"

namespace skywave {

// Returns the path of the file that the file of `at` names, in the folder of that file; Windows
// programs write backslashes for slashes.
std::optional<std::string> FindNamedFile(const InputPosition& at, std::string name);

// Returns, with a note, the file of that name, but of no other folder, beside the file of `at`:
// models are copied into one folder, and still name the folders of their makers.
std::optional<std::string> FindMovedFile(const InputPosition& at, std::string name,
                                         Warnings& warnings);

// Returns the first of both that is there.
std::optional<std::string> FindNamedOrMovedFile(const InputPosition& at, const std::string& name,
                                                Warnings& warnings);

}  // namespace skywave
