#include "bench/measure/instructions.h"

#include <fmt/format.h>
#include <stdlib.h>
#include <sys/wait.h>

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <filesystem>
#include <map>

#include "base/counted_region.h"
#include "base/error.h"
#include "base/files.h"
#include "bench/measure/machine.h"
#include "job/options.h"
#include "wavefront/stats.h"

namespace skywave {
namespace {

// The functions that make up each stage. An instruction belongs to the innermost one around it.
constexpr std::pair<std::string_view, Stage> kStageFunctions[] = {
    {"GenerateRays", Stage::kGenerate},
    {"TraceClosest", Stage::kIntersect},
    {"TraceEscapes", Stage::kIntersect},
    {"SortHits", Stage::kPartition},
    {"MoveEscaped", Stage::kPartition},
    {"MoveSurfaces", Stage::kPartition},
    {"ClassifyEscapes", Stage::kPartition},
    {"AddEscaped", Stage::kEscape},
    {"PrepareSurfaces", Stage::kSurface},
    {"SampleLights", Stage::kLightSample},
    {"EvaluateLights", Stage::kEvaluate},
    {"TraceShadows", Stage::kShadow},
    {"AddUnoccludedRadiance", Stage::kAccumulate},
    {"Scatter", Stage::kScatter},
    {"AddPhotons", Stage::kPhotons},
    {"GatherPhotons", Stage::kPhotons},
    {"Film::Add", Stage::kFilm}};
// Parts that clocks do not tell apart are counted by names of their own: textures, light paths, and
// what joins those with paths from the camera.
constexpr std::pair<std::string_view, std::string_view> kPartFunctions[] = {
    {"TextureSurfaces", "texture"},
    {"StartLightPaths", "emit"},
    {"EmitRays", "emit"},
    {"LeaveCamera", "subpath"},
    {"LeaveLights", "subpath"},
    {"ArriveAtSurfaces", "subpath"},
    {"KeepVertices", "subpath"},
    {"ConnectSurfaces", "connect"},
    {"ConnectLights", "connect"},
    {"ConnectVertices", "connect"},
    {"EvaluateBackward", "connect"},
    {"EvaluateBothDirections", "connect"},
    {"WeighCameraConnections", "connect"},
    {"SplatConnections", "splat"},
    {"StorePhotons", "store"}};
// The functions that render a wave. What is below one of them belongs to `wave` as well.
constexpr std::string_view kWave = "wave";
constexpr std::string_view kWaveFunctions[] = {
    "RenderPathWave", "RenderSplitWave",  "RenderDirectWave", "RenderLightWave",
    "RenderBdptWave", "RenderPhotonWave", "RenderVplWave",    "RenderCachedWave"};

// Returns the stage or part that a function makes up; empty: none.
std::string StageOfFunction(std::string_view name) {
  for (const auto& [function, stage] : kStageFunctions) {
    if (name != function) continue;
    std::string word(ToString(stage));
    std::replace(word.begin(), word.end(), ' ', '_');
    return word;
  }
  for (const auto& [function, part] : kPartFunctions) {
    if (name == function) return std::string(part);
  }
  return {};
}

// The number of functions around an instruction that are kept apart. Chains between a stage and its
// kernels are shorter, also inside of Embree.
constexpr int kKeptCallers = 24;

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

// Returns the name of a function of this program without its namespace and parameters, "Film::Add"
// of "skywave::Film::Add(...)"; empty for functions of other programs.
std::string_view NameOf(std::string_view function) {
  for (const std::string_view prefix : {"skywave::", "(anonymous namespace)::"}) {
    if (function.starts_with(prefix)) {
      function.remove_prefix(prefix.size());
    } else if (prefix == "skywave::") {
      return {};
    }
  }
  return function.substr(0, function.find('('));
}

// The stages that a function and its callers belong to.
struct StagesOfChain {
  std::string stage;  // empty: none
  bool in_wave = false;
};

// `chain`: the function, its caller and so on, between apostrophes.
StagesOfChain FindStages(std::string_view chain) {
  StagesOfChain stages;
  while (!chain.empty()) {
    const std::size_t end = std::min(chain.find('\''), chain.size());
    const std::string_view name = NameOf(chain.substr(0, end));
    chain.remove_prefix(std::min(end + 1, chain.size()));
    if (name.empty()) continue;
    if (std::ranges::find(kWaveFunctions, name) != std::end(kWaveFunctions)) stages.in_wave = true;
    if (stages.stage.empty()) stages.stage = StageOfFunction(name);
  }
  return stages;
}

// The names of a profile, which writes out each of them once, after its number: "(7) name".
class ProfileNames {
 public:
  // Returns the name of "(7) name" or "(7)".
  const std::string& Take(std::string_view text) {
    const std::size_t end = std::min(text.find(')'), text.size());
    std::string& name = names_[std::string(text.substr(0, end))];
    if (end + 2 < text.size()) name = text.substr(end + 2);
    return name;
  }

