// What the objects of the library hold.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "job/exposure.h"
#include "job/job.h"
#include "scene/scene.h"
#include "skywave/skywave.h"
#include "wavefront/render.h"

namespace skywave::api {

struct Scene::State {
  skywave::Scene scene;
  std::string source;    // file or name of a built-in scene; empty: made of arrays alone
  bool changed = false;  // since it was read: no command repeats its pictures
  ReadOptions read;
  double load_seconds = 0;
  std::shared_ptr<const skywave::Image> environment;  // null: that of an option or of the scene

  // Returns the name by which errors call the scene.
  std::string name() const { return source.empty() ? "scene" : source; }
};

struct Renderer::State {
  ExposureRequest exposure;
  bool repeatable = true;  // a command makes the same picture
  std::optional<RenderJob> job;
  std::vector<std::string> notes;
  // These are set once rendering is complete.
  std::optional<skywave::Image> picture;
  std::vector<NamedChannel> channels;
  std::vector<Layer> layers;
  FrameResult frame;
  double write_seconds = 0;

  // Throws Error if there is none.
  const skywave::Image& finished() const;
};

// Returns the options of a job, except for those of its scene, bound to `request`.
std::vector<BoundOption> BindJobOptions(const std::shared_ptr<JobRequest>& request);

// Returns a job that renders `scene` as `request` asks. Throws InputError.
RenderJob MakeJob(Scene::State scene, JobRequest request);

// Throws Error for an image of the wrong size; `name` is the argument.
skywave::Image CopyImage(const ImageArray& image, const std::string& name);

}  // namespace skywave::api
