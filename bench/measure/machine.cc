#include "bench/measure/machine.h"

#include <OpenEXRConfig.h>
#include <fmt/format.h>
#include <sys/utsname.h>
#include <tbb/version.h>
#include <xxhash.h>

#include <fstream>

#include "base/granted.h"
#include "bench/measure/revision.h"
#include "kernels/targets.h"
#include "scene/embree.h"
#include "scene/geometry.h"

namespace skywave {
namespace {

std::string ProcessorName() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);) {
    if (!line.starts_with("model name")) continue;
    const std::size_t colon = line.find(": ");
    if (colon != std::string::npos) return line.substr(colon + 2);
  }
  return "unknown";
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
  return {.processor = ProcessorName(),
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
