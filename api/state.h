// The objects of the library hold this state.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "job/exposure.h"
#include "job/job.h"
#include "job/limits.h"
#include "job/picture.h"
#include "job/picture_request.h"
#include "job/session.h"
#include "scene/scene.h"
#include "skywave/skywave.h"

namespace skywave::api {

struct SceneState {
  // The contents, which copies of the scene share until one of them is changed.
  std::shared_ptr<LoadedScene> loaded = std::make_shared<LoadedScene>(skywave::Scene());
  // What renderers made of it for each other; null: none has been there since it changed.
  mutable std::shared_ptr<const SharedScene> shared;
  std::string source;       // file or name of a built-in scene; empty: it began as an empty scene
  bool has_copies = false;  // other scenes read `loaded`, and may do so on other threads
  bool changed = false;     // since it was read, so that no command repeats its pictures
  ReadOptions read;
  double load_seconds = 0;
  // In place of what the scene has; they leave its geometry as it is.
  std::optional<Camera> camera;
  glm::dvec3 camera_at{0.0};                          // CameraRequest::placed_at
  std::shared_ptr<const skywave::Image> environment;  // an option comes before it
  std::uint64_t environment_hash = 0;

  // Returns the name that errors give the scene.
  std::string name() const { return source.empty() ? "scene" : source; }
  const skywave::Scene& scene() const { return loaded->scene; }
  // Returns the scene for a change of its contents.
  skywave::Scene& Change();
  // Returns the state of a copy, which shares the contents until either is changed.
  std::unique_ptr<SceneState> Copy();
  // Returns what renderers share.
  const SharedScene& Share() const;
};

struct RendererState {
  ExposureRequest exposure;
  RenderLimits limits;
  ExrFormat format;
  std::optional<RenderJob> job;
  PictureIdentity identity;
  std::vector<std::string> notes;
  // These are set once rendering is complete.
  std::optional<RenderedFilm> rendered;
  Picture picture;
  std::vector<Layer> layers;
  double write_seconds = 0;

  // Throws Error if there is no picture.
  const RenderedFilm& finished() const;
  // Writes a file of the finished picture, and adds the time to `write_seconds`.
  void Write(const std::function<void()>& write);
};

// Returns a job that renders `scene` as `request` asks; the scene's name, options of reading,
// camera and map in memory are put into the request. Throws InputError.
RenderJob MakeJob(const SceneState& scene, JobRequest request);

// Puts `options` into the fields that `bound` leads to. Throws InputError.
void SetOptions(const std::vector<BoundOption>& bound, const Options& options);

// Returns a copy. Throws Error for an image of the wrong size; `name` is the argument.
skywave::Image CopyImage(const ImageArray& image, const std::string& name);

}  // namespace skywave::api
