// Collects a reader's remarks on a file, one line per kind: a thousand equal remarks become one.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "base/error.h"
#include "scene/read_options.h"

namespace skywave {

struct Scene;

struct Warnings {
  struct Entry {
    InputPosition first;
    std::string text;
    std::size_t count = 0;
    // Of what it is said, such as "material", and the first few names of these.
    std::string thing;
    std::vector<std::string> names;
    std::size_t named = 0;  // how many there are
    bool missing = false;   // the names are of files that are not there, for `thing`
    std::string last;       // the last name, which is not counted twice in a row
    bool is_warning = false;
  };
  std::vector<Entry> entries;  // in the order of their first appearance
  std::unordered_map<std::string, std::size_t> by_text;
  bool strict = false;           // throw instead of adding a warning
  bool refuses_missing = false;  // likewise, of files that are missing
};
Warnings MakeWarnings(const ReadOptions& options);

// Warns that the picture differs from the file's description: `text` names the cause and the
// substitute. Throws it as an InputError if warnings are refused.
void AddWarning(Warnings& warnings, const InputPosition& position, const std::string& text);

// The same of a named thing, as in "material 'steel': ...". What is said of many of them is one
// line with the first three names and the number of the others.
void AddWarningOf(Warnings& warnings, const InputPosition& position, const std::string& thing,
                  const std::string& name, const std::string& text);

// Warns that the file of `thing` is missing or cannot be read, as `error` says, and what is done
// without it. Files that are not there are one line for each thing, as with AddWarningOf.
// RefuseMissing throws such a warning where these scenes are refused, and does nothing else.
void AddMissing(Warnings& warnings, const InputPosition& position, std::string_view thing,
                const InputError& error, std::string_view consequence);
void RefuseMissing(const Warnings& warnings, const InputPosition& position,
                   const std::string& text);

// Notes that something in the file has no effect, although the picture matches the file's
// description. Never refused.
void AddNote(Warnings& warnings, const InputPosition& position, const std::string& raw);

// Return "file:line: text" of the warnings and of the notes, with " (N times)" appended if it
// occurred more than once.
std::vector<std::string> WarningLines(const Warnings& warnings);
std::vector<std::string> NoteLines(const Warnings& warnings);
// Gives both to a scene that has been read.
void SetRemarks(const Warnings& warnings, Scene& scene);

}  // namespace skywave
