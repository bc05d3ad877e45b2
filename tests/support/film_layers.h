// Renders films with layers and finds the values of a layer by its name.
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "job/job.h"
#include "wavefront/film/aovs.h"
#include "wavefront/render.h"

namespace skywave {

using Layers = std::map<std::string, std::vector<float>>;

inline Layers ByName(const std::vector<NamedChannel>& channels) {
  Layers layers;
  for (const NamedChannel& channel : channels) layers[channel.name] = channel.values;
  return layers;
}

inline RenderJob MakeJob(const Scene& scene, JobRequest request, std::string_view aovs) {
  request.options.aovs = ParseAovs(aovs).value();
  return RenderJob(scene, request);
}

inline Film Render(const RenderJob& job, const FrameView& frame) {
  Film film = job.MakeFilm();
  RenderFrame(frame, film);
  return film;
}
inline Film Render(const RenderJob& job) { return Render(job, job.frame()); }

inline Layers Resolve(const RenderJob& job) {
  return ByName(Render(job).ResolveAovs(job.options().samples_per_pixel));
}

}  // namespace skywave
