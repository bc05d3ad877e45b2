// The picture of a place, laid onto it: the photograph behind the scene from its camera, or the map
// on the ground and on a dome.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "image/image.h"
#include "job/job_parts.h"
#include "job/request.h"
#include "kernels/lights/projection.h"
#include "scene/scene.h"

namespace skywave {

// Settles what is projected in a request; returns the layers that it needs. Throws OptionError.
AovSet PlanProjection(JobRequest& request, bool has_catchers);

// What the views of a frame point to.
struct ProjectedPlace {
  std::shared_ptr<const PlacedMap> map;
  std::shared_ptr<const MapIrradiance> irradiance;
  Image photograph;
  PhotographView photograph_view;
  DomeView dome;
  ProjectionView projection;
  // Whether catchers get colours.
  bool projects() const { return projection.photograph != nullptr || projection.dome != nullptr; }
};

// The parts of a job from which a picture is projected.
struct ProjectionSources {
  const JobRequest& request;  // planned
  const JobParts& parts;
  const LoadedLight& light;
  std::shared_ptr<const PlacedMap> map;  // null: it gives no light
  const Camera& camera;
  bool has_lamps;  // that are not of objects
};

// Lays out what a request projects; null if that is nothing. Throws OptionError.
std::shared_ptr<const ProjectedPlace> ProjectPlace(const ProjectionSources& sources,
                                                   std::vector<std::string>& notes);

// Returns the dome of a request: the point of its map is over the middle of the scene without its
// ground, and the lowest level of all is the ground of the dome.
DomeView MakeDome(const DomeRequest& request, const PreparedScene& prepared,
                  const EnvironmentMap& map);

// Returns a photograph as `camera` projects it. Throws OptionError if that has no plane film or
// projects in parallel.
PhotographView ViewPhotograph(const Image& photograph, const Camera& camera);

// Returns the share of the directions below the horizon in which a map is brighter than a white
// surface on the ground under it.
double ShareBeyondWhite(const EnvironmentMap& map, const DomeView& dome);

}  // namespace skywave
