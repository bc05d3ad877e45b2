// Handles pbrt's directive Camera.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "base/error.h"
#include "base/files.h"
#include "scene/lens_system.h"
#include "scene/pbrt/lens_file.h"
#include "scene/pbrt/state.h"

namespace skywave {
namespace {

// Returns nothing for pbrt's default, [-1, 1] on the shorter side by the aspect of the film;
// otherwise the window follows "frameaspectratio" or "screenwindow".
std::optional<ScreenWindow> ReadScreenWindow(PbrtParameters& parameters) {
  std::optional<ScreenWindow> window;
  if (const auto aspect = FindFloat(parameters, "frameaspectratio")) {
    if (!(*aspect > 0)) {
      throw InputError(parameters.position, fmt::format("{}: \"frameaspectratio\" is {}",
                                                        parameters.directive, *aspect));
    }
    const float x = std::max(*aspect, 1.0f), y = std::max(1 / *aspect, 1.0f);
    window = ScreenWindow{-x, x, -y, y};
  }
  if (const PbrtParameter* given = Find(parameters, {"float"}, "screenwindow")) {
    const std::vector<float>& w = given->floats;
    if (w.size() != 4 || !(w[0] < w[1] && w[2] < w[3])) {
      throw InputError(given->position,
                       fmt::format("{}: \"screenwindow\" takes left < right, bottom < top",
                                   parameters.directive));
    }
    window = ScreenWindow{w[0], w[1], w[2], w[3]};
  }
  return window;
}

void ReadLens(PbrtParameters& parameters, Camera& camera) {
  camera.lens_radius = FindFloat(parameters, "lensradius").value_or(0);
  camera.focal_distance = FindFloat(parameters, "focaldistance").value_or(camera.focal_distance);
  if (!(camera.lens_radius >= 0 && camera.focal_distance > 0)) {
    throw InputError(parameters.position,
                     parameters.directive + ": the lens is negative or focused on itself");
  }
}

// pbrt-v4 exposes the film for as long as the shutter is open. Nothing moves here, so that is all
// that the times mean. Version 3 does not ask how long it is.
void ReadShutter(PbrtReader& reader, PbrtParameters& parameters) {
  const float open = FindFloat(parameters, "shutteropen").value_or(0);
  const float close = FindFloat(parameters, "shutterclose").value_or(1);
  if (reader.v3) return;
  reader.exposure_time = close - open;
  if (!(reader.exposure_time > 0 && reader.exposure_time <= 1e6f)) {
    throw InputError(parameters.position,
                     fmt::format("{}: the shutter opens at {} s and closes at {} s",
                                 parameters.directive, open, close));
  }
}

void ReadFieldOfView(PbrtParameters& parameters, Camera& camera) {
  camera.fov_degrees = FindFloat(parameters, "fov").value_or(90);
  if (const auto half = FindFloat(parameters, "halffov")) camera.fov_degrees = 2 * *half;
  if (!(camera.fov_degrees > 0 && camera.fov_degrees < 180)) {
    throw InputError(parameters.position,
                     fmt::format("{}: \"fov\" is {}: not between 0 and 180 degrees",
                                 parameters.directive, camera.fov_degrees));
  }
}

// Reads the lens of a realistic camera; nothing, with a warning, if its file is missing.
std::optional<PbrtLens> ReadLensOfCamera(PbrtReader& reader, PbrtParameters& parameters) {
  PbrtLens lens = {.position = parameters.position};
  const float diameter = FindFloat(parameters, "aperturediameter").value_or(1) / 1000;
  lens.focus_distance = FindFloat(parameters, "focusdistance").value_or(10);
  // Version 3 has a second weight that is irradiance while the shutter is open, version 4 that
  // alone, with the time among the gains of its film.
  if (reader.v3 && FindBool(parameters, "simpleweighting").value_or(true)) {
    lens.design.weight = LensWeight::kRelative;
  } else if (reader.v3) {
    lens.design.gain = double(FindFloat(parameters, "shutterclose").value_or(1)) -
                       double(FindFloat(parameters, "shutteropen").value_or(0));
  }
  if (const auto shape = FindString(parameters, "aperture"); shape && *shape != "circular") {
    Warn(reader, parameters, fmt::format("the aperture \"{}\" is not supported: round", *shape));
  }
  if (!(diameter > 0 && lens.focus_distance > 0 && lens.design.gain > 0)) {
    throw InputError(parameters.position,
                     parameters.directive + ": its aperture, focus or time is not positive");
  }
  const auto name = FindString(parameters, "lensfile");
  if (!name) {
    Warn(reader, parameters, "has no \"lensfile\": rendered as perspective");
    return std::nullopt;
  }
  try {
    const std::string path = ResolvePbrtPath(reader, *name, parameters.position);
    lens.design.interfaces = ParsePbrtLens(ReadFile(path), path);
  } catch (const InputError& error) {
    AddMissing(reader.warnings, parameters.position, "Camera \"realistic\"", error,
               "rendered as perspective");
    return std::nullopt;
  }
  for (LensInterface& stop : lens.design.interfaces) {
    if (stop.radius == 0) stop.aperture = std::min(stop.aperture, double(diameter) / 2);
  }
  return lens;
}

// Reads pbrt-v4's "spherical" camera and pbrt-v3's "environment", which is the lat-long mapping of
// the former: the middle of the picture looks along -x, its right half along -z.
void ReadSphericalCamera(PbrtReader& reader, PbrtParameters& parameters, bool v4, Camera& camera) {
  const std::string mapping =
      v4 ? FindString(parameters, "mapping").value_or("equalarea") : "equirectangular";
  if (mapping == "equalarea") {
    camera.kind = CameraKind::kEqualArea;
    return;
  }
  if (mapping != "equirectangular") {
    Warn(reader, parameters,
         fmt::format("mapping \"{}\" is not supported: equirectangular is used", mapping));
  }
  camera.kind = CameraKind::kLatLong;
  camera.world_from_camera *= glm::mat4({0, 0, -1, 0}, {0, 1, 0, 0}, {-1, 0, 0, 0}, {0, 0, 0, 1});
}

}  // namespace

void ReadPbrtCamera(PbrtReader& reader, PbrtSource& source, const PbrtToken& word) {
  auto [type, parameters] = ReadPbrtImplementation(reader, source, word);
  if (const auto& flaw = reader.state.flaw) {
    throw InputError(parameters.position,
                     fmt::format("a camera under a transform that is {} since the {} of {}",
                                 flaw->what, flaw->directive, ToString(flaw->position)));
  }
  Camera camera;
  const glm::dmat4 world_from_camera = glm::inverse(reader.state.to_world);
  reader.coordinate_systems["camera"] = world_from_camera;
  camera.world_from_camera = world_from_camera;
  camera.world_from_camera[3] = glm::vec4(ScenePlace(reader, glm::dvec3(world_from_camera[3])), 1);
  if (type == "spherical" || type == "environment") {
    ReadSphericalCamera(reader, parameters, type == "spherical", camera);
  } else if (type == "orthographic") {
    camera.kind = CameraKind::kOrthographic;
    ReadLens(parameters, camera);
    camera.window = ReadScreenWindow(parameters);
  } else if (type == "realistic") {
    reader.lens = ReadLensOfCamera(reader, parameters);
    camera.fov_degrees = 90;
  } else {
    ReadFieldOfView(parameters, camera);
    ReadLens(parameters, camera);
    camera.window = ReadScreenWindow(parameters);
    if (type != "perspective") {
      Warn(reader, parameters, "is not supported: rendered as perspective");
      UseAll(parameters);
    }
  }
  ReadShutter(reader, parameters);
  ReportUnused(parameters, reader.warnings);
  reader.scene.camera = camera;
}

void PlacePbrtLens(PbrtReader& reader) {
  if (!reader.lens || !reader.scene.camera) return;
  auto& [design, focus_distance, position] = *reader.lens;
  Camera& camera = *reader.scene.camera;
  const RenderSettings& settings = reader.scene.settings;
  design.film_diagonal = double(reader.film_diagonal) / 1000;
  if (!FocusLens(design, focus_distance)) {
    AddWarning(reader.warnings, position,
               fmt::format("Camera \"realistic\": the lens cannot be focused at {}: rendered as "
                           "perspective",
                           focus_distance));
    return;
  }
  auto lens = std::make_shared<const LensSystem>(design);
  camera.kind = CameraKind::kRealistic;
  // The angle of the camera without the lens, if that is asked for.
  const double width = *settings.width, height = *settings.height;
  const double shorter = design.film_diagonal * std::min(width, height) / std::hypot(width, height);
  camera.fov_degrees =
      float(glm::degrees(2 * std::atan(shorter / 2 / std::max(lens->focal_length, 1e-6))));
  camera.realistic = std::move(lens);
}

}  // namespace skywave
