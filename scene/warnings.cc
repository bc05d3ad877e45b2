#include "scene/warnings.h"

#include <fmt/format.h>

namespace skywave {

void AddWarning(Warnings& warnings, const InputPosition& position, const std::string& text) {
  if (warnings.strict) throw InputError(position, text + " (refused by --strict)");
  AddNote(warnings, position, text);
}

void AddNote(Warnings& warnings, const InputPosition& position, const std::string& text) {
  const auto [found, is_new] = warnings.by_text.try_emplace(text, warnings.entries.size());
  if (is_new) warnings.entries.push_back({position, text, 0});
  ++warnings.entries[found->second].count;
}

std::vector<std::string> WarningLines(const Warnings& warnings) {
  std::vector<std::string> lines;
  for (const Warnings::Entry& entry : warnings.entries) {
    lines.push_back(fmt::format("{}: {}", ToString(entry.first), entry.text));
    if (entry.count > 1) lines.back() += fmt::format(" ({} times)", entry.count);
  }
  return lines;
}

}  // namespace skywave
