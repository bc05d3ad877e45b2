// Reads pbrt's lights. RGB values are linear Rec. 709, radiance or intensity in the scene's units,
// without pbrt-v4's scaling by the spectrum of an illuminant. docs/pbrt.md explains spectra.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/gtc/constants.hpp>
#include <utility>

#include "base/error.h"
#include "scene/light_shapes.h"
#include "scene/local_lights.h"
#include "scene/pbrt/light_images.h"
#include "scene/pbrt/state.h"
#include "scene/portals.h"

namespace skywave {
namespace {

constexpr double kPi = glm::pi<double>();

// Returns the colour `name` (default 1) times "scale", which is a number in pbrt-v4 and a colour in
// pbrt-v3.
glm::vec3 Emission(PbrtReader& reader, PbrtParameters& parameters, std::string_view name) {
  const SpectrumUse use = reader.v3 ? SpectrumUse::kEmission : SpectrumUse::kUnitEmission;
  glm::vec3 emission = FindColor(parameters, name, reader.color_textures, reader.warnings, use)
                           .value_or(glm::vec3(1));
  if (Find(parameters, {"float"}, "scale")) {
    emission *= *FindFloat(parameters, "scale");
  } else if (const auto scale =
                 FindColor(parameters, "scale", reader.color_textures, reader.warnings)) {
    emission *= *scale;
  }
  // This also refuses NaN, and values so large that sums of lights would overflow.
  if (!glm::all(glm::greaterThanEqual(emission, glm::vec3(0))) ||
      !glm::all(glm::lessThanEqual(emission, glm::vec3(1e18f)))) {
    throw InputError(parameters.position,
                     parameters.directive + ": negative radiance, or more than 1e18");
  }
  return emission;
}

// Returns a number that replaces the strength of a light, or nothing if it is absent or, as in
// pbrt, not positive.
std::optional<float> Strength(PbrtParameters& parameters, std::string_view name) {
  const auto value = FindFloat(parameters, name);
  if (!value || !(*value > 0)) return std::nullopt;
  if (!(*value <= 1e18f)) {
    throw InputError(parameters.position,
                     fmt::format("{}: \"{}\" is {}", parameters.directive, name, *value));
  }
  return value;
}

// Returns a point of the light's space, transformed to the world.
glm::dvec3 FindPoint(PbrtReader& reader, PbrtParameters& parameters, std::string_view name,
                     const glm::dvec3& otherwise) {
  glm::dvec3 point = otherwise;
  if (const PbrtParameter* found = Find(parameters, {"point", "point3"}, name)) {
    if (found->floats.size() != 3) {
      throw InputError(found->position,
                       fmt::format("\"{} {}\" takes one point", found->type, name));
    }
    point = {found->floats[0], found->floats[1], found->floats[2]};
  }
  return glm::dvec3(reader.state.to_world * glm::dvec4(point, 1));
}

glm::vec3 Direction(PbrtParameters& parameters, const glm::dvec3& from, const glm::dvec3& to) {
  const double length = glm::length(to - from);
  if (!(length > 0) || !std::isfinite(length)) {
    throw InputError(parameters.position,
                     parameters.directive + ": \"from\" and \"to\" are no direction");
  }
  return glm::vec3((to - from) / length);
}

// Returns whether a transform changes angles: its axes are not at right angles or not equally long.
bool Stretches(const glm::dmat3& linear) {
  const double lengths[] = {glm::length(linear[0]), glm::length(linear[1]), glm::length(linear[2])};
  double skew = 0;
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3;
    skew += std::abs(glm::dot(linear[i], linear[j])) / (lengths[i] * lengths[j]);
  }
  const auto [least, most] = std::minmax({lengths[0], lengths[1], lengths[2]});
  return skew > 1e-4 || most > 1.001 * least;
}

void PointLight(PbrtReader& reader, PbrtParameters& parameters) {
  PunctualLight light = {.kind = LocalLightKind::kPoint};
  light.emission = Emission(reader, parameters, "I");
  if (const auto power = Strength(parameters, "power")) light.emission *= *power / (4 * kPi);
  light.position = ScenePlace(reader, FindPoint(reader, parameters, "from", {0, 0, 0}));
  reader.scene.lights.push_back(light);
}

void SpotLight(PbrtReader& reader, PbrtParameters& parameters) {
  PunctualLight light = {.kind = LocalLightKind::kSpot};
  light.emission = Emission(reader, parameters, "I");
  const glm::dvec3 from = FindPoint(reader, parameters, "from", {0, 0, 0});
  const glm::dvec3 to = FindPoint(reader, parameters, "to", {0, 0, 1});
  light.position = ScenePlace(reader, from);
  light.direction = Direction(parameters, from, to);
  const float cone = FindFloat(parameters, "coneangle").value_or(30);
  const float full = cone - FindFloat(parameters, "conedeltaangle").value_or(5);
  if (!(cone > 0 && cone <= 180 && full <= cone)) {
    throw InputError(parameters.position,
                     fmt::format("{}: a cone of {} degrees, full up to {}, is impossible",
                                 parameters.directive, cone, full));
  }
  light.cos_dark = std::cos(glm::radians(cone));
  light.cos_full = std::max(std::cos(glm::radians(full)), light.cos_dark);
  if (reader.v3) light.curve = SpotCurve::kFourth;
  if (const auto power = Strength(parameters, "power")) {
    light.emission *= *power / SpotSolidAngle(light);
  }
  const glm::dmat3 linear(reader.state.to_world);
  if (Stretches(linear)) {
    // Directions are transformed to the light's space, where the cone is round.
    const glm::dvec3 axis = glm::normalize(glm::inverse(linear) * (to - from));
    const glm::dvec3 other = std::abs(axis.x) < 0.5 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
    const glm::dvec3 across = glm::normalize(glm::cross(other, axis));
    light.kind = LocalLightKind::kShaped;
    light.form = LightForm{
        .mapping = LightMapping::kCone,
        .world_from_light = glm::mat3(linear * glm::dmat3(across, glm::cross(axis, across), axis))};
  }
  reader.scene.lights.push_back(light);
}

// Scales the emission to the power that the file asks for, if it does, of a light that sends out
// `per_unit` with an emission of 1 [sr].
void SetPower(PbrtParameters& parameters, double per_unit, PunctualLight& light) {
  const auto power = Strength(parameters, "power");
  if (!power) return;
  if (!(per_unit > 0)) {
    throw InputError(parameters.position,
                     parameters.directive + ": a light with a power needs an image with light");
  }
  light.emission *= float(*power / per_unit);
}

// Reads a light whose directions have the factors of an equal-area square (pbrt-v4) or of a
// lat-long image (pbrt-v3), y up.
void GoniometricLight(PbrtReader& reader, PbrtParameters& parameters) {
  PunctualLight light = {.kind = LocalLightKind::kShaped};
  light.emission = Emission(reader, parameters, "I");
  light.position = ScenePlace(reader, glm::dvec3(reader.state.to_world[3]));
  const PbrtSphereImage sphere =
      SphereImageOf(reader, parameters, FindPbrtLightImage(reader, parameters));
  SetPower(parameters, 4 * kPi * sphere.mean, light);
  const glm::dmat3 linear(reader.state.to_world);
  light.form = LightForm{.mapping = LightMapping::kSphere,
                         .world_from_light = glm::mat3(linear[0], linear[2], linear[1]),
                         .image = sphere.image};
  reader.scene.lights.push_back(light);
}

// Reads a light that projects an image along +z, its top towards +y (pbrt-v4) or -y (pbrt-v3), with
// `fov` along the shorter side.
void ProjectionLight(PbrtReader& reader, PbrtParameters& parameters) {
  PunctualLight light = {.kind = LocalLightKind::kShaped};
  light.emission = Emission(reader, parameters, "I");
  light.position = ScenePlace(reader, glm::dvec3(reader.state.to_world[3]));
  const auto [index, v4] = FindPbrtLightImage(reader, parameters);
  const float fov = FindFloat(parameters, "fov").value_or(v4 ? 90.0f : 45.0f);
  if (!(fov > 0 && fov < 180)) {
    throw InputError(parameters.position,
                     fmt::format("{}: \"fov\" is {}", parameters.directive, fov));
  }
  const CompactImage& image = reader.scene.images[index];
  const glm::dvec2 size(image.width, image.height);
  const glm::dvec2 half = std::tan(glm::radians(double(fov)) / 2) * size / std::min(size.x, size.y);
  double sum = 0;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const glm::dvec2 at = (2.0 * (glm::dvec2(x, y) + 0.5) / size - 1.0) * half;
      sum += double(Luminance(image.Pixel(x, y).data())) * std::pow(1 + glm::dot(at, at), -1.5);
    }
  }
  SetPower(parameters, 4 * half.x * half.y * sum / (size.x * size.y), light);
  glm::mat3 world_from_light(reader.state.to_world);
  if (!v4) world_from_light[1] = -world_from_light[1];
  light.form = LightForm{.mapping = LightMapping::kPlane,
                         .world_from_light = world_from_light,
                         .image = index,
                         .half_size = glm::vec2(half)};
  reader.scene.lights.push_back(light);
}

