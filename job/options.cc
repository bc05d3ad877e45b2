#include "job/options.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <vector>

#include "base/error.h"
#include "job/resolve.h"
#include "lights/maps/projections.h"
#include "scene/reader.h"
#include "wavefront/film/aovs.h"
#include "wavefront/option_names.h"
#include "wavefront/render_option.h"
#include "wavefront/stages/links.h"

namespace skywave {
namespace {

constexpr OptionScope kInput = OptionScope::kInput, kPixels = OptionScope::kPixels,
                      kSpeed = OptionScope::kSpeed;
constexpr std::string_view kLight = "Light", kCamera = "Camera", kMaterials = "Materials",
                           kComposites = "Composites", kFilm = "Film", kPaths = "Paths",
                           kReading = "Reading", kSpeedGroup = "Speed";

// `count` numbers with the character `separators[i]` after number i; 0: the text ends.
template <class Number>
bool ParseTuple(const std::string& text, const char* separators, int count, Number* values) {
  const char *next = text.data(), *const end = next + text.size();
  for (int i = 0; i < count; ++i) {
    const auto [stop, error] = std::from_chars(next, end, values[i]);
    if (error != std::errc()) return false;
    next = stop;
    if (separators[i] != 0 && (next == end || *next++ != separators[i])) return false;
  }
  return next == end;
}

template <class Point>
Codec<Point> Points() {
  return {.values = "X,Y,Z, for example 0,1.5,-3",
          .metavar = "X,Y,Z",
          .parse = [](const std::string& text) -> std::optional<Point> {
            typename Point::value_type p[3];
            if (!ParseTuple(text, ",,", 3, p)) return std::nullopt;
            for (const auto x : p) {
              if (!std::isfinite(float(x))) return std::nullopt;
            }
            return Point(p[0], p[1], p[2]);
          },
          .print = [](const Point& p) { return fmt::format("{},{},{}", p.x, p.y, p.z); }};
}

Codec<DomeRequest> Domes() {
  return {.values = "HEIGHT above 0, or HEIGHT,RADIUS with a larger radius",
          .metavar = "HEIGHT[,RADIUS]",
          .parse = [](const std::string& text) -> std::optional<DomeRequest> {
            DomeRequest dome;
            float both[2];
            if (ParseTuple(text, ",", 2, both)) {
              dome = {both[0], both[1]};
              if (!std::isfinite(dome.radius)) return std::nullopt;
            } else if (!ParseTuple(text, "", 1, &dome.height)) {
              return std::nullopt;
            }
            const bool is_dome = dome.height > 0 && dome.height < dome.radius;
            return is_dome ? std::optional(dome) : std::nullopt;
          },
          .print =
              [](const DomeRequest& dome) {
                return std::isfinite(dome.radius) ? fmt::format("{},{}", dome.height, dome.radius)
                                                  : fmt::format("{}", dome.height);
              }};
}

Codec<char> Axes() {
  return {.values = "x|y|z",
          .metavar = "x|y|z",
          .parse = [](const std::string& text) -> std::optional<char> {
            if (text == "x" || text == "y" || text == "z") return text[0];
            return std::nullopt;
          },
          .print = [](const char& axis) { return std::string(1, axis); }};
}

Codec<AovSet> Layers() {
  return {.values = "all, denoiser, nor names separated by commas out of " +
                    ToString(AllAovs() | AovsOf(AovSum::kMatte)),
          .metavar = "all|NAME,NAME...",
          .parse = [](const std::string& text) { return ParseAovs(text); },
          .print = [](const AovSet& aovs) { return aovs == 0 ? std::string() : ToString(aovs); }};
}

// The reference has the names of all calls into Embree; those that the linked version lacks are
// refused.
Codec<Backend> Backends() {
  Codec<Backend> codec = NamesOfEnum<Backend>();
  codec.values = ToString(Backend::kBest);
  for (const Backend backend : kBackends) codec.values += fmt::format("|{}", ToString(backend));
  codec.parse = [](const std::string& text) {
    const std::optional<Backend> backend = Parse<Backend>(text);
    return backend && IsAvailable(*backend) ? backend : std::nullopt;
  };
  return codec;
}

Codec<Ground> Grounds() {
  return {.values = "true|false|catcher",
          .metavar = "",
          .parse = [](const std::string& text) -> std::optional<Ground> {
            if (text == "catcher") return Ground::kCatcher;
            const std::optional<bool> on = Switches().parse(text);
            if (!on) return std::nullopt;
            return *on ? Ground::kGrey : Ground::kNone;
          },
          .print =
              [](const Ground& ground) {
                if (ground == Ground::kCatcher) return std::string("catcher");
                return Switches().print(ground == Ground::kGrey);
              },
          .is_switch = true};
}

Codec<Denoiser> Denoisers() {
  return {.values = std::string("true|false|") + kDenoiserWords,
          .metavar = "",
          .parse = [](const std::string& text) -> std::optional<Denoiser> {
            if (text != "none") {
              if (const std::optional<Denoiser> by = Parse<Denoiser>(text)) return by;
            }
            const std::optional<bool> on = Switches().parse(text);
            if (!on) return std::nullopt;
            return *on ? Denoiser::kStatistics : Denoiser::kNone;
          },
          .print =
              [](const Denoiser& by) {
                if (by > Denoiser::kStatistics) return std::string(ToString(by));
                return Switches().print(by == Denoiser::kStatistics);
              },
          .is_switch = true};
}

// Both sides of the film are one option and two fields.
OptionOf<JobRequest> SizeOption(OptionInfo info) {
  info.values = "WxH, for example 640x480";
  info.value_name = "WxH";
  info.printed_default = fmt::format("{}x{}", RenderOptions().width, RenderOptions().height);
  OptionOf<JobRequest> option = {info, {}, {}};
  option.set = [values = info.values](JobRequest& r, const std::vector<std::string>& texts) {
    int side[2];
    if (!ParseTuple(texts.front(), "x", 2, side) || side[0] < 1 || side[1] < 1) {
      return NotAValue(texts.front(), values);
    }
    r.width = side[0], r.height = side[1];
    return std::string();
  };
  option.get = [](const JobRequest& r) {
    return r.width && r.height ? std::vector{fmt::format("{}x{}", *r.width, *r.height)}
                               : std::vector<std::string>();
  };
  return option;
}

// An option that scene files cannot set.
template <class Field, class Value>
JobOption Plain(const OptionInfo& info, Field field, const Codec<Value>& codec) {
  return {MakeOption<JobRequest>(info, field, codec), nullptr};
}

// An option that the scene file gives where the request does not. Requests, settings of scene files
// and RenderOptions have the same name for it, which `field` finds in each.
template <class Field, class Value>
JobOption FromScene(OptionInfo info, Field field, const Codec<Value>& codec) {
  info.scene_may_set = true;
  JobOption option = {MakeOption<JobRequest>(info, field, codec), nullptr};
  option.printed_default = codec.print(field(static_cast<const RenderOptions&>(RenderOptions())));
  option.resolve = [field](JobRequest& request, const SceneDefaults& scene) {
    auto& value = field(request.options);
    using Type = std::remove_cvref_t<decltype(value)>;
    if (const auto& of_scene = field(scene.settings)) value = static_cast<Type>(*of_scene);
    if (const auto& of_request = field(request)) value = static_cast<Type>(*of_request);
    field(request) = value;
  };
  return option;
}

JobOption Resolved(OptionOf<JobRequest> option,
                   void (*resolve)(JobRequest&, const SceneDefaults&)) {
  option.scene_may_set = true;
  return {std::move(option), resolve};
}

// An option of an integrator or of a policy.
JobOption OfJob(const RenderOption& own) {
  JobOption option = {{static_cast<const OptionInfo&>(own), {}, {}}, {}};
  option.set = [set = own.set](JobRequest& request, const std::vector<std::string>& texts) {
    return set(request.options, texts);
  };
  option.get = [get = own.get](const JobRequest& request) { return get(request.options); };
  if (own.resolve != nullptr) {
    option.resolve = [resolve = own.resolve](JobRequest& request, const SceneDefaults& scene) {
      resolve(request.options, scene.settings);
    };
  }
  return option;
}

bool Splits(Integrator integrator) { return Takes(integrator, "split"); }
bool ContinuesPaths(Integrator integrator) {
  return Splits(integrator) && !Describe(integrator).direct_light_only;
}
bool TakesLightSamples(Integrator integrator) {
  const IntegratorDescriptor& descriptor = Describe(integrator);
  return descriptor.light_samples == LightSamples::kRequested || Splits(integrator);
}

// Light paths leave one light each.
bool SelectsLights(Integrator integrator) {
  const IntegratorDescriptor& descriptor = Describe(integrator);
  return descriptor.light_samples != LightSamples::kNone && !descriptor.has_light_paths();
}

std::string_view SceneHelp() {
  static const std::string help = "file that ends in " + SceneEndings() + ", or a built-in scene";
  return help;
}

#define FIELD SKYWAVE_FIELD

// One line an option. Help texts are half sentences; defaults are added to them.
std::vector<JobOption> CommonRows() {
  // clang-format off
  return {
    Plain({.name = "scene", .help = SceneHelp(), .scope = kInput, .example = "scene.pbrt", .positional = true, .required = true, .of_file = true},
          FIELD(scene), Texts("SCENE")),
    Plain({.name = "env", .help = "illumination map (EXR, or a layer of it as FILE:LAYER, Radiance HDR, PFM); #### in its name stands for the number of --frame", .scope = kInput, .example = "--env map.exr", .of_file = true},
          FIELD(environment.path), Texts("MAP")),
    Resolved(SizeOption({.name = "size", .help = "size of the film [pixels]", .scope = kPixels, .example = "--size 9x7"}), ResolveSize),
    FromScene({.name = "spp", .help = "samples per pixel", .scope = kPixels, .example = "--spp 3"},
          FIELD(samples_per_pixel), Numbers(1u, 1u << 24)),
    Resolved(MakeOption<JobRequest>({.name = "integrator", .help = "how light is computed", .scope = kPixels, .example = "--integrator direct", .default_text = "path"},
          FIELD(integrator), NamesOfEnum<Integrator>()), ResolveIntegrator),
    Resolved(MakeOption<JobRequest>({.name = "strategy", .help = "where light samples come from (skywave strategies lists them)", .scope = kPixels, .example = "--strategy importance:compensate=1", .default_text = "importance; with portals, portal", .metavar = "NAME[:KEY=VALUE,...]"},
          FIELD(strategy), Unless(std::string(), Texts("a strategy"))), ResolveStrategy),
    Plain({.name = "portal", .group = kLight, .help = "opening through which the light of the map comes in, for --strategy portal: the corners of a rectangle, counter-clockwise for those inside, or the name of a mesh of rectangles, which is not rendered then; several are separated by ;", .scope = kPixels, .changes = Tables::kPrepared | Tables::kTriangles, .example = "room --portal=-2,0.9,0.9,-2,0.9,-0.5,-2,2.1,-0.5,-2,2.1,0.9", .default_text = "the scene's", .metavar = "CORNERS|MESH", .most_values = 1000, .delimiter = ';'},
          FIELD(portals), Texts("X,Y,Z of four corners, or the name of a mesh")),
    Plain({.name = "aovs", .help = "layers of the EXR in addition to the picture (see below)", .scope = kPixels, .example = "--aovs albedo,depth"},
          FIELD(options.aovs), Layers()),
    Plain({.name = "denoise", .help = "denoise the picture by the statistics of its samples, or, followed by the word oidn, by Open Image Denoise, quick, the same without its error in a third of the time, best, by a mean of both that is weighted by their errors, or auto, by both if it is installed; the EXR has the estimated error as a layer and, with --aovs denoiser, the noisy picture", .scope = kPixels, .example = "--denoise --spp 8", .words = kDenoiserWords},
          FIELD(denoise), Denoisers()),
    Plain({.name = "threads", .help = "0: as many as the process may use", .scope = kSpeed, .example = "--threads 1", .in_suite = true},
          FIELD(options.threads), Numbers(0, 4096)),

    Plain({.name = "env-projection", .group = kLight, .help = "projection of the map", .scope = kPixels, .changes = Tables::kMap | Tables::kSceneLights, .example = "--env map.exr --env-projection latlong", .default_text = "by its shape", .metavar = "NAME"},
          FIELD(environment.projection), NamesOfEnum<Projection>()),
    Plain({.name = "env-rotate", .group = kLight, .help = "turn about the up axis, counter-clockwise seen from above", .scope = kPixels, .changes = Tables::kSceneLights, .example = "--env-rotate 31.7", .metavar = "DEGREES"},
          FIELD(environment.rotation_degrees), Numbers(-1e6f, 1e6f)),
    Plain({.name = "env-intensity", .group = kLight, .help = "factor of the map's radiance", .scope = kPixels, .changes = Tables::kMap | Tables::kSceneLights, .example = "--env-intensity 0.3"},
          FIELD(environment.intensity), Numbers(0.0f, 1e12f)),
    Plain({.name = "env-up", .group = kLight, .help = "up axis of map, ground and automatic camera", .scope = kPixels, .changes = Tables::kPrepared | Tables::kTriangles, .example = "--env map.exr --env-up z", .default_text = "the scene's"},
          FIELD(environment.up_axis), Axes()),
    Plain({.name = "mis", .group = kLight, .help = "combine light and BSDF samples by multiple importance sampling; without: light samples alone", .scope = kPixels, .example = "--no-mis"},
          FIELD(options.mis), Switches()),
    Plain({.name = "light-samples", .group = kLight, .help = "light samples per hit (path: of the first hit, with --split)", .scope = kPixels, .example = "--integrator direct --light-samples 3", .applies = TakesLightSamples},
          FIELD(options.light_samples), Numbers(1u, 1u << 16)),

    Plain({.name = "light-selection", .group = kLight, .help = "lights that a surface takes samples of: by power; one with all equally likely; by a tree, which asks at each surface what a lamp brings there (many lamps); or all, a sample of each local light beside those of the map", .scope = kPixels, .example = "lamps --light-selection all", .applies = SelectsLights},
          FIELD(options.light_selection), NamesOfEnum<LightSelection>()),

    Plain({.name = "link", .group = kLight, .help = "surfaces on which a light shines, or with ! those on which it does not: lights have the names of their layers (--aovs lights), surfaces those of materials or meshes; several are separated by ;", .scope = kPixels, .changes = Tables::kPrepared, .example = "--ground --link 'environment:!ground'", .default_text = "all", .metavar = "LIGHT:[!]NAME,NAME...", .most_values = kMostLinks, .delimiter = ';'},
          FIELD(links), Texts("LIGHT:[!]NAME,NAME...")),
    Plain({.name = "shadow-link", .group = kLight, .help = "surfaces that throw shadows of a light, or with ! those that throw none", .scope = kPixels, .changes = Tables::kPrepared, .example = "--ground --shadow-link 'environment:ground'", .default_text = "all", .metavar = "LIGHT:[!]NAME,NAME...", .most_values = kMostLinks, .delimiter = ';'},
          FIELD(shadow_links), Texts("LIGHT:[!]NAME,NAME...")),
    Plain({.name = "sky-patches", .group = kLight, .help = "keep the light of each patch of the sky apart, as layers lights-sky-000 (the ground) and so on: 145 of Tregenza's or 577 of Reinhart's", .scope = kPixels, .example = "--sky-patches tregenza --size 9x7"},
          FIELD(sky_patches), NamesOfEnum<SkyDivision>()),

    Plain({.name = "camera", .group = kCamera, .help = "kind of camera; realistic: only that of a scene that has a lens file", .scope = kPixels, .example = "--camera orthographic", .default_text = "the scene's, or perspective"},
          FIELD(camera.kind), NamesOfEnum<CameraKind>()),
    Plain({.name = "eye", .group = kCamera, .help = "position", .scope = kPixels, .example = "--eye=-1.5,2,3", .default_text = "the scene's, or one that sees all of it"},
          FIELD(camera.eye), Points<glm::dvec3>()),
    Plain({.name = "target", .group = kCamera, .help = "point that the camera looks at", .scope = kPixels, .example = "--target 0.1,0.2,-0.3", .default_text = "with --eye: the middle of the scene"},
          FIELD(camera.target), Points<glm::dvec3>()),
    Plain({.name = "up", .group = kCamera, .help = "direction that is up in the picture", .scope = kPixels, .example = "--up 0.3,1,0.1", .default_text = "the scene's up axis; looking along that, its middle of the map"},
          FIELD(camera.up), Points<glm::vec3>()),
    Plain({.name = "roll", .group = kCamera, .help = "turn of the camera about its view, clockwise as it looks", .scope = kPixels, .example = "--roll 12.5", .default_text = "0", .metavar = "DEGREES"},
          FIELD(camera.roll_degrees), Floats(-1e6, 1e6)),
    Plain({.name = "fov", .group = kCamera, .help = "field of view across the shorter side of the film, for a fisheye up to 360", .scope = kPixels, .example = "--fov 31.5", .default_text = "the scene's", .metavar = "DEGREES"},
          FIELD(camera.fov_degrees), Floats(0.01, 360)),
    Plain({.name = "lens-radius", .group = kCamera, .help = "radius of a thin lens; 0: none", .scope = kPixels, .example = "--lens-radius 0.1", .default_text = "the scene's"},
          FIELD(camera.lens_radius), Floats(0, 1e12)),
    Plain({.name = "focal-distance", .group = kCamera, .help = "distance in focus", .scope = kPixels, .example = "--lens-radius 0.1 --focal-distance 2.25", .default_text = "the middle of the scene"},
          FIELD(camera.focal_distance), Floats(1e-12, 1e12)),
    Plain({.name = "camera-from", .group = kCamera, .help = "camera that took a photograph: transforms.json of NeRF data, images.txt of COLMAP with cameras.txt beside it, or JSON with K, R and t of OpenCV; the film has the size of the photograph unless --size is given", .scope = kInput, .example = "--camera-from camera.json", .default_text = "the scene's", .metavar = "FILE", .of_file = true},
          FIELD(camera.from), Texts("a file of cameras")),
    Plain({.name = "scene-camera", .group = kCamera, .help = "name of one of the scene's cameras (skywave info lists them), or of a photograph of --camera-from", .scope = kPixels, .example = "moving.gltf --scene-camera side", .default_text = "its first one", .metavar = "NAME"},
          FIELD(camera.name), Texts("the name of a camera")),
    Plain({.name = "orbit", .group = kCamera, .help = "turn of the camera about the up axis through --target or the middle of the scene, counter-clockwise seen from above, after all other changes", .scope = kPixels, .example = "--orbit 120.5", .default_text = "0", .metavar = "DEGREES"},
          FIELD(camera.orbit_degrees), Floats(-1e6, 1e6)),
    Plain({.name = "orbit-step", .group = kCamera, .help = "turn of --orbit from frame to frame of a turntable, for --aovs flow,flow-back", .scope = kPixels, .example = "--orbit-step 2", .default_text = "0", .metavar = "DEGREES"},
          FIELD(camera.orbit_step), Floats(-360, 360)),
    Plain({.name = "ground", .group = kCamera, .help = "put a grey plane under the scene; followed by the word catcher, the plane is one (see --catcher)", .scope = kPixels, .changes = Tables::kPrepared | Tables::kTriangles, .example = "--ground catcher", .words = "catcher"},
          FIELD(ground), Grounds()),

    Plain({.name = "material", .group = kMaterials, .help = "give the material NAME another BSDF with these parameters, or without a BSDF only other parameters (KEY=1 or KEY=0.8/0.2/0.1); several are separated by ;", .scope = kPixels, .changes = Tables::kPrepared, .example = "moving.gltf --material 'paint=conductor:alpha=0.2,reflectance=0.9/0.5/0.1;steel=:alpha=0.4'", .default_text = "the scene's", .metavar = "NAME=[BSDF][:KEY=VALUE,...]", .most_values = 1000, .delimiter = ';'},
          FIELD(materials), Texts("NAME=[BSDF][:KEY=VALUE,...]")),
    Plain({.name = "energy-compensation", .group = kMaterials, .help = "rough conductors and rough glass keep the light that their facets scatter more than once; without: they lose it, as in other programs", .scope = kPixels, .changes = Tables::kPrepared, .example = "materials --no-energy-compensation"},
          FIELD(energy_compensation), Switches()),

    Plain({.name = "catcher", .group = kComposites, .help = "materials or meshes that a photograph shows already: of them only the shadows, reflections and colours of all else are seen, for compositing", .scope = kPixels, .changes = Tables::kPrepared, .example = "--ground --catcher ground", .default_text = "none", .metavar = "NAME,NAME...", .most_values = 1000, .delimiter = ','},
          FIELD(catchers), Texts("the name of a material or a mesh")),
    Plain({.name = "holdout", .group = kComposites, .help = "materials or meshes that cut holes: where the camera sees them first, the picture is empty, and elsewhere they stop and reflect light as ever", .scope = kPixels, .changes = Tables::kPrepared, .example = "--ground --holdout ground", .default_text = "none", .metavar = "NAME,NAME...", .most_values = 1000, .delimiter = ','},
          FIELD(holdouts), Texts("the name of a material or a mesh")),
    Plain({.name = "background", .group = kComposites, .help = "what is behind the scene: the map, or nothing, for an EXR and a PNG with alpha", .scope = kPixels, .example = "--background transparent", .default_text = "map; transparent with --catcher, --holdout, --backplate and --dome"},
          FIELD(background), NamesOfEnum<Background>()),
    Plain({.name = "backplate", .group = kComposites, .help = "photograph behind the scene, scaled to cover the film: the PNG and the layer composite show the picture over it", .scope = kInput, .example = "--backplate map.exr", .default_text = "none", .metavar = "FILE", .of_file = true},
          FIELD(backplate), Texts("a picture")),
    Plain({.name = "dome", .group = kComposites, .help = "the map was taken at HEIGHT above the ground, which is the lowest level of the scene, inside a sphere of RADIUS: the PNG and the layer composite show the picture over the map on both", .scope = kPixels, .example = "--ground catcher --dome 1.6,20", .default_text = "none", .metavar = "HEIGHT[,RADIUS]"},
          FIELD(dome), Domes()),
    Plain({.name = "project", .group = kComposites, .help = "what colours catchers: the backplate from the camera, or the map on the ground of --dome; a matt catcher without objects then looks like that", .scope = kPixels, .example = "--ground catcher --backplate map.exr --project camera", .default_text = "dome with --dome, else none"},
          FIELD(project), NamesOfEnum<Projected>()),

    Resolved(MakeOption<JobRequest>({.name = "crop", .group = kFilm, .help = "render this part of the film only [pixels]", .scope = kPixels, .example = "--size 12x9 --crop 7x5+2+3", .default_text = "all of it"},
          FIELD(crop), Crops()), ResolveCrop),
    Resolved(MakeOption<JobRequest>({.name = "filter", .group = kFilm, .help = "pixel filter", .scope = kPixels, .example = "--filter gaussian", .default_text = "blackman-harris"},
          FIELD(filter), NamesOfEnum<PixelFilter>()), ResolveFilter),
    Resolved(MakeOption<JobRequest>({.name = "filter-radius", .group = kFilm, .help = "radius of the filter [pixels]; 0: the filter's own", .scope = kPixels, .example = "--filter-radius 0.7", .default_text = "the filter's own"},
          FIELD(options.filter_radius), Floats(0, 100)), nullptr),
    Plain({.name = "working-space", .group = kFilm, .help = "space of red, green and blue in which light is computed and the EXR written; files of other spaces are converted to it, and the PNG from it", .scope = kPixels, .changes = Tables::kPrepared | Tables::kMap | Tables::kSceneLights, .example = "--working-space acescg"},
          FIELD(working_space), NamesOfEnum<RgbSpace>()),
    Plain({.name = "seed", .group = kFilm, .help = "seed of the random numbers", .scope = kPixels, .example = "--seed 77", .in_suite = true},
          FIELD(options.seed), Numbers(0u, 0xFFFFFFFFu)),
    Plain({.name = "coherent-noise", .group = kFilm, .help = "the same noise in all frames; without: --frame decides it together with --seed", .scope = kPixels, .example = "--frame 3 --coherent-noise"},
          FIELD(coherent_noise), Switches()),

    FromScene({.name = "max-depth", .group = kPaths, .help = "largest number of surfaces at which a path scatters", .scope = kPixels, .example = "--max-depth 2"},
          FIELD(max_depth), Numbers(0u, kMaxDepth)),
    Plain({.name = "continuation-strategy", .group = kPaths, .help = "strategy of the light samples after the split", .scope = kPixels, .example = "--split 2 --continuation-strategy uniform", .default_text = "that of --strategy", .metavar = "NAME[:KEY=VALUE,...]", .applies = ContinuesPaths},
          FIELD(continuation_strategy), Texts("a strategy")),
  };
  // clang-format on
}

// How scenes are read, and how fast pictures are rendered.
std::vector<JobOption> ReadingRows() {
  // clang-format off
  return {
    Plain({.name = "strict", .group = kReading, .help = "refuse a scene of which something would be left out or approximated", .scope = kInput, .example = "--strict", .of_reading = true},
          FIELD(read.strict), Switches()),
    Plain({.name = "missing", .group = kReading, .help = "what becomes of a scene that names textures, images of lights, material libraries or meshes that are missing or cannot be read: they are left out with a warning, or the scene is refused", .scope = kInput, .example = "--missing refuse", .default_text = "skip", .of_reading = true},
          FIELD(read.missing), NamesOfEnum<MissingFiles>()),
    Plain({.name = "vertex-colors", .group = kReading, .help = "whether colours of vertices are factors of the surface's", .scope = kPixels, .example = "--vertex-colors off", .default_text = "on", .of_reading = true},
          FIELD(read.vertex_colors), NamesOfEnum<VertexColors>()),
    Plain({.name = "point-size", .group = kReading, .help = "diameter of the spheres and tubes that show points and lines of PLY, OBJ and glTF, in units of their mesh", .scope = kPixels, .example = "moving.gltf --point-size 0.2", .default_text = "they are left out", .metavar = "D", .of_reading = true},
          FIELD(read.point_size), Floats(1e-12, 1e12)),
    Plain({.name = "max-triangles", .group = kReading, .help = "refuse a scene that grows beyond this by copies of instances or by subdivision", .scope = kInput, .example = "--max-triangles 1000", .of_reading = true},
          FIELD(read.max_triangles), As<std::size_t>(WholeNumbers(1, std::uint64_t{1} << 31))),
    Plain({.name = "instances", .group = kReading, .help = "whether objects that a scene has more than once are copied, or shared by their instances, which takes less memory and more time", .scope = kPixels, .example = "--instances share", .default_text = "auto: shared where copies would take 256 MB more", .of_reading = true},
          FIELD(read.instances), NamesOfEnum<InstanceUse>()),
    Plain({.name = "frame", .group = kReading, .help = "number of the frame: the moment at which an animated scene is read, which may be a fraction, the map of a sequence, and noise of its own", .scope = kPixels, .example = "moving.gltf --frame 12.5", .default_text = "without animation", .metavar = "N", .of_reading = true},
          FIELD(read.frame), Doubles(-1e9, 1e9)),
    Plain({.name = "fps", .group = kReading, .help = "frames in a second of animation", .scope = kPixels, .example = "moving.gltf --frame 15 --fps 30", .default_text = "24", .metavar = "R", .of_reading = true},
          FIELD(read.fps), Doubles(1e-3, 1e6)),
    Plain({.name = "animation", .group = kReading, .help = "play only this animation (skywave info lists them)", .scope = kPixels, .example = "moving.gltf --animation slide --frame 12", .default_text = "all", .metavar = "NAME", .of_reading = true},
          FIELD(read.animation), Texts("the name of an animation")),
    Plain({.name = "variant", .group = kReading, .help = "variant of the materials (KHR_materials_variants; skywave info lists them)", .scope = kPixels, .example = "moving.gltf --variant worn", .default_text = "the materials of the file", .metavar = "NAME", .of_reading = true},
          FIELD(read.variant), Texts("the name of a variant")),
    Plain({.name = "gltf-scene", .group = kReading, .help = "scene of a glTF file that has several, by its name or its number from 0 on (skywave info lists them)", .scope = kPixels, .example = "moving.gltf --gltf-scene other", .default_text = "the file's", .metavar = "NAME", .of_reading = true},
          FIELD(read.scene), Texts("the name or the number of a scene")),
    Plain({.name = "trust-input", .group = kReading, .help = "decode rare kinds of EXR in this process, not in a confined one", .scope = kInput, .changes = Tables::kMap | Tables::kSceneLights, .example = "--trust-input"},
          FIELD(environment.limits.trust_input), Switches()),

    Plain({.name = "wave", .group = kSpeedGroup, .help = "rows of a wave, rounded up to whole beams of 8", .scope = kSpeed, .example = "--wave 64", .in_suite = true},
          FIELD(options.wave), Numbers(1u, 1u << 20)),
    Plain({.name = "backend", .group = kSpeedGroup, .help = "how rays other than camera rays reach Embree; stream: Embree 3 only", .scope = kSpeed, .example = "--backend single", .in_suite = true},
          FIELD(options.backend), Backends()),
    // Other instruction sets find hits with other bits.
    Plain({.name = "embree-config", .group = kSpeedGroup, .help = "configuration of rtcNewDevice, for example isa=avx2", .scope = kPixels, .changes = Tables::kBvh, .example = "--embree-config isa=sse2", .in_suite = true},
          FIELD(embree_config), Texts("KEY=VALUE,...")),
  };
  // clang-format on
}

#undef FIELD

// All rows, those of a group together: groups come in the order in which they are first seen.
std::vector<JobOption> MakeJobOptions() {
  std::vector<JobOption> options = CommonRows();
  for (const RenderOption& own : RenderOptionTable()) options.push_back(OfJob(own));
  for (JobOption& option : ReadingRows()) options.push_back(std::move(option));
  std::vector<std::string_view> groups;
  const auto rank = [&](const JobOption& option) {
    return std::find(groups.begin(), groups.end(), option.group) - groups.begin();
  };
  for (const JobOption& option : options) {
    if (rank(option) == std::ssize(groups)) groups.push_back(option.group);
  }
  std::stable_sort(options.begin(), options.end(),
                   [&](const JobOption& a, const JobOption& b) { return rank(a) < rank(b); });
  return options;
}

}  // namespace

Codec<CropWindow> Crops() {
  return {.values = "WxH+X+Y, for example 64x64+320+200",
          .metavar = "WxH+X+Y",
          .parse = [](const std::string& text) -> std::optional<CropWindow> {
            int v[4];
            if (!ParseTuple(text, "x++", 4, v)) return std::nullopt;
            return CropWindow{.x = v[2], .y = v[3], .width = v[0], .height = v[1]};
          },
          .print =
              [](const CropWindow& c) {
                return fmt::format("{}x{}+{}+{}", c.width, c.height, c.x, c.y);
              }};
}

std::span<const JobOption> JobOptions() {
  static const std::vector<JobOption> options = MakeJobOptions();
  return options;
}

JobRequest ResolveRequest(JobRequest request, const RenderSettings& settings,
                          std::vector<std::string>& notes) {
  const std::string scene = request.scene;
  const bool chooses_filter = request.filter.has_value();
  for (const JobOption& option : JobOptions()) {
    if (option.resolve) option.resolve(request, {settings, scene});
  }
  LimitDepth(request, notes);
  NoteUselessGuide(request, notes);
  if (!chooses_filter) NoteOtherFilter(request, {settings, scene}, notes);
  NoteUnknownLimits(request, {settings, scene}, notes);
  CheckResolved(request);
  return request;
}

std::vector<RecordedOption> RecordedOptions(const JobRequest& resolved) {
  const Integrator integrator = resolved.integrator.value_or(resolved.options.integrator);
  static const JobRequest defaults;
  std::vector<RecordedOption> recorded;
  for (const JobOption& option : JobOptions()) {
    const bool applies = option.applies == nullptr || option.applies(integrator);
    // What changes pixels is printed even where it has its default, which may change one day.
    const bool decides =
        option.scope == OptionScope::kPixels ||
        (option.scope == OptionScope::kInput && option.get(resolved) != option.get(defaults));
    if (!applies || !decides) continue;
    recorded.push_back({.name = std::string(option.name),
                        .words = CommandWords(option, resolved),
                        .is_input = option.scope == OptionScope::kInput});
  }
  return recorded;
}

std::string PictureOptions(const JobRequest& resolved, std::span<const std::string_view> without) {
  std::string words;
  for (const RecordedOption& option : RecordedOptions(resolved)) {
    if (std::find(without.begin(), without.end(), option.name) == without.end()) {
      words += option.words;
    }
  }
  return words;
}

}  // namespace skywave
