// On what a measurement ran, in words for a report.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace skywave {

struct Machine {
  std::string processor;  // as the operating system names it
  int processors = 0;     // that this process may use
  double memory_bytes = 0;
  std::string system;           // operating system and its version
  std::string compiler, build;  // of this program
  std::string revision;         // of its sources: of git, "-dirty" if changed; else "unknown"
  std::string instructions;     // that the kernels use
  int lanes = 0;                // of their vectors of floats
  std::string embree_config;
  std::vector<std::pair<std::string, std::string>> libraries;  // name, version
};

// `embree_config`: as the user gave it; empty stands for the default.
Machine DescribeMachine(const std::string& embree_config);

}  // namespace skywave
