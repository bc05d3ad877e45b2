// Handles pbrt's directives that describe the rendering; they come before WorldBegin.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <iterator>
#include <map>
#include <string_view>

#include "base/error.h"
#include "scene/pbrt/state.h"

namespace skywave {
namespace {

void Note(PbrtReader& reader, const PbrtParameters& parameters, const std::string& text) {
  AddNote(reader.warnings, parameters.position, parameters.directive + ": " + text);
}

int RequirePositive(const PbrtParameters& parameters, std::string_view name, int value) {
  if (value <= 0) {
    throw InputError(parameters.position,
                     fmt::format("{}: \"{}\" is {}", parameters.directive, name, value));
  }
  return value;
}

// Puts the two ends of an interval in order and cuts off what lies beyond [0, end], as pbrt does.
template <class T>
void OrderAndCut(T end, T& first, T& last) {
  if (first > last) std::swap(first, last);
  first = std::clamp(first, T{0}, end), last = std::clamp(last, T{0}, end);
}

void ReadCrop(PbrtParameters& parameters, RenderSettings& settings) {
  // pbrt-v4 gives [left right top bottom] in pixels. The fractions computed here are rounded up to
  // pixels again.
  if (const PbrtParameter* given = Find(parameters, {"integer"}, "pixelbounds")) {
    const int width = settings.width.value_or(1280), height = settings.height.value_or(720);
    std::vector<int> p = given->ints;
    if (p.size() == 4) OrderAndCut(width, p[0], p[1]), OrderAndCut(height, p[2], p[3]);
    if (p.size() != 4 || p[0] == p[1] || p[2] == p[3]) {
      throw InputError(given->position,
                       fmt::format("{}: \"pixelbounds\" takes left, right, top and bottom on the "
                                   "film of {} x {}, with pixels between them",
                                   parameters.directive, width, height));
    }
    const auto fraction = [](int pixel, int size) {
      return std::max(0.0f, (float(pixel) - 0.25f) / float(size));
    };
    settings.width = width, settings.height = height;
    settings.crop = CropFractions{fraction(p[0], width), fraction(p[1], width),
                                  fraction(p[2], height), fraction(p[3], height)};
  }
  if (const PbrtParameter* given = Find(parameters, {"float"}, "cropwindow")) {
    std::vector<float> c = given->floats;
    if (c.size() == 4) OrderAndCut(1.0f, c[0], c[1]), OrderAndCut(1.0f, c[2], c[3]);
    if (c.size() != 4 || !(c[0] < c[1]) || !(c[2] < c[3])) {
      throw InputError(given->position,
                       fmt::format("{}: \"cropwindow\" takes two different numbers from 0 to 1 for "
                                   "x, and two for y",
                                   parameters.directive));
    }
    settings.crop = CropFractions{c[0], c[1], c[2], c[3]};
  }
}

void ReadFilm(PbrtReader& reader, PbrtSource& source, const PbrtToken& word) {
  auto [type, parameters] = ReadPbrtImplementation(reader, source, word);
  RenderSettings& settings = reader.scene.settings;
  for (auto [name, value] :
       {std::pair("xresolution", &settings.width), std::pair("yresolution", &settings.height)}) {
    if (const auto found = FindInt(parameters, name)) {
      *value = RequirePositive(parameters, name, *found);
    }
  }
  ReadCrop(parameters, settings);
  // The size of the film matters to realistic cameras only, and 16-bit output has no effect here.
  if (const auto diagonal = FindFloat(parameters, "diagonal")) {
    if (!(*diagonal > 0 && *diagonal <= 1e6f)) {
      throw InputError(parameters.position,
                       fmt::format("{}: \"diagonal\" is {} mm", parameters.directive, *diagonal));
    }
    reader.film_diagonal = *diagonal;
  }
  FindBool(parameters, "savefp16");
  if (const auto iso = FindFloat(parameters, "iso")) {
    if (!(*iso > 0 && *iso <= 1e6f)) {
      throw InputError(parameters.position,
                       fmt::format("{}: \"iso\" is {}", parameters.directive, *iso));
    }
    reader.film_gain = *iso / 100;
  }
  // Version 3 multiplies the values that it writes.
  if (const auto scale = reader.v3 ? FindFloat(parameters, "scale") : std::nullopt) {
    if (!(*scale > 0 && *scale <= 1e18f)) {
      throw InputError(parameters.position,
                       fmt::format("{}: \"scale\" is {}", parameters.directive, *scale));
    }
    reader.film_gain = *scale;
  }
  // Version 4 limits what it writes, version 3 what it multiplies.
  const auto read_limit = [&, &parameters = parameters](const char* name, float gain) {
    std::optional<float> limit = FindFloat(parameters, name);
    if (limit && !(*limit > 0)) {
      throw InputError(parameters.position,
                       fmt::format("{}: \"{}\" is {}", parameters.directive, name, *limit));
    }
    // What is beyond all radiances is none.
    if (limit && *limit * gain > 1e12f) limit.reset();
    return limit ? std::optional(std::max(*limit * gain, 1e-12f)) : std::nullopt;
  };
  if (reader.v3) {
    settings.luminance_of_sample = read_limit("maxsampleluminance", reader.film_gain);
  } else {
    settings.largest_of_sample = read_limit("maxcomponentvalue", 1);
  }
  if (const auto sensor = FindString(parameters, "sensor"); sensor && *sensor != "cie1931") {
    Warn(reader, parameters,
         fmt::format("sensor \"{}\" is not supported: cie1931 is used", *sensor));
  }
  if (FindString(parameters, "filename")) {
    Note(reader, parameters, "\"filename\" is ignored: the output is named on the command line");
  }
  if (type != "image" && type != "rgb") Warn(reader, parameters, "only an RGB picture is rendered");
  ReportUnused(parameters, reader.warnings);
}

void ReadSampler(PbrtReader& reader, PbrtSource& source, const PbrtToken& word) {
  auto [type, parameters] = ReadPbrtImplementation(reader, source, word);
  auto& samples = reader.scene.settings.samples_per_pixel;
  if (const auto found = FindInt(parameters, "pixelsamples")) {
    samples = RequirePositive(parameters, "pixelsamples", *found);
  }
  const auto x = FindInt(parameters, "xsamples"), y = FindInt(parameters, "ysamples");
  if (x && y) {
    const std::int64_t product = std::int64_t{RequirePositive(parameters, "xsamples", *x)} *
                                 RequirePositive(parameters, "ysamples", *y);
    samples = static_cast<int>(std::min<std::int64_t>(product, 1 << 30));
  }
  // All other parameters affect the noise only.
  Note(reader, parameters, "only the number of samples is taken; the sampler is Skywave's own");
}

// In stochastic progressive photon mapping, one sample per pixel is an iteration.
void ReadPhotons(PbrtReader& reader, PbrtParameters& parameters) {
  RenderSettings& settings = reader.scene.settings;
  settings.photons_each_sample = true;
  // These are pbrt-v3's names.
  for (const char* const name : {"iterations", "numiterations"}) {
    const auto found = FindInt(parameters, name);
    if (found) settings.samples_per_pixel = RequirePositive(parameters, name, *found);
  }
  if (const auto radius = FindFloat(parameters, "radius")) {
    if (!(*radius > 0)) {
      throw InputError(parameters.position,
                       fmt::format("{}: \"radius\" is {}", parameters.directive, *radius));
    }
    settings.photon_distance = float(*radius);
  }
  if (FindInt(parameters, "photonsperiteration")) {
    Note(reader, parameters, "\"photonsperiteration\" is ignored: --photons says how many");
  }
  if (FindInt(parameters, "imagewritefrequency")) {
    Note(reader, parameters, "\"imagewritefrequency\" is ignored: a picture is written at the end");
  }
}

void ReadIntegrator(PbrtReader& reader, PbrtSource& source, const PbrtToken& word) {
  auto [type, parameters] = ReadPbrtImplementation(reader, source, word);
  RenderSettings& settings = reader.scene.settings;
  static const std::map<std::string_view, const char*> kNames = {
      {"path", "path"},       {"volpath", "path"},
      {"direct", "direct"},   {"directlighting", "direct"},
      {"lightpath", "light"}, {"bdpt", "bdpt"},
      {"sppm", "photon"},     {"whitted", "direct"}};
  const auto known = kNames.find(type);
  settings.integrator = known != kNames.end() ? known->second : "path";
  if (type == "sppm") ReadPhotons(reader, parameters);
  if (const auto depth = FindInt(parameters, "maxdepth")) {
    if (*depth < 0) {
      throw InputError(parameters.position,
                       fmt::format("{}: \"maxdepth\" is {}", parameters.directive, *depth));
    }
    settings.max_depth = *depth;
  }
  for (const char* name : {"lightsampler", "lightsamplestrategy", "strategy", "rrthreshold"}) {
    if (!Find(parameters, {"string", "float"}, name)) continue;
    Note(reader, parameters, fmt::format("\"{}\" is ignored: --strategy chooses lights", name));
  }
  if (known == kNames.end()) {
    Warn(reader, parameters, "is not supported: rendered with path");
    UseAll(parameters);
  }
  ReportUnused(parameters, reader.warnings);
}

// Our Gaussian ends at three standard deviations. Where pbrt's ends later, little is left of it.
void FitGaussian(PbrtReader& reader, PbrtParameters& parameters) {
  // Version 3 gives exp(-alpha x^2), of radius 2 in its parameters' defaults.
  const float alpha = FindFloat(parameters, "alpha").value_or(2);
  const float sigma = FindFloat(parameters, "sigma").value_or(1 / std::sqrt(2 * alpha));
  if (!(sigma > 0)) {
    throw InputError(parameters.position, parameters.directive + ": the width is not positive");
  }
  std::optional<float>& radius = reader.scene.settings.filter_radius;
  radius = radius.value_or(reader.v3 ? 2.0f : 1.5f);
  if (3 * sigma > 1.01f * *radius) {
    Warn(reader, parameters,
         fmt::format("a standard deviation above a third of the radius is not supported: {:.3g} is "
                     "used",
                     *radius / 3));
  } else {
    radius = 3 * sigma;
  }
}

void ReadPixelFilter(PbrtReader& reader, PbrtSource& source, const PbrtToken& word) {
  auto [type, parameters] = ReadPbrtImplementation(reader, source, word);
  RenderSettings& settings = reader.scene.settings;
  settings.filter_radius.reset();
  if (type == "box") {
    settings.filter = PixelFilter::kBox;
  } else if (type == "triangle") {
    settings.filter = PixelFilter::kTriangle;
    settings.filter_radius = 2;
  } else if (type == "gaussian") {
    settings.filter = PixelFilter::kGaussian;
  } else if (type == "mitchell") {
    settings.filter = PixelFilter::kMitchell;
    const auto is_third = [&, &parameters = parameters](const char* name) {
      return std::abs(FindFloat(parameters, name).value_or(1.0f / 3) - 1.0f / 3) < 1e-4f;
    };
    const bool b_fits = is_third("B"), c_fits = is_third("C");  // both are read
    if (!b_fits || !c_fits) {
      Warn(reader, parameters, "B and C other than 1/3 are not supported: 1/3 is used");
    }
  } else if (type == "sinc") {
    settings.filter = PixelFilter::kSinc;
    if (FindFloat(parameters, "tau").value_or(3) != 3) {
      Warn(reader, parameters, "a tau other than 3 is not supported: 3 is used");
    }
  } else {
    Warn(reader, parameters, "is not supported: the default filter is used");
    return;
  }
  // pbrt-v4 and pbrt-v3 use different names for half the width.
  const auto v4_x = FindFloat(parameters, "xradius"), v3_x = FindFloat(parameters, "xwidth");
  const auto v4_y = FindFloat(parameters, "yradius"), v3_y = FindFloat(parameters, "ywidth");
  const auto x = v4_x ? v4_x : v3_x, y = v4_y ? v4_y : v3_y;
  if (x || y) {
    const float radius = std::max(x.value_or(0), y.value_or(0));
    if (!(x.value_or(radius) > 0 && y.value_or(radius) > 0)) {
      throw InputError(parameters.position, parameters.directive + ": the radius is not positive");
    }
    if (x.value_or(radius) != y.value_or(radius)) {
      Warn(reader, parameters, "radii differ: the larger one is used for both axes");
    }
    settings.filter_radius = radius;
  }
  if (settings.filter == PixelFilter::kGaussian) FitGaussian(reader, parameters);
  ReportUnused(parameters, reader.warnings);
}

// An accelerator changes nothing in the picture.
void Accelerator(PbrtReader& reader, PbrtSource& source, const PbrtToken& word) {
  Note(reader, ReadPbrtImplementation(reader, source, word).parameters, "is ignored");
}

void Ignore(PbrtReader& reader, PbrtSource& source, const PbrtToken& word) {
  Warn(reader, ReadPbrtImplementation(reader, source, word).parameters,
       "is not supported: ignored");
}

// pbrt-v4: `Option "name" value`, where the value is one word or string, and names may have
// capitals and underscores.
void ReadOption(PbrtReader& reader, PbrtSource& source, const PbrtToken& word) {
  const std::string given = ExpectString(source, "the name of an Option");
  const PbrtToken value = NextToken(source);
  if (value.kind != PbrtTokenKind::kWord && value.kind != PbrtTokenKind::kString) {
    throw InputError(PositionOf(source, value),
                     fmt::format("Option \"{}\" takes one value, not {}", given, Describe(value)));
  }
  std::string name;
  for (const char c : given) {
    if (c != '_' && c != '-') name += char(std::tolower(static_cast<unsigned char>(c)));
  }
  // Those that change the picture, with the value that does not.
  static constexpr std::pair<std::string_view, std::string_view> kOfThePicture[] = {
      {"disabletexturefiltering", "false"},
      {"forcediffuse", "false"},
      {"displacementedgescale", "1"}};
  static constexpr std::string_view kOthers[] = {"disablepixeljitter", "disablewavelengthjitter",
                                                 "msereferenceimage",  "msereferenceout",
                                                 "rendercoordsys",     "seed",
                                                 "pixelstats",         "wavefront"};
  const auto* const of_picture =
      std::find_if(std::begin(kOfThePicture), std::end(kOfThePicture),
                   [&](const auto& option) { return option.first == name; });
  const bool matters = of_picture != std::end(kOfThePicture);
  const bool known =
      matters || std::find(std::begin(kOthers), std::end(kOthers), name) != std::end(kOthers);
  const std::string what = fmt::format("Option \"{}\" {}", given, value.text);
  if (matters && value.text != of_picture->second) {
    AddWarning(reader.warnings, PositionOf(source, word), what + " is not supported: ignored");
  } else if (!known) {
    AddWarning(reader.warnings, PositionOf(source, word), what + " is unknown: ignored");
  } else {
    AddNote(reader.warnings, PositionOf(source, word), what + " is ignored");
  }
}

void ReadColorSpace(PbrtReader& reader, PbrtSource& source, const PbrtToken& word) {
  const std::string name = ExpectString(source, "the name of a colour space");
  if (name == "srgb") {
    reader.state.color_space.reset();
    return;
  }
  const auto space = FindRgbSpace(name);
  if (!space) {
    throw InputError(
        PositionOf(source, word),
        fmt::format("ColorSpace \"{}\" is unknown: there are srgb, dci-p3, rec2020 and "
                    "aces2065-1",
                    name));
  }
  reader.state.color_space = space;
}

constexpr PbrtDirective kOptionDirectives[] = {
    {"Camera", ReadPbrtCamera},
    {"Film", ReadFilm},
    {"Sampler", ReadSampler},
    {"Integrator", ReadIntegrator},
    {"SurfaceIntegrator", ReadIntegrator},  // pbrt-v2
    {"PixelFilter", ReadPixelFilter},
    {"Accelerator", Accelerator},
    {"VolumeIntegrator", Ignore},  // pbrt-v2
    {"Renderer", Ignore},          // pbrt-v2
    {"Option", ReadOption},
    {"ColorSpace", ReadColorSpace},
};

}  // namespace

PbrtImplementation ReadPbrtImplementation(PbrtReader& reader, PbrtSource& source,
                                          const PbrtToken& word) {
  if (reader.in_world) {
    throw InputError(PositionOf(source, word),
                     fmt::format("{} has to come before WorldBegin", word.text));
  }
  const std::string type = ExpectString(source, fmt::format("the type of {}", word.text));
  return {type, ReadParameters(source, PositionOf(source, word),
                               fmt::format("{} \"{}\"", word.text, type), reader.warnings)};
}

PbrtHandler FindPbrtOptionDirective(std::string_view word) {
  return FindPbrtDirective(kOptionDirectives, word);
}

}  // namespace skywave
