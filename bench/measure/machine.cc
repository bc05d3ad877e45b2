#include "bench/measure/machine.h"

#include <OpenEXRConfig.h>
#include <fmt/format.h>
#include <sys/utsname.h>
#include <tbb/version.h>
#include <xxhash.h>

#include <filesystem>
#include <fstream>

#include "base/granted.h"
#include "bench/measure/conditions.h"
#include "bench/measure/revision.h"
#include "kernels/targets.h"
#include "scene/embree.h"
#include "scene/geometry.h"

namespace skywave {
namespace {

// Returns what /proc/cpuinfo says of the first processor under `key`; empty if it does not.
std::string OfProcessor(std::string_view key) {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);) {
    if (!line.starts_with(key)) continue;
    const std::size_t colon = line.find(": ");
    if (colon != std::string::npos) return line.substr(colon + 2);
  }
  return "";
}

// Returns the first line of a file; empty if there is none.
std::string FirstLine(const std::filesystem::path& path) {
  std::ifstream file(path);
  std::string line;
  std::getline(file, line);
  return line;
}

std::string VirtualMachine() {
  const std::string flags = " " + OfProcessor("flags") + " ";
  if (flags == "  ") return "";
  if (flags.find(" hypervisor ") == std::string::npos) return "none";
  const std::string name = FirstLine("/sys/class/dmi/id/product_name");
  return name.empty() ? "yes" : name;
}

std::string SystemName() {
  utsname name = {};
  return uname(&name) == 0 ? fmt::format("{} {} {}", name.sysname, name.release, name.machine)
                           : "unknown";
}

std::string BuildKind() {
#ifdef NDEBUG
  std::string kind = "optimised";
#else
  std::string kind = "with assertions";
#endif
#ifdef SKYWAVE_CHECKS
  kind += ", with checks";
#endif
  return kind;
}

}  // namespace

Machine DescribeMachine(const std::string& embree_config) {
  const std::string processor = OfProcessor("model name");
  return {.processor = processor.empty() ? "unknown" : processor,
          .microcode = OfProcessor("microcode"),
          .governor = ReadGovernors(),
          .virtual_machine = VirtualMachine(),
          .processors = GrantedHere().threads,
          .memory_bytes = double(GrantedHere().memory_bytes),
          .system = SystemName(),
#ifdef __clang__
          .compiler = "clang " __VERSION__,
#else
          .compiler = "g++ " __VERSION__,
#endif
          .build = BuildKind(),
          .revision = GitRevision(),
          .instructions = KernelTarget(),
          .lanes = int(KernelLanes()),
          .embree_config = embree_config.empty() ? DefaultEmbreeConfig() : embree_config,
          .libraries = {{"embree", RTC_VERSION_STRING},
                        {"highway", HighwayVersion()},
                        {"tbb", fmt::format("{}.{}", TBB_VERSION_MAJOR, TBB_VERSION_MINOR)},
                        {"openexr", OPENEXR_VERSION_STRING},
                        {"xxhash", fmt::format("{}.{}.{}", XXH_VERSION_MAJOR, XXH_VERSION_MINOR,
                                               XXH_VERSION_RELEASE)}}};
}

}  // namespace skywave