void DistantLight(PbrtReader& reader, PbrtParameters& parameters) {
  PunctualLight light = {.kind = LocalLightKind::kDistant};
  light.emission = Emission(reader, parameters, "L");
  if (const auto lux = Strength(parameters, "illuminance")) light.emission *= *lux;
  const glm::dvec3 from = FindPoint(reader, parameters, "from", {0, 0, 0});
  const glm::dvec3 to = FindPoint(reader, parameters, "to", {0, 0, 1});
  light.direction = Direction(parameters, to, from);
  reader.scene.lights.push_back(light);
}

// Returns the right, forward and up axes of a lat-long map in the light's space (see
// pbrt/reader.h), transformed to the world. The axes are unit vectors because a scale does not
// change pbrt's directions either.
glm::mat3 MapFrame(PbrtReader& reader, const PbrtParameters& parameters) {
  const glm::dmat3 linear(reader.state.to_world);
  glm::dmat3 frame(-linear[1], -linear[0], linear[2]);
  for (int i = 0; i < 3; ++i) frame[i] = glm::normalize(frame[i]);
  if (Stretches(linear)) {
    AddWarning(
        reader.warnings, parameters.position,
        parameters.directive + ": its transform stretches the map: only the rotation is used");
    const double side = glm::determinant(frame) < 0 ? -1 : 1;
    frame[1] = glm::normalize(frame[1] - frame[2] * glm::dot(frame[1], frame[2]));
    frame[0] = side * glm::cross(frame[1], frame[2]);
  }
  return frame;
}

