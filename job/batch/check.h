// Checks of a batch before its first picture is rendered.
#pragma once

#include <cstddef>
#include <cstdint>
#include <set>
#include <string>

#include "job/batch/plan.h"

namespace skywave {

// Returns the files that the pictures are made of: scenes, but not built-in ones, and maps.
std::set<std::string> InputFiles(const BatchPlan& plan);

// Throws InputError unless every picture can be written: no output is a folder or an input, and the
// folders are writable or can be made. Makes nothing.
void CheckOutputs(const BatchPlan& plan);

// Makes the folders of the outputs, tries to write into each, and removes what killed runs of this
// share have left there (RemoveLeftovers). Throws InputError (kExitIo).
void PrepareOutputs(const BatchPlan& plan, const BatchShare& share = {});

struct DryRun {
  std::size_t scenes = 0, maps = 0;  // that were read
  std::uint64_t samples = 0;         // of all pictures, all pixels, if no limit ends them
};

// Reads every scene and every map once, one after the other, and resolves the options of every
// picture. Throws InputError for files that cannot be used and options that do not go together.
DryRun CheckWithoutRendering(const BatchPlan& plan);

}  // namespace skywave
