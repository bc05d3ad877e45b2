// How the value of an option follows from the request, the settings of its scene file and other
// options, for those that take more than a copy. Pure functions.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "job/request.h"

namespace skywave {

// Points of a pixel's sequence that one of its samples can use up; with the number of samples they
// must stay below 2^32.
std::uint32_t MostPointsOfASample(const RenderOptions& options);

// Steps of the table of options (JobOption::resolve). Each throws InputError for a value that makes
// no film.
void ResolveSize(JobRequest& request, const SceneDefaults& scene);
void ResolveIntegrator(JobRequest& request, const SceneDefaults& scene);
void ResolveStrategy(JobRequest& request, const SceneDefaults& scene);
// options.width and height become those of the part. Fractions of a scene file are rounded up to
// pixels, as pbrt does.
void ResolveCrop(JobRequest& request, const SceneDefaults& scene);
// The filter and its radius: a filter of the request has its own radius, not the scene's.
void ResolveFilter(JobRequest& request, const SceneDefaults& scene);

// Lowers a depth beyond kMaxDepth, which a scene file may have, and says so in `notes`.
void LimitDepth(JobRequest& request, std::vector<std::string>& notes);

// Says in `notes` where light paths are to be guided and there are none.
void NoteUselessGuide(const JobRequest& request, std::vector<std::string>& notes);

// Says in `notes` where the filter of the scene is not the one that is used, though nothing else
// was asked for. Throws InputError instead where the scene is read strictly.
void NoteOtherFilter(const JobRequest& request, const SceneDefaults& scene,
                     std::vector<std::string>& notes);

// The same of limits of samples.
void NoteUnknownLimits(const JobRequest& request, const SceneDefaults& scene,
                       std::vector<std::string>& notes);

// Throws InputError for resolved options that do not go together, whatever the scene holds.
void CheckResolved(const JobRequest& request);

}  // namespace skywave
