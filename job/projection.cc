#include "job/projection.h"

#include <fmt/format.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/glm.hpp>

#include "base/error.h"
#include "base/names.h"
#include "job/backplate.h"
#include "wavefront/frame.h"
#include "wavefront/option_names.h"

namespace skywave {
namespace {

constexpr double kNotedShare = 1e-3;  // of the map below the horizon

glm::dvec3 Vector(const float* v) { return {v[0], v[1], v[2]}; }

// Calls f(column, row, cosine, solid angle) for each texel of a map, where the cosine is that
// between its middle and `up`. Rows run at the same time.
template <class F>
void ForEachTexel(const EnvironmentMap& map, const glm::dvec3& up, const F& f) {
  const Image& image = map.latlong;
  const auto& m = map.map_from_world;
  const auto in_map = [&](std::size_t row) {
    return double(m[3 * row]) * up.x + double(m[3 * row + 1]) * up.y +
           double(m[3 * row + 2]) * up.z;
  };
  const glm::dvec3 axis(in_map(0), in_map(1), in_map(2));  // right, forward, up
  tbb::parallel_for(tbb::blocked_range<int>(0, image.height), [&](const auto& rows) {
    for (int row = rows.begin(); row < rows.end(); ++row) {
      const double theta = M_PI * (row + 0.5) / image.height;
      const double solid_angle = RowSolidAngle(image.width, image.height, row);
      for (int column = 0; column < image.width; ++column) {
        const double turn = 2 * M_PI * ((column + 0.5) / image.width - 0.5);
        const glm::dvec3 direction(std::sin(theta) * std::sin(turn),
                                   std::sin(theta) * std::cos(turn), std::cos(theta));
        f(column, row, glm::dot(direction, axis), solid_angle);
      }
    }
  });
}

// Projects the photograph behind the picture; returns whether it shows radiance.
bool ProjectPhotograph(const JobRequest& request, const Camera& camera, ProjectedPlace& place) {
  Backplate plate =
      ReadBackplate(request.backplate, *request.width, *request.height, request.working_space);
  place.photograph = std::move(plate.image);
  place.photograph_view = ViewPhotograph(place.photograph, camera);
  place.projection.photograph = &place.photograph_view;
  return !plate.of_screen;
}

void NoteBrightGround(const EnvironmentMap& map, const DomeView& dome,
                      std::vector<std::string>& notes) {
  const double share = ShareBeyondWhite(map, dome);
  if (share < kNotedShare) return;
  notes.push_back(
      fmt::format("`project dome`: {:.2g} % of the map below the horizon is brighter "
                  "than a white ground under it, and counts as white",
                  100 * share));
}

}  // namespace

AovSet PlanProjection(JobRequest& request, bool has_catchers) {
  const auto refuse = [&](const std::string& why) {
    throw OptionError("project", std::string(ToString(*request.project)), why);
  };
  if (request.dome && request.background == Background::kMap) {
    throw OptionError("dome", "", "is behind pictures with alpha, and `background map` has none");
  }
  const bool of_dome = request.dome && has_catchers;
  request.project = request.project.value_or(of_dome ? Projected::kDome : Projected::kNone);
  if (*request.project != Projected::kNone && !has_catchers) {
    refuse("gives colours to catchers, and the scene has none: name some, as in `catcher ground`");
  }
  if (*request.project == Projected::kCamera && request.backplate.empty()) {
    refuse("needs the photograph: give `backplate FILE`");
  }
  if (*request.project == Projected::kDome && !request.dome) {
    refuse("needs the height of the map above the ground: give `dome HEIGHT`");
  }
  return request.dome && request.backplate.empty() ? AovsOf(AovSum::kBackdrop) : 0;
}

std::shared_ptr<const ProjectedPlace> ProjectPlace(const ProjectionSources& sources,
                                                   std::vector<std::string>& notes) {
  const JobRequest& request = sources.request;
  const Projected project = *request.project;
  if (!request.dome && project == Projected::kNone) return nullptr;
  const auto place = std::make_shared<ProjectedPlace>();
  place->map = sources.map;
  if (request.dome) {
    if (!sources.map) {
      throw OptionError("dome", fmt::format("{}", request.dome->height),
                        "no light comes from a map: give `env FILE`");
    }
    place->dome = MakeDome(*request.dome, sources.parts.prepared(), sources.map->map);
  }
  bool of_radiance = project == Projected::kDome;
  if (project == Projected::kCamera) {
    of_radiance = ProjectPhotograph(request, sources.camera, *place);
  } else if (project == Projected::kDome) {
    place->projection.dome = &place->dome;
    NoteBrightGround(sources.map->map, place->dome, notes);
  }
  if (!of_radiance) return place;
  if (!sources.map) {
    throw OptionError("project", std::string(ToString(project)),
                      "a photograph of radiance tells colours by the light of a map, and there is "
                      "none: give `env FILE`");
  }
  place->irradiance = sources.parts.Irradiance(request, sources.light, *sources.map);
  place->projection.irradiance = place->irradiance->table.view();
  if (sources.has_lamps) {
    notes.push_back(
        fmt::format("`project {}`: the light of lamps is not counted in the colours of "
                    "catchers, which come out too bright under it",
                    ToString(project)));
  }
  return place;
}

DomeView MakeDome(const DomeRequest& request, const PreparedScene& prepared,
                  const EnvironmentMap& map) {
  const Scene& scene = *prepared.scene;
  const glm::vec3 up = EnvironmentFrame(scene.up_axis, scene.left_handed, 0)[2];
  const int axis = scene.up_axis - 'x';
  glm::vec3 center = 0.5f * (prepared.bounds.low + prepared.bounds.high);
  center[axis] = prepared.whole_bounds.low[axis] + request.height;
  DomeView dome = {.map = {.texels = nullptr,
                           .radiance_unit = 1,
                           .rgb = map.latlong->rgb.data(),
                           .width = std::uint32_t(map.latlong->width),
                           .height = std::uint32_t(map.latlong->height),
                           .lines = 0,
                           .map_from_world = {},
                           .row_area = nullptr},
                   .center = {center.x, center.y, center.z},
                   .up = {up.x, up.y, up.z},
                   .height = request.height,
                   .radius = request.radius};
  std::copy(map.map_from_world.begin(), map.map_from_world.end(), dome.map.map_from_world);
  return dome;
}

PhotographView ViewPhotograph(const Image& photograph, const Camera& camera) {
  const CameraView view = MakeCameraView(camera, photograph.width, photograph.height, nullptr);
  if (view.kind != CameraKind::kPerspective) {
    throw OptionError("project", "camera",
                      fmt::format("a photograph is projected by a perspective camera, and this one "
                                  "is of the kind {}",
                                  ToString(view.kind)));
  }
  // A point is origin + depth (corner + x right + y down).
  const glm::dmat3 from_pixel(Vector(view.right), Vector(view.down), Vector(view.corner));
  const glm::dmat3 to_pixel = glm::inverse(from_pixel);
  const glm::dvec3 origin = to_pixel * Vector(view.origin);
  PhotographView projected = {.rgb = photograph.rgb.data(),
                              .width = std::uint32_t(photograph.width),
                              .height = std::uint32_t(photograph.height)};
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      projected.pixel_from_world[row][column] = float(to_pixel[column][row]);
    }
    projected.pixel_from_world[row][3] = float(-origin[row]);
  }
  return projected;
}

