// The pictures of a batch: what a job file says, read, checked and multiplied out.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "job/batch/picture_options.h"

namespace skywave {

struct AxisValue {
  std::string axis, label;
};

struct BatchPicture {
  std::size_t index = 0;               // in the order of the job file, from 0
  std::string output;                  // the EXR; the PNG has the same name
  std::vector<PictureOption> options;  // [base], then the axes (RequestOf)
  std::vector<AxisValue> axes;         // in the order of the file
  std::vector<std::size_t> place;      // the number of its value in each dimension of the plan
};

// An axis, or several that go in step; the names of those are joined by ", ".
struct BatchDimension {
  std::string name;
  std::vector<std::string> labels;
};

struct BatchPlan {
  std::string path;                        // the job file
  std::string bytes;                       // what it held when it was read
  std::string folder;                      // the common folder of all outputs
  std::uint64_t memory_bytes = 0;          // limit of what is kept loaded; 0: by the machine
  std::vector<BatchDimension> dimensions;  // the first one varies slowest
  std::vector<BatchPicture> pictures;      // all, or a share
  std::size_t all_pictures = 0;            // of all shares
};

// A share of the pictures: of every `count` consecutive ones the one at `number`, counted from 1.
struct BatchShare {
  std::size_t number = 1, count = 1;
};

// Returns the plan of the job file at `path`. Outputs are relative to `output_folder`, or to the
// folder of the job file if that is empty. Reads only the job file, and the scene if all its
// cameras are requested; creates nothing. Throws InputError with the line.
BatchPlan ReadBatchPlan(const std::string& path, const std::string& output_folder = "");
// The same of a job file whose bytes are known.
BatchPlan ParseBatchPlan(const std::string& path, std::string bytes,
                         const std::string& output_folder = "");

// Returns the plan with the pictures of a share alone.
BatchPlan ShareOf(BatchPlan plan, const BatchShare& share);

// Returns the name of a file as files in `folder` refer to it.
std::string RelativeName(const std::string& folder, const std::string& file);

// Returns the name of a report on the batch beside the outputs: its folder and the name of the job
// file, with ".batch" and `ending`. The shares of a batch have files of their own.
std::string ReportName(const BatchPlan& plan, const BatchShare& share, const std::string& ending);

// Throws InputError if the job file is no longer what was read.
void CheckUnchanged(const BatchPlan& plan);

// Returns the bytes for which "4GiB", "512 MB" or "100000" stands, or 0 for other text.
std::uint64_t ParseBytes(const std::string& text);

}  // namespace skywave