 private:
  std::map<std::string, std::string> names_;
};

// The C library and the like differ between point releases of a system; the program and Embree do
// not.
bool IsCounted(std::string_view object, std::string_view program) {
  return object == program || object.substr(object.rfind('/') + 1).starts_with("libembree");
}

// Returns the number after the first blank of a line; 0: there is none.
std::uint64_t SecondNumber(std::string_view line) {
  std::uint64_t number = 0;
  const std::size_t blank = line.find(' ');
  if (blank != std::string_view::npos) {
    std::from_chars(line.data() + blank + 1, line.data() + line.size(), number);
  }
  return number;
}

std::string Toolchain(const std::string& valgrind) {
  const Machine machine = DescribeMachine("isa=avx2");
  std::string text = machine.compiler + ", " + machine.build;
  for (const auto& [name, version] : machine.libraries) {
    if (name == "embree" || name == "highway") text += ", " + name + " " + version;
  }
  return text + ", " + valgrind;
}

}  // namespace

StageInstructions StagesOf(std::string_view profile, std::string_view program) {
  ProfileNames objects, functions;
  std::map<std::string, StagesOfChain> found;  // by the chain of functions
  std::map<std::string, std::uint64_t, std::less<>> stages;
  bool counted = false, of_call = false;
  const StagesOfChain* current = nullptr;
  while (!profile.empty()) {
    const std::size_t end = std::min(profile.find('\n'), profile.size());
    const std::string_view line = profile.substr(0, end);
    profile.remove_prefix(std::min(end + 1, profile.size()));
    const std::size_t equals = std::min(line.find('='), line.size());
    const std::string_view key = line.substr(0, equals);
    if (key == "ob") {
      counted = IsCounted(objects.Take(line.substr(equals + 1)), program);
    } else if (key == "cob") {
      objects.Take(line.substr(equals + 1));
    } else if (key == "cfn") {
      functions.Take(line.substr(equals + 1));
    } else if (key == "fn") {
      const std::string& chain = functions.Take(line.substr(equals + 1));
      const auto [place, is_new] = found.try_emplace(chain);
      if (is_new) place->second = FindStages(chain);
      current = &place->second;
    } else if (key == "calls") {
      of_call = true;  // the next line has what the callee cost, which has lines of its own
    } else if (equals == line.size() && !line.empty() &&
               std::string_view("0123456789+-*").find(line[0]) != std::string_view::npos) {
      const std::uint64_t cost = SecondNumber(line);
      if (counted && !of_call && current != nullptr) {
        if (!current->stage.empty()) stages[current->stage] += cost;
        if (current->in_wave) stages[std::string(kWave)] += cost;
      }
      of_call = false;
    }
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
  const std::string program = std::filesystem::read_symlink("/proc/self/exe").string();
  const std::string render = fmt::format(
      "{} render{} --size {}x{} --spp {} --threads 1 --embree-config isa=avx2 --quiet --output {}",
      Quoted(program), PictureOptions(resolved, kWithout), kInstructionWidth, height,
      kInstructionSamples, Quoted(folder.File("picture.exr")));
  const std::string profile = folder.File("out");
  const CommandOutput ran = RunShell(
      fmt::format("valgrind --quiet --tool=callgrind --dump-line=no --instr-atstart={} "
                  "--separate-callers={} --callgrind-out-file={} {} 2>&1",
                  kMarksCountedRegions ? "no" : "yes", kKeptCallers, Quoted(profile), render));
  if (!ran.good) {
    throw InputError(InputPosition::File("valgrind"),
                     fmt::format("cannot count {}:\n{}", render, ran.text), kExitIo);
  }
  counts.stages = StagesOf(ReadFile(profile), program);
  if (counts.stages.empty()) {
    counts.skipped = "the program has no names of functions (it was stripped)";
  }
  return counts;
}

}  // namespace skywave