double ShareBeyondWhite(const EnvironmentMap& map, const DomeView& dome) {
  const glm::dvec3 up = Vector(dome.up);
  std::vector<std::array<double, 3>> rows(std::size_t(map.latlong->height));
  ForEachTexel(map, up, [&](int column, int row, double cosine, double solid_angle) {
    const float* const radiance = map.latlong->Pixel(column, row);
    for (std::size_t c = 0; c < 3 && cosine > 0; ++c) {
      rows[std::size_t(row)][c] += double(radiance[c]) * cosine * solid_angle;
    }
  });
  std::array<double, 3> white = {};  // its radiance
  for (const std::array<double, 3>& row : rows) {
    for (std::size_t c = 0; c < 3; ++c) white[c] += row[c] / M_PI;
  }
  std::vector<double> beyond(rows.size());
  ForEachTexel(map, up, [&](int column, int row, double cosine, double solid_angle) {
    const float* const radiance = map.latlong->Pixel(column, row);
    const bool is_beyond = double(radiance[0]) > white[0] || double(radiance[1]) > white[1] ||
                           double(radiance[2]) > white[2];
    if (cosine < 0 && is_beyond) beyond[std::size_t(row)] += solid_angle;
  });
  double sum = 0;
  for (const double row : beyond) sum += row;
  return sum / (2 * M_PI);
}

}  // namespace skywave
