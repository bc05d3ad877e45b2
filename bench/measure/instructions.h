// Counts the instructions of the stages of a render under callgrind, those of the program and of
// Embree: what other libraries do, the C library first of all, changes with their point releases.
// Counts repeat to the last one, where times scatter by percents, but belong to a compiler,
// versions of Embree and Highway and one of valgrind.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "job/request.h"

namespace skywave {

using StageInstructions = std::vector<std::pair<std::string, std::uint64_t>>;

struct InstructionCounts {
  std::string skipped;            // why nothing was counted; empty: it was
  std::string toolchain;          // what counts belong to
  StageInstructions stages = {};  // by name
};

// A picture for counts is small, because valgrind is fifty times as slow as the processor.
inline constexpr int kInstructionWidth = 64;
inline constexpr int kInstructionSamples = 8;

// Renders the picture of a resolved request in a process of its own under valgrind, with a width of
// kInstructionWidth and kInstructionSamples samples per pixel. One thread renders, because waiting
// ones count too. Valgrind's processor has AVX2 and no AVX-512, so kernels run as AVX2, and Embree
// gets isa=avx2. Nothing is counted without valgrind or AVX2, or if the program was stripped of the
// names of functions. Throws InputError if the render fails there.
InstructionCounts CountInstructions(const JobRequest& resolved);

// Returns the counts of the stages in a file of callgrind that separates functions by their callers
// (--separate-callers), in the order of their names. `program`: the object that is counted besides
// Embree's.
StageInstructions StagesOf(std::string_view profile, std::string_view program);

}  // namespace skywave