// Reads the corners of rectangles. As in pbrt-v4 they are points of the world: the transform of the
// light does not move them.
void Portals(PbrtReader& reader, PbrtParameters& parameters) {
  const PbrtParameter* found = Find(parameters, {"point", "point3"}, "portal");
  if (!found) return;
  if (found->floats.size() % 12 != 0 || found->floats.empty()) {
    throw InputError(found->position,
                     fmt::format("{}: \"portal\" takes four points, and has {} numbers",
                                 parameters.directive, found->floats.size()));
  }
  for (std::size_t i = 0; i < found->floats.size(); i += 12) {
    std::array<glm::vec3, 4> corners;
    for (std::size_t k = 0; k < 4; ++k) {
      const float* p = &found->floats[i + 3 * k];
      corners[k] = ScenePlace(reader, glm::dvec3(p[0], p[1], p[2]));
    }
    try {
      reader.scene.portals.push_back(PortalOfCorners(corners));
    } catch (const InputError& error) {
      throw InputError(found->position, parameters.directive + ": " + error.reason());
    }
  }
  if (reader.scene.portals.size() > kMaxPortals) {
    throw InputError(found->position,
                     fmt::format("{}: there are {} portals; at most {} can be used",
                                 parameters.directive, reader.scene.portals.size(), kMaxPortals));
  }
  reader.scene.settings.strategy = "portal";
}

