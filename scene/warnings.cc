#include "scene/warnings.h"

#include <fmt/format.h>

#include <algorithm>

#include "scene/scene.h"

namespace skywave {

namespace {

// Returns the text of an entry with its names: "materials 'a', 'b', 'c' and 4 more: ...".
std::string TextOf(const Warnings::Entry& entry) {
  if (entry.names.empty()) return entry.text;
  const char quote = entry.missing ? '"' : '\'';
  std::string names;
  for (const std::string& name : entry.names) {
    names += (names.empty() ? "" : ", ") + (quote + name + quote);
  }
  if (entry.named > entry.names.size()) {
    names += fmt::format(" and {} more", entry.named - entry.names.size());
  }
  const bool one = entry.named == 1;
  if (entry.missing) {
    return fmt::format("{}: there {} {}: {}", entry.thing, one ? "is no file" : "are no files",
                       names, entry.text);
  }
  return fmt::format("{}{} {}: {}", entry.thing, one ? "" : "s", names, entry.text);
}

void AddRemark(Warnings& warnings, const InputPosition& position, const std::string& raw,
               bool is_warning) {
  const std::string text = WithoutControlCodes(raw);
  const auto [found, is_new] = warnings.by_text.try_emplace(text, warnings.entries.size());
  if (is_new) {
    warnings.entries.push_back({.first = position, .text = text, .is_warning = is_warning});
  }
  ++warnings.entries[found->second].count;
}

std::vector<std::string> Lines(const Warnings& warnings, bool of_warnings) {
  std::vector<std::string> lines;
  for (const Warnings::Entry& entry : warnings.entries) {
    if (entry.is_warning != of_warnings) continue;
    lines.push_back(fmt::format("{}: {}", ToString(entry.first), TextOf(entry)));
    if (entry.count > std::max<std::size_t>(entry.named, 1))
      lines.back() += fmt::format(" ({} times)", entry.count);
  }
  return lines;
}

// Adds a name to the entry of its thing and text. `missing` as in Warnings::Entry.
void AddNamed(Warnings& warnings, const InputPosition& position, const std::string& thing,
              const std::string& name, const std::string& text, bool missing) {
  constexpr std::size_t kMostNames = 3;
  const std::string clean = WithoutControlCodes(text), of = WithoutControlCodes(name);
  const auto [found, is_new] = warnings.by_text.try_emplace(
      fmt::format("{}: {}{}", thing, missing ? "no file: " : "", clean), warnings.entries.size());
  if (is_new) {
    warnings.entries.push_back({.first = position,
                                .text = clean,
                                .thing = thing,
                                .names = {},
                                .missing = missing,
                                .is_warning = true});
  }
  Warnings::Entry& entry = warnings.entries[found->second];
  if (missing) ++entry.count;
  if (!entry.names.empty() && entry.last == of) return;
  entry.last = of;
  ++entry.named;
  if (entry.names.size() < kMostNames) entry.names.push_back(of);
}

}  // namespace

void AddWarningOf(Warnings& warnings, const InputPosition& position, const std::string& thing,
                  const std::string& name, const std::string& text) {
  if (warnings.strict)
    AddWarning(warnings, position, fmt::format("{} '{}': {}", thing, name, text));
  AddNamed(warnings, position, thing, name, text, false);
}

void AddWarning(Warnings& warnings, const InputPosition& position, const std::string& text) {
  if (warnings.strict) {
    throw InputError(position, text + " (refused by --strict)");
  }
  AddRemark(warnings, position, text, true);
}

void AddMissing(Warnings& warnings, const InputPosition& position, std::string_view thing,
                const InputError& error, std::string_view consequence) {
  // The warning has its own position in front.
  const bool here = error.place() == ToString(position);
  const std::string text =
      fmt::format("{}: {}: {}", thing, here ? error.reason() : error.what(), consequence);
  RefuseMissing(warnings, position, text);
  if (warnings.strict || error.missing_file().empty()) {
    AddWarning(warnings, position, text);
  } else {
    AddNamed(warnings, position, std::string(thing), error.missing_file(), std::string(consequence),
             true);
  }
}

void RefuseMissing(const Warnings& warnings, const InputPosition& position,
                   const std::string& text) {
  if (!warnings.refuses_missing) return;
  throw InputError(position, text + " (refused by --missing refuse)");
}

Warnings MakeWarnings(const ReadOptions& options) {
  Warnings warnings;
  warnings.strict = options.strict;
  warnings.refuses_missing = options.missing == MissingFiles::kRefuse;
  return warnings;
}

void AddNote(Warnings& warnings, const InputPosition& position, const std::string& raw) {
  AddRemark(warnings, position, raw, false);
}

std::vector<std::string> WarningLines(const Warnings& warnings) { return Lines(warnings, true); }
std::vector<std::string> NoteLines(const Warnings& warnings) { return Lines(warnings, false); }

void SetRemarks(const Warnings& warnings, Scene& scene) {
  scene.warnings = WarningLines(warnings);
  scene.notes = NoteLines(warnings);
}

}  // namespace skywave
