#include "measure/instructions.h"

#include <fmt/format.h>
#include <gnu/libc-version.h>
#include <stdlib.h>
#include <sys/wait.h>

#include <algorithm>
#include <cctype>
#include <cstdio>
#include <filesystem>
#include <map>

#include "base/error.h"
#include "base/files.h"
#include "job/options.h"
#include "measure/machine.h"

namespace skywave {
namespace {

// The functions that make up each stage.
constexpr std::pair<std::string_view, std::string_view> kStageFunctions[] = {
    {"GenerateRays", "generate"},
    {"TraceClosest", "intersect"},
    {"TraceEscapes", "intersect"},
    {"SortHits", "partition"},
    {"MoveEscaped", "partition"},
    {"MoveSurfaces", "partition"},
    {"ClassifyEscapes", "partition"},
    {"AddEscaped", "escape"},
    {"PrepareSurfaces", "surface"},
    {"SampleLights", "light_sample"},
    {"EvaluateLights", "evaluate"},
    {"TraceShadows", "shadow"},
    {"AddUnoccludedRadiance", "accumulate"},
    {"Scatter", "scatter"},
    {"Film::Add", "film"},
    {"RenderPathWave", "wave"}};

class InstructionFolder {
 public:
  InstructionFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "skywave-count-XXXXXX").string();
    if (::mkdtemp(name.data()) == nullptr) {
      throw InputError(InputPosition::File(name), "cannot be made", kExitIo);
    }
    path_ = name;
  }
  InstructionFolder(const InstructionFolder&) = delete;
  InstructionFolder& operator=(const InstructionFolder&) = delete;
  ~InstructionFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  std::string File(std::string_view name) const { return (path_ / name).string(); }

 private:
  std::filesystem::path path_;
};

struct CommandOutput {
  bool good;
  std::string text;
};

CommandOutput RunShell(const std::string& command) {
  CommandOutput output = {.good = false, .text = {}};
  std::FILE* const pipe = ::popen(command.c_str(), "r");
  if (pipe == nullptr) return output;
  char bytes[4096];
  for (std::size_t count; (count = std::fread(bytes, 1, sizeof bytes, pipe)) > 0;) {
    output.text.append(bytes, count);
  }
  const int status = ::pclose(pipe);
  output.good = WIFEXITED(status) && WEXITSTATUS(status) == 0;
  return output;
}

// Returns the name of the function of this program in a line of callgrind_annotate, "Film::Add" of
// "1,234 (5.6%)  film/film.cc:skywave::Film::Add(...) [...]"; empty: there is none.
std::string_view FunctionOf(std::string_view line) {
  constexpr std::string_view kPrefix = ":skywave::";
  for (std::size_t at = line.rfind(kPrefix); at != std::string_view::npos && at > 0;
       at = line.rfind(kPrefix, at - 1)) {
    const std::string_view name = line.substr(at + kPrefix.size());
    const auto end = std::find_if(name.begin(), name.end(),
                                  [](unsigned char c) { return std::isalpha(c) == 0 && c != ':'; });
    if (end != name.begin() && end != name.end() && *end == '(') {
      return name.substr(0, std::size_t(end - name.begin()));
    }
  }
  return {};
}

// Returns the number that a line begins with; commas may stand between its digits.
std::uint64_t CountOf(std::string_view line) {
  std::uint64_t count = 0;
  for (const char c : line.substr(std::min(line.find_first_not_of(' '), line.size()))) {
    if (c == ',') continue;
    if (std::isdigit(static_cast<unsigned char>(c)) == 0) break;
    count = 10 * count + std::uint64_t(c - '0');
  }
  return count;
}

std::string Toolchain(const std::string& valgrind) {
  const Machine machine = DescribeMachine("isa=avx2");
  std::string text = machine.compiler + ", " + machine.build;
  for (const auto& [name, version] : machine.libraries) text += ", " + name + " " + version;
  return fmt::format("{}, glibc {}, {}", text, ::gnu_get_libc_version(), valgrind);
}

}  // namespace

StageInstructions StagesOf(std::string_view annotated) {
  // A function has one line for each file whose code was inlined into it; the largest is that of
  // its own file and includes all of it.
  std::map<std::string_view, std::uint64_t> functions;
  while (!annotated.empty()) {
    const std::size_t end = std::min(annotated.find('\n'), annotated.size());
    const std::string_view line = annotated.substr(0, end);
    annotated.remove_prefix(std::min(end + 1, annotated.size()));
    for (const auto& [function, stage] : kStageFunctions) {
      if (FunctionOf(line) != function) continue;
      functions[function] = std::max(functions[function], CountOf(line));
    }
  }
  std::map<std::string, std::uint64_t> stages;
  for (const auto& [function, stage] : kStageFunctions) {
    if (functions.contains(function)) stages[std::string(stage)] += functions[function];
  }
  return {stages.begin(), stages.end()};
}

InstructionCounts CountInstructions(const JobRequest& resolved) {
  InstructionCounts counts;
  CommandOutput valgrind = RunShell("valgrind --version 2>/dev/null");
  while (!valgrind.text.empty() && valgrind.text.back() == '\n') valgrind.text.pop_back();
  if (!valgrind.good) {
    counts.skipped = "there is no valgrind (apt-get install valgrind)";
    return counts;
  }
  if (!__builtin_cpu_supports("avx2")) {
    counts.skipped = "the processor has no AVX2";
    return counts;
  }
  counts.toolchain = Toolchain(valgrind.text);

  const InstructionFolder folder;
  constexpr std::string_view kWithout[] = {"size", "spp", "crop", "sample-range", "embree-config"};
  const int height =
      std::max(1, kInstructionWidth * resolved.height.value_or(3) / resolved.width.value_or(4));
  const std::string render = fmt::format(
      "{} render{} --size {}x{} --spp {} --threads 1 --embree-config isa=avx2 --quiet --output {}",
      Quoted(std::filesystem::read_symlink("/proc/self/exe").string()),
      PictureOptions(resolved, kWithout), kInstructionWidth, height, kInstructionSamples,
      Quoted(folder.File("picture.exr")));
  const std::string profile = folder.File("out");
  const CommandOutput ran =
      RunShell(fmt::format("valgrind --quiet --tool=callgrind --callgrind-out-file={} {} 2>&1",
                           Quoted(profile), render));
  if (!ran.good) {
    throw InputError(InputPosition::File("valgrind"),
                     fmt::format("cannot count {}:\n{}", render, ran.text), kExitIo);
  }
  const CommandOutput annotated = RunShell(fmt::format(
      "callgrind_annotate --auto=no --inclusive=yes --threshold=100 {} 2>&1", Quoted(profile)));
  counts.stages = StagesOf(annotated.text);
  if (counts.stages.empty()) {
    counts.skipped = "the program has no names of functions (it was stripped)";
  }
  return counts;
}

}  // namespace skywave