// Returns the illuminance from the upper half of an equal-area square (Clarberg 2008) as pbrt-v4
// counts it: a texel as half of its solid angle.
double IlluminanceFromAbove(const Image& square) {
  double sum = 0;
  for (int y = 0; y < square.height; ++y) {
    for (int x = 0; x < square.width; ++x) {
      const double from_centre =
          std::abs((2 * x + 1.0) / square.width - 1) + std::abs((2 * y + 1.0) / square.height - 1);
      sum += Luminance(square.Pixel(x, y)) * std::max(0.0, 1 - from_centre * from_centre);
    }
  }
  return sum * 2 * kPi / (double(square.width) * square.height);
}

void InfiniteLight(PbrtReader& reader, PbrtParameters& parameters) {
  EnvironmentLight light;
  light.scale = Emission(reader, parameters, "L");
  if (const auto file = FindPbrtLightFile(reader, parameters); file && !file->path.empty()) {
    light.map_path = file->path;
    light.equal_area_square = file->v4;  // v3: lat-long
  }
  if (const auto lux = Strength(parameters, "illuminance")) {
    if (light.map_path.empty()) {
      light.scale *= *lux / float(kPi);
    } else {
      const Image map = ReadImage(light.map_path);
      const double lit = map.width == map.height ? IlluminanceFromAbove(map) : 0;
      if (light.equal_area_square && lit > 0 && std::isfinite(lit)) {
        light.scale *= float(*lux / lit);
      } else {
        AddWarning(reader.warnings, parameters.position,
                   parameters.directive +
                       ": the \"illuminance\" of an image that is not an equal-area square, or is "
                       "black above, is ignored");
      }
    }
  }
  light.world_from_map = MapFrame(reader, parameters);
  Portals(reader, parameters);
  reader.scene.environments.push_back(std::move(light));
}

// The command line sets the number of light samples.
void UseSampleCounts(PbrtParameters& parameters) {
  for (const char* name : {"samples", "nsamples"}) FindInt(parameters, name);
}

double Area(const Mesh& mesh) {
  double area = 0;
  for (const glm::uvec3& t : mesh.triangles) {
    const glm::dvec3 a(mesh.positions[t.x]), b(mesh.positions[t.y]), c(mesh.positions[t.z]);
    area += 0.5 * glm::length(glm::cross(b - a, c - a));
  }
  return area;
}

const CompactImage& ImageOf(const Scene& scene, std::uint32_t texture) {
  return scene.images[scene.textures[texture].image];
}

double MeanLuminance(const CompactImage& image) {
  double sum = 0;
  for (std::size_t i = 0; i < image.values(); ++i) {
    sum += double(kLuminance[i % 3]) * double(image.Value(i));
  }
  return sum / (double(image.values()) / 3);
}

}  // namespace

void ReadPbrtLightSource(PbrtReader& reader, PbrtSource& source, const PbrtToken& word) {
  const InputPosition position = PositionOf(source, word);
  const std::string type = ExpectString(source, "the type of LightSource");
  PbrtParameters parameters = ReadParametersAndAttributes(reader, source, position, "light",
                                                          fmt::format("LightSource \"{}\"", type));
  const bool infinite = type == "infinite" || type == "exinfinite";
  // All that an infinite light takes of a transform is where directions go.
  const auto& flaw = reader.state.flaw;
  if (!(infinite && flaw && flaw->what == "projective") &&
      !CanPlace(reader, position, parameters.directive)) {
    return;
  }
  if (infinite) {
    InfiniteLight(reader, parameters);
  } else if (type == "point") {
    PointLight(reader, parameters);
  } else if (type == "spot") {
    SpotLight(reader, parameters);
  } else if (type == "distant") {
    DistantLight(reader, parameters);
  } else if (type == "goniometric" || type == "projection") {
    type == "projection" ? ProjectionLight(reader, parameters)
                         : GoniometricLight(reader, parameters);
  } else {
    AddWarning(reader.warnings, position, parameters.directive + " is not supported: left out");
    return;
  }
  UseSampleCounts(parameters);
  ReportUnused(parameters, reader.warnings);
}

