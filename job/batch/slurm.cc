#include "job/batch/slurm.h"

#include <fmt/format.h>
#include <xxhash.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <string_view>

#include "base/error.h"
#include "job/batch/picture_options.h"
#include "job/options.h"
#include "job/picture.h"
#include "job/resolve.h"
#include "scene/reader.h"

namespace skywave {
namespace {

// Slurm refuses arrays of more tasks, unless its MaxArraySize is raised.
constexpr std::size_t kMostTasks = 1000;
// Seconds between a warning and the end of a task, and between two checkpoints.
constexpr int kWarning = 60, kCheckpoint = 300;

struct Part {
  const SlurmPicture* picture;
  std::uint32_t first, end;  // samples
  std::string film;
};

// Returns the parts of a picture. Their names change with whatever decides what
// is in them.
std::vector<Part> PartsOf(const SlurmPlan& plan, const SlurmPicture& picture) {
  const std::uint64_t shards = std::min(plan.shards, picture.samples);
  std::vector<Part> parts;
  for (std::uint64_t i = 0; i < shards; ++i) {
    const auto first = std::uint32_t(picture.samples * i / shards);
    const auto end = std::uint32_t(picture.samples * (i + 1) / shards);
    const std::string what = picture.output + '\n' + picture.options;
    parts.push_back({&picture, first, end,
                     fmt::format("{}/parts/{:016x}_{}-{}.film", plan.folder,
                                 XXH64(what.data(), what.size(), 0), first, end)});
  }
  return parts;
}

std::string Header(const SlurmPlan& plan) {
  return fmt::format(
      "#!/bin/bash\n"
      "#SBATCH --job-name={}\n"
      "#SBATCH --open-mode=append\n"
      "#SBATCH --requeue\n"
      "#SBATCH --signal=B:TERM@{}\n",
      plan.name, kWarning);
}

// `run` runs a command and passes SIGTERM on to it. If the command fails because of that, or has
// saved a checkpoint, the task is queued again, and Slurm ends the script.
std::string Functions(const SlurmPlan& plan, const std::string& job) {
  return fmt::format(R"sh(
set -u
cd {0} || exit {1}
program={2}
asked= child= told=
again() {{
  scontrol requeue "{4}" && sleep {5}
  exit {3}
}}
tell() {{  # a command ends at once if it is told twice
  [[ -n $asked && -n $child && -z $told ]] || return 0
  told=1
  kill -TERM "$child" 2>/dev/null
}}
trap 'asked=1; tell' TERM
run() {{
  [[ -z $asked ]] || again
  "$@" &
  child=$!
  tell
  local code
  while true; do
    wait "$child"
    code=$?
    kill -0 "$child" 2>/dev/null || break
  done
  wait "$child"
  code=$?
  child=
  [[ $code -eq 0 ]] && return
  [[ $code -eq {3} || -n $asked ]] && again
  exit "$code"
}}
)sh",
                     Quoted(plan.directory), kExitIo, Quoted(plan.program), kExitTryAgain, job,
                     kWarning);
}

constexpr std::string_view kArrayTask = "${SLURM_ARRAY_JOB_ID}_${SLURM_ARRAY_TASK_ID}";

std::string RenderPictures(const SlurmPlan& plan) {
  const std::size_t tasks = std::min(plan.pictures.size(), kMostTasks);
  return Header(plan) + fmt::format("#SBATCH --array=1-{}\n", tasks) +
         Functions(plan, std::string(kArrayTask)) +
         fmt::format("run \"$program\" batch {} --only \"$SLURM_ARRAY_TASK_ID/{}\"\n", plan.batch,
                     tasks);
}

std::string RenderParts(const SlurmPlan& plan, const std::vector<Part>& parts) {
  const std::size_t tasks = std::min(parts.size(), kMostTasks);
  std::string text = Header(plan) + fmt::format("#SBATCH --array=1-{}\n", tasks) +
                     Functions(plan, std::string(kArrayTask)) +
                     fmt::format(R"sh(
part() {{  # FILM FIRST:END OPTIONS...
  [[ -e $1 ]] && return
  mkdir -p "${{1%/*}}"
  run "$program" render "${{@:3}}" --sample-range "$2" --film "$1" --checkpoint {} --resume
}}
for ((i = SLURM_ARRAY_TASK_ID; i <= {}; i += {})); do
  case $i in
)sh",
                                 kCheckpoint, parts.size(), tasks);
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const Part& part = parts[i];
    text += fmt::format("    {}) part {} {}:{}{} ;;\n", i + 1, Quoted(part.film), part.first,
                        part.end, part.picture->options);
  }
  return text + "  esac\ndone\n";
}

