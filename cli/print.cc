#include "cli/print.h"

#include <stdio_ext.h>

#include <cerrno>

#include "job/job.h"

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

void PrintWarnings(const std::vector<std::string>& warnings) {
  for (const std::string& warning : warnings) Put(stderr, "warning: " + warning + "\n");
}

void PrintRemarks(const RenderJob& job) {
  PrintWarnings(job.warnings());
  PrintNotes(job.notes());
}

void PrintNotes(const std::vector<std::string>& notes) {
  for (const std::string& note : notes) Put(stderr, "note: " + note + "\n");
}

}  // namespace skywave