void ReadPbrtAreaLight(PbrtReader& reader, PbrtSource& source, const PbrtToken& word) {
  const InputPosition position = PositionOf(source, word);
  const std::string type = ExpectString(source, "the type of AreaLightSource");
  PbrtParameters parameters = ReadParametersAndAttributes(
      reader, source, position, "light", fmt::format("AreaLightSource \"{}\"", type));
  if (type != "diffuse" && type != "area") {
    AddWarning(reader.warnings, position, parameters.directive + " is not supported: left out");
    reader.state.area_light.reset();
    return;
  }
  PbrtAreaLight light = {.number = reader.area_lights++};
  light.radiance = Emission(reader, parameters, "L");
  light.two_sided = FindBool(parameters, "twosided").value_or(false);
  light.power = Strength(parameters, "power");
  if (const auto file = FindString(parameters, "filename"); file && !file->empty()) {
    if (Find(parameters, {"rgb", "color", "xyz", "spectrum", "blackbody"}, "L")) {
      throw InputError(position, parameters.directive + " has both \"L\" and an image");
    }
    try {
      const std::string path = ResolvePbrtPath(reader, *file, position);
      Texture texture{.image = AddTextureImage(reader.texture_files, path, Encoding::kSrgb)};
      texture.wrap_u = texture.wrap_v = TextureWrap::kClamp;
      texture.transform = UpwardTextureTransform({1, 1}, {0, 0});
      reader.scene.textures.push_back(texture);
      light.image = std::uint32_t(reader.scene.textures.size() - 1);
    } catch (const InputError& error) {
      WarnOfPbrtLightImage(reader, parameters, error);
    }
  }
  UseSampleCounts(parameters);
  ReportUnused(parameters, reader.warnings);
  reader.state.area_light = light;
}

std::uint32_t ShiningPbrtMaterial(PbrtReader& reader, std::uint32_t plain, const Mesh& mesh,
                                  std::size_t faces, const InputPosition& position) {
  if (!reader.state.area_light) return plain;
  const PbrtAreaLight& light = *reader.state.area_light;
  const auto key = std::pair(plain, light.number);
  const auto known = reader.shining_materials.find(key);
  if (known != reader.shining_materials.end()) return known->second;
  Material material = reader.scene.materials[plain];
  if (material.opacity == 0) {
    // pbrt-v4 treats these shapes specially.
    AddWarning(reader.warnings, position, "a shape of alpha 0 gives no light");
  }
  material.emission = light.radiance;
  material.emission_texture = light.image;
  material.emits_on_both_sides = light.two_sided;
  if (light.power) {
    // The power of an image is that of its mean over the whole shape.
    const double area = Area(mesh) * (light.two_sided ? 2 : 1) *
                        (light.image ? MeanLuminance(ImageOf(reader.scene, *light.image)) : 1.0);
    if (!(area > 0)) {
      throw InputError(position,
                       "an area light with a power needs a shape with an area, and an "
                       "image that is not black");
    }
    material.emission *= float(double(faces) * *light.power / (kPi * area));
  }
  const auto index = std::uint32_t(reader.scene.materials.size());
  reader.scene.materials.push_back(std::move(material));
  // Each face is a light to pbrt and emits the given power whatever its area. Here they are equally
  // bright and emit as much together, so the material is that of this shape alone.
  if (!light.power) reader.shining_materials.emplace(key, index);
  return index;
}

}  // namespace skywave
