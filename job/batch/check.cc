#include "job/batch/check.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <map>
#include <vector>

#include "base/error.h"
#include "base/files.h"
#include "image/image.h"
#include "job/batch/axes.h"
#include "job/batch/render_picture.h"
#include "job/choose_camera.h"
#include "job/job_parts.h"
#include "job/map_sequence.h"
#include "job/options.h"
#include "job/picture.h"
#include "scene/reader.h"

namespace skywave {
namespace {

// Returns the folders of the outputs, "." for the working directory.
std::set<std::string> OutputFolders(const BatchPlan& plan) {
  std::set<std::string> folders;
  for (const BatchPicture& picture : plan.pictures) {
    const std::string folder = std::filesystem::path(picture.output).parent_path().string();
    folders.insert(folder.empty() ? "." : folder);
  }
  return folders;
}

// Throws unless a folder is writable, or could be made.
void CheckFolder(const std::string& folder) {
  std::filesystem::path existing = folder;
  std::error_code ignored;
  while (!existing.empty() && !std::filesystem::exists(existing, ignored)) {
    existing = existing.parent_path();
  }
  if (existing.empty()) existing = ".";
  if (!std::filesystem::is_directory(existing, ignored)) {
    throw InputError(InputPosition::File(folder),
                     fmt::format("cannot be a folder of pictures: {} is a file", existing.string()),
                     kExitIo);
  }
  if (::access(existing.c_str(), W_OK | X_OK) == 0) return;
  const char* const reason = std::strerror(errno);
  throw InputError(
      InputPosition::File(folder),
      fmt::format("pictures cannot be written there: {}: {}", existing.string(), reason), kExitIo);
}

// A scene that has been read at one frame, and the requests with the least and the greatest one.
struct CheckedScene {
  Scene scene;  // without its meshes and pictures
  std::optional<double> frame;
  JobRequest first, last;
};

Scene ReadWithoutMeshes(const JobRequest& job) {
  Scene scene = ReadScene(job.scene, job.read);
  scene.meshes = {}, scene.objects = {}, scene.instances = {}, scene.images = {},
  scene.environments = {};
  return scene;
}

void AddFrame(const JobRequest& job, CheckedScene& checked) {
  if (job.read.frame < checked.first.read.frame) checked.first = job;
  if (job.read.frame > checked.last.read.frame) checked.last = job;
}

// Reads a scene that moves at both ends of its frames too: animations are checked as they are read,
// and their errors show at an end rather than in the middle.
void CheckEndsOfFrames(const CheckedScene& checked) {
  if (checked.scene.animations.empty()) return;
  for (const JobRequest* const end : {&checked.first, &checked.last}) {
    if (end->read.frame != checked.frame) ReadScene(end->scene, end->read);
  }
}

// Resolves the options of a picture with its scene, and returns its samples.
std::uint64_t CountSamples(const BatchPlan& plan, const BatchPicture& picture, const Scene& scene) {
  std::vector<std::string> notes;
  try {
    const PictureRequest request = RequestOf(plan.path, picture.options);
    const RenderOptions options = ResolveRequest(request.job, scene.settings, notes).options;
    SceneCamera(scene, request.job.camera.name);
    LayersForLimits(request.limits, options.integrator);
    const SampleRange samples = ChooseSamples(request.limits, options.samples_per_pixel);
    return std::uint64_t(options.width) * std::uint64_t(options.height) * samples.count();
  } catch (const OptionError& error) {
    throw AtOption(plan.path, picture.options, error);
  } catch (const InputError& error) {
    throw InputError(InputPosition::File(plan.path),
                     fmt::format("picture {}: {}", picture.index, error.what()), error.exit_code());
  }
}

}  // namespace

std::set<std::string> InputFiles(const BatchPlan& plan) {
  std::set<std::string> files;
  for (const BatchPicture& picture : plan.pictures) {
    for (const PictureOption& option : picture.options) {
      if (!NamesFile(option.name)) continue;
      const bool moves = option.name == "env" && IsMapSequence(option.text);
      const std::string file = moves ? MapFile(RequestOf(plan.path, picture.options).job)
                                     : SplitFileName(option.text).path;
      std::error_code ignored;
      if (std::filesystem::is_regular_file(file, ignored)) files.insert(file);
    }
  }
  return files;
}

void CheckOutputs(const BatchPlan& plan) {
  for (const std::string& folder : OutputFolders(plan)) CheckFolder(folder);
  const std::set<std::string> inputs = InputFiles(plan);
  for (const BatchPicture& picture : plan.pictures) {
    for (const std::string& output : {picture.output, PngBeside(picture.output)}) {
      std::error_code ignored;
      if (!std::filesystem::exists(output, ignored)) continue;
      if (std::filesystem::is_directory(output, ignored)) {
        throw InputError(InputPosition::File(output), "is a folder, not a file", kExitIo);
      }
      for (const std::string& input : inputs) CheckNotInput(output, input);
    }
  }
}

void PrepareOutputs(const BatchPlan& plan, const BatchShare& share) {
  std::vector<std::string> targets = {ReportName(plan, share, ".json"),
                                      ReportName(plan, share, ".html")};
  for (const std::string& folder : OutputFolders(plan)) {
    std::error_code error;
    std::filesystem::create_directories(folder, error);
    if (error) {
      throw InputError(InputPosition::File(folder), "the folder cannot be made: " + error.message(),
                       kExitIo);
    }
    targets.push_back((std::filesystem::path(folder) / "skywave_batch").string());
    CheckWritable(targets.back());
  }
  for (const BatchPicture& picture : plan.pictures) {
    targets.push_back(picture.output);
    targets.push_back(PngBeside(picture.output));
    targets.push_back(CheckpointBeside(picture.output));
  }
  RemoveLeftovers(targets);
}

DryRun CheckWithoutRendering(const BatchPlan& plan) {
  CheckOutputs(plan);
  DryRun result;
  std::map<std::string, CheckedScene> scenes;
  std::set<std::string> maps;
  for (const BatchPicture& picture : plan.pictures) {
    const JobRequest job = RequestOf(plan.path, picture.options).job;
    const auto [found, is_new] = scenes.try_emplace(SceneKey(job));
    CheckedScene& checked = found->second;
    if (is_new) checked = {ReadWithoutMeshes(job), job.read.frame, job, job};
    AddFrame(job, checked);
    if (const std::string map = MapFile(job); !map.empty() && maps.insert(map).second) {
      ReadImage(map, job.environment.limits);
    }
    result.samples += CountSamples(plan, picture, checked.scene);
  }
  for (const auto& [key, checked] : scenes) CheckEndsOfFrames(checked);
  result.scenes = scenes.size();
  result.maps = maps.size();
  return result;
}

}  // namespace skywave