std::string Finish(const SlurmPlan& plan) {
  std::string text = Header(plan) + Functions(plan, "$SLURM_JOB_ID");
  if (plan.shards > 1) {
    text += R"sh(
merge() {  # PICTURE FILM... OPTIONS...
  local film newer=
  for film in "${@:2}"; do [[ $film != *.film || $1 -nt $film ]] || newer=1; done
  [[ -n $newer ]] || return 0
  mkdir -p "$(dirname "$1")"
  run "$program" merge "${@:2}" -o "$1"
}
)sh";
    for (const SlurmPicture& picture : plan.pictures) {
      text += "merge " + Quoted(picture.output);
      for (const Part& part : PartsOf(plan, picture)) text += " " + Quoted(part.film);
      text += picture.format + '\n';
    }
  }
  return text + fmt::format("run \"$program\" batch {}\n", plan.batch);
}

// Partition, time, processors and memory are options of the submission: they depend on the cluster.
std::string Submit(const SlurmPlan& plan) {
  return fmt::format(R"sh(#!/bin/bash
# Submits the batch. Options go to sbatch, as in: submit.sh --cpus-per-task=8 --time=2:00:00
set -euo pipefail
folder={0}
queued=$(squeue --noheader --format=%A --name={1} --user="$(id -un)" | sort -un | tr '\n' ' ')
if [[ -n $queued ]]; then
  echo "is queued already: $queued"
  exit 0
fi
mkdir -p "$folder/logs" "$folder/parts"
logs=${{folder//%/%%}}/logs  # sbatch replaces what follows a %
render=$(sbatch --parsable --output="$logs/render_%a.txt" "$@" "$folder/render.sh")
render=${{render%%;*}}
finish=$(sbatch --parsable --output="$logs/finish.txt" --dependency="afterok:$render" \
  --kill-on-invalid-dep=yes "$@" "$folder/finish.sh")
echo "submitted $render, then ${{finish%%;*}}"
)sh",
                     Quoted(plan.folder), plan.name);
}

// Returns the words of options that differ from their defaults, or are given.
template <class Options, class Request>
std::string WordsOf(const Options& options, const Request& request) {
  static const Request defaults;
  std::string words;
  for (const auto& option : options) {
    if (option.get(request) != option.get(defaults)) words += CommandWords(option, request);
  }
  return words;
}

std::string CommandOf(const PictureRequest& request) {
  return WordsOf(JobOptions(), request.job) + WordsOf(LimitOptions(), request.limits) +
         WordsOf(ExposureOptions(), request.exposure);
}

// Returns the samples a pixel of a picture that is to be rendered in parts.
std::uint32_t SamplesToCut(const BatchPlan& batch, const BatchPicture& picture,
                           const PictureRequest& request,
                           std::map<std::string, RenderSettings>& settings) {
  for (const PictureOption& option : picture.options) {
    if (option.name == "time" || option.name == "noise" || option.name == "adaptive" ||
        option.name == "sample-range") {
      throw InputError(InputPosition::Line(batch.path, option.line),
                       fmt::format("parts of a picture need its samples beforehand, so {} cannot "
                                   "go with shards",
                                   option.name));
    }
  }
  if (request.job.samples_per_pixel) return std::uint32_t(*request.job.samples_per_pixel);
  const std::string& scene = request.job.scene;
  if (!settings.contains(scene)) {
    settings[scene] = ReadScene(scene, request.job.read).settings;
  }
  std::vector<std::string> notes;
  return ResolveRequest(request.job, settings[scene], notes).options.samples_per_pixel;
}

}  // namespace

std::vector<SlurmScript> SlurmScripts(const SlurmPlan& plan) {
  std::vector<Part> parts;
  if (plan.shards > 1) {
    for (const SlurmPicture& picture : plan.pictures) {
      for (Part& part : PartsOf(plan, picture)) parts.push_back(std::move(part));
    }
  }
  return {{"render.sh", plan.shards > 1 ? RenderParts(plan, parts) : RenderPictures(plan)},
          {"finish.sh", Finish(plan)},
          {"submit.sh", Submit(plan)}};
}

SlurmPlan PlanForSlurm(const BatchPlan& batch, const std::string& output_folder,
                       const std::string& folder, std::uint32_t shards) {
  SlurmPlan plan = {.program = std::filesystem::read_symlink("/proc/self/exe").string(),
                    .directory = std::filesystem::current_path().string(),
                    .folder = std::filesystem::absolute(folder).lexically_normal().string(),
                    .batch = " " + Quoted(batch.path),
                    .shards = shards};
  if (!output_folder.empty()) plan.batch += " -o " + Quoted(output_folder);
  if (plan.folder.ends_with('/')) plan.folder.pop_back();
  plan.name = fmt::format("skywave-{:016x}", XXH64(plan.folder.data(), plan.folder.size(), 0));
  std::map<std::string, RenderSettings> settings;  // by scene
  for (const BatchPicture& picture : batch.pictures) {
    const PictureRequest request = RequestOf(batch.path, picture.options);
    SlurmPicture part = {.output = picture.output,
                         .options = CommandOf(request),
                         .format = WordsOf(ExrFormatOptions(), request.format)};
    if (shards > 1) part.samples = SamplesToCut(batch, picture, request, settings);
    plan.pictures.push_back(std::move(part));
  }
  return plan;
}

}  // namespace skywave
