// A batch as jobs of Slurm: the texts of the scripts that submit and run them.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "job/batch/plan.h"

namespace skywave {

struct SlurmPicture {
  std::string output;         // the EXR
  std::string options;        // words of `skywave render` that make it, without outputs
  std::uint32_t samples = 0;  // per pixel
  std::string format = {};    // words of `skywave render` and `merge` that say how it is written
};

struct SlurmPlan {
  std::string name;       // of the jobs, which distinguishes them from those of other batches
  std::string program;    // names of files are absolute, or relative to `directory`
  std::string directory;  // in which the commands are run
  std::string folder;     // of the scripts, their logs and the parts of pictures
  std::string batch;      // words of `skywave batch` that name the job file and its outputs
  std::vector<SlurmPicture> pictures;
  std::uint32_t shards = 1;  // parts into which the samples of each picture are cut
};

struct SlurmScript {
  std::string name, text;
};

// Returns three scripts. submit.sh submits the others, unless they are queued already: render.sh,
// an array of pictures or, with more than one shard, of parts, and finish.sh, which runs when all
// of them have succeeded, merges parts, and checks by `skywave batch` that every picture is there.
// A task that gets SIGTERM saves a checkpoint and is queued again; whatever is finished is skipped.
std::vector<SlurmScript> SlurmScripts(const SlurmPlan& plan);

// Returns the plan of a batch whose scripts are in `folder` and whose outputs are relative to
// `output_folder`, if that is not empty. With more than one shard the scenes are read for the
// number of samples where the job file does not give it. Throws InputError with the line of the job
// file where the samples of a picture cannot be cut.
SlurmPlan PlanForSlurm(const BatchPlan& batch, const std::string& output_folder,
                       const std::string& folder, std::uint32_t shards);

}  // namespace skywave
