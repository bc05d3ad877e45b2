#include "cli/print.h"

#include <stdio_ext.h>

#include <cerrno>

namespace skywave {

void PutText(std::FILE* file, std::string_view text) {
  std::fwrite(text.data(), 1, text.size(), file);
}

void Put(std::FILE* file, const std::string& text) {
  PutText(file, text);
  if (std::fflush(file) == 0 || errno != EPIPE) return;
  __fpurge(file);
  std::clearerr(file);
}

void PrintNotes(const std::vector<std::string>& notes) {
  for (const std::string& note : notes) Put(stderr, "note: " + note + "\n");
}

}  // namespace skywave
