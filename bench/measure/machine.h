// Describes the machine of a measurement in words for a report.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace skywave {

struct Machine {
  std::string processor;  // as named by the operating system
  std::string microcode;  // its version; empty: unknown, as the next two
  std::string governor;   // of its clock, as in "performance"; several are separated by commas
  std::string virtual_machine;  // "none", "yes", or its name where that is known
  int processors = 0;           // number available to this process
  double memory_bytes = 0;
  std::string system;           // operating system and its version
  std::string compiler, build;  // compiler and build of this program
  std::string revision;         // git revision of its sources, "-dirty" if changed; else "unknown"
  std::string instructions;     // instruction set that the kernels use
  int lanes = 0;                // floats per vector of the kernels
  std::string embree_config;
  std::vector<std::pair<std::string, std::string>> libraries;  // name, version
};

// `embree_config` is the user's setting; empty stands for the default.
Machine DescribeMachine(const std::string& embree_config);

}  // namespace skywave
