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
#include "job/session.h"
#include "scene/scene.h"
#include "skywave/skywave.h"

namespace skywave::api {

struct Scene::State {
  skywave::Scene scene;
  std::string source;    // file or name of a built-in scene; empty: it began as an empty scene
  bool changed = false;  // since it was read, so that no command repeats its pictures
  ReadOptions read;
  double load_seconds = 0;
  std::shared_ptr<const skywave::Image> environment;  // null: an option or the scene has the map

  // Returns the name that errors give the scene.
  std::string name() const { return source.empty() ? "scene" : source; }
};

struct Renderer::State {
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

// Returns the options of a job, except for those of its scene, bound to `request`.
std::vector<BoundOption> BindJobOptions(const std::shared_ptr<JobRequest>& request);

// Returns a job that renders `scene` as `request` asks; the scene's name, options of reading and
// map in memory are put into the request. Throws InputError.
RenderJob MakeJob(Scene::State scene, JobRequest request);

// Returns a copy. Throws Error for an image of the wrong size; `name` is the argument.
skywave::Image CopyImage(const ImageArray& image, const std::string& name);

}  // namespace skywave::api
