#include "cli/job_flags.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "cli/flags.h"
#include "lights/maps/projections.h"
#include "wavefront/photons/photon_map.h"

namespace skywave {
namespace {

bool ParseSize(const std::string& text, int& width, int& height) {
  const std::size_t cross = text.find('x');
  if (cross == std::string::npos) return false;
  const char *begin = text.data(), *middle = begin + cross, *end = begin + text.size();
  const auto w = std::from_chars(begin, middle, width);
  const auto h = std::from_chars(middle + 1, end, height);
  return w.ec == std::errc() && w.ptr == middle && h.ec == std::errc() && h.ptr == end;
}

// X,Y,Z
std::optional<glm::vec3> ParsePoint(const std::string& text) {
  glm::vec3 point;
  const char *next = text.data(), *end = next + text.size();
  for (int i = 0; i < 3; ++i) {
    if (i > 0 && (next == end || *next++ != ',')) return std::nullopt;
    const auto [stop, error] = std::from_chars(next, end, point[i]);
    if (error != std::errc() || !std::isfinite(point[i])) return std::nullopt;
    next = stop;
  }
  return next == end ? std::optional(point) : std::nullopt;
}

// WxH+X+Y
std::optional<CropWindow> ParseCrop(const std::string& text) {
  CropWindow crop;
  int* const values[] = {&crop.width, &crop.height, &crop.x, &crop.y};
  const char separators[] = {'x', '+', '+', 0};
  const char *next = text.data(), *end = next + text.size();
  for (int i = 0; i < 4; ++i) {
    const auto [stop, error] = std::from_chars(next, end, *values[i]);
    if (error != std::errc()) return std::nullopt;
    next = stop;
    if (separators[i] != 0 && (next == end || *next++ != separators[i])) return std::nullopt;
  }
  return next == end ? std::optional(crop) : std::nullopt;
}

// S,T
std::optional<SubpathLengths> ParseSubpathLengths(const std::string& text) {
  SubpathLengths lengths;
  const std::size_t comma = text.find(',');
  if (comma == std::string::npos) return std::nullopt;
  const char *begin = text.data(), *middle = begin + comma, *end = begin + text.size();
  const auto light = std::from_chars(begin, middle, lengths.light);
  const auto eye = std::from_chars(middle + 1, end, lengths.eye);
  const bool whole = light.ptr == middle && eye.ptr == end;
  if (light.ec != std::errc() || eye.ec != std::errc() || !whole) return std::nullopt;
  return lengths;
}

void AddCameraFlags(CLI::App& command, JobRequest& r) {
  const auto group = "Camera";
  CameraRequest& c = r.camera;
  AddParsed(command, "--camera", "kind (default: the scene's, or perspective)",
            "perspective|orthographic|latlong|equal-area|fisheye", c.kind, Parse<CameraKind>);
  AddParsed(command, "--eye", "where it stands", "X,Y,Z", c.eye, ParsePoint);
  AddParsed(command, "--target", "what it looks at (with --eye alone: the middle of the scene)",
            "X,Y,Z", c.target, ParsePoint);
  command
      .add_option("--fov", c.fov_degrees,
                  "of the shorter side of the film [degrees], for a fisheye up to 360")
      ->check(FiniteNumber(0.01, 360));
  command.add_option("--lens-radius", c.lens_radius, "of a thin lens (0: none)")
      ->check(FiniteNumber(0, 1e12));
  command
      .add_option("--focal-distance", c.focal_distance,
                  "of what is sharp (default: the middle of the scene)")
      ->check(FiniteNumber(1e-12, 1e12));
  for (const char* flag :
       {"--camera", "--eye", "--target", "--fov", "--lens-radius", "--focal-distance"}) {
    command.get_option(flag)->group(group);
  }
}

std::string CameraFlags(const CameraRequest& c) {
  std::string text;
  const auto point = [](const glm::vec3& p) { return fmt::format("{},{},{}", p.x, p.y, p.z); };
  if (c.kind) text += fmt::format(" --camera {}", ToString(*c.kind));
  if (c.eye) text += " --eye=" + point(*c.eye);
  if (c.target) text += " --target=" + point(*c.target);
  if (c.fov_degrees) text += fmt::format(" --fov {}", *c.fov_degrees);
  if (c.lens_radius) text += fmt::format(" --lens-radius {}", *c.lens_radius);
  if (c.focal_distance) text += fmt::format(" --focal-distance {}", *c.focal_distance);
  return text;
}

void AddPhotonFlags(CLI::App& command, PhotonOptions& p) {
  const auto group = "Photon mapping, vertex merging (--integrator photon, vcm)";
  const auto add = [&](const char* name, auto& value, const char* help, CLI::Validator check) {
    command.add_option(name, value, help)->check(check)->capture_default_str()->group(group);
  };
  add("--photons", p.indirect,
      "to store for indirect light; vcm: light vertices that a pass keeps at most",
      CLI::Range(0u, kMostPhotons));
  add("--caustic-photons", p.caustic, "to store for light from mirrors and glass",
      CLI::Range(0u, kMostPhotons));
  add("--gather", p.gather, "rays of a final gather a hit; 0: photons are seen directly",
      CLI::Range(0u, 4096u));
  add("--photon-neighbors", p.neighbors, "of a lookup, at most", CLI::Range(2u, 1u << 16));
  add("--photon-distance", p.distance,
      "of a lookup, at most; progressive, vcm: radius of the first pass (0: by the photons)",
      FiniteNumber(0, 1e12));
  AddParsed(command, "--photon-kernel", "weights of a lookup (default: epanechnikov)",
            "constant|cone|epanechnikov", p.kernel, Parse<PhotonKernel>);
  command.get_option("--photon-kernel")->group(group);
  command
      .add_option("--progressive", p.passes,
                  "passes over --spp, each with photons of its own and a smaller radius (default: "
                  "photon 1, vcm one a sample)")
      ->check(CLI::Range(1u, 1u << 20))
      ->group(group);
  add("--progressive-alpha", p.alpha, "of (i + alpha) / (i + 1), by which squared radii shrink",
      FiniteNumber(0.01, 1));
}

std::string PhotonFlags(const RenderOptions& options) {
  const PhotonOptions& p = options.photons;
  const IntegratorDescriptor& integrator = Describe(options.integrator);
  std::string text = fmt::format(" --photons {}", p.indirect);
  if (integrator.stores == StoredLight::kPhotons) {
    text += fmt::format(" --caustic-photons {} --gather {}", p.caustic, p.gather);
  }
  text += fmt::format(" --photon-neighbors {} --photon-distance {} --photon-kernel {}", p.neighbors,
                      p.distance, ToString(p.kernel));
  if (p.passes > 0) text += fmt::format(" --progressive {}", p.passes);
  if (p.progressive() || (integrator.pass_each_sample && p.passes == 0)) {
    text += fmt::format(" --progressive-alpha {}", p.alpha);
  }
  return text;
}

}  // namespace

void AddReadFlags(CLI::App& command, ReadOptions& options) {
  command.add_flag("--strict", options.strict,
                   "refuse a scene of which something would be left out or approximated");
  command
      .add_option("--max-triangles", options.max_triangles,
                  "refuse a scene that grows beyond this by instances or subdivision")
      ->check(CLI::Range(std::uint64_t{1}, std::uint64_t{1} << 31))
      ->capture_default_str();
}

void AddJobFlags(CLI::App& command, JobRequest& r) {
  RenderOptions& o = r.options;
  command.add_option("scene", r.scene, "pbrt, OBJ, glTF or PLY file, or a built-in scene")
      ->required();
  AddReadFlags(command, r.read);

  const auto light = "Light";
  command.add_option("--env", r.environment.path, "illumination map (EXR, Radiance HDR, PFM)")
      ->group(light);
  AddParsed(command, "--env-projection", "how its pixels lie (default: by shape)",
            Choices<Projection>(), r.environment.projection, Parse<Projection>);
  command
      .add_option("--env-rotate", r.environment.rotation_degrees,
                  "turn about the up axis, counter-clockwise from above")
      ->check(FiniteNumber(-1e6, 1e6))
      ->type_name("DEGREES");
  command.add_option("--env-intensity", r.environment.intensity, "factor of its radiance")
      ->check(FiniteNumber(0, 1e12));
  AddParsed(command, "--env-up",
            "up axis of map, ground and automatic camera (default: the scene's)", "x|y|z",
            r.environment.up_axis, [](const std::string& t) -> std::optional<char> {
              if (t == "x" || t == "y" || t == "z") return t[0];
              return std::nullopt;
            });
  command.add_option("--strategy", r.strategy, "where light samples come from: skywave strategies")
      ->capture_default_str();
  command.add_flag("!--no-mis", o.mis, "light samples alone: no multiple importance sampling");
  command.add_flag("--trust-input", r.environment.limits.trust_input,
                   "also decode EXR features with known holes in Debian's OpenEXR");

  AddCameraFlags(command, r);
  command.add_flag("--ground", r.ground, "put a grey plane under the scene");
  command
      .add_option_function<std::string>(
          "--size",
          [&r](const std::string& text) {
            int width = 0, height = 0;
            if (!ParseSize(text, width, height) || width < 1 || height < 1) {
              throw CLI::ValidationError("--size",
                                         "'" + text + "' is not WxH, for example 640x480");
            }
            r.width = width, r.height = height;
          },
          "film [pixels]")
      ->type_name("WxH");
  AddParsed(command, "--crop", "render this part of the film only [pixels]", "WxH+X+Y", r.crop,
            ParseCrop);
  command.add_option("--spp", r.samples_per_pixel, "samples a pixel (default: the scene's, or 64)")
      ->check(CLI::Range(1, 1 << 24));
  AddParsed(command, "--integrator", "what is computed (default: the scene's, or path)",
            Choices<Integrator>(), r.integrator, Parse<Integrator>);
  AddParsed(command, "--paths",
            "bdpt: only paths of S vertices from the light and T from the eye; with --no-mis their "
            "weight is 1",
            "S,T", o.subpath_lengths, ParseSubpathLengths);
  command
      .add_option("--light-samples", o.light_samples,
                  "light samples a hit (direct, photon; path with --split: a first hit)")
      ->check(CLI::Range(1, 1 << 16))
      ->capture_default_str();
  command
      .add_option("--split", o.split,
                  "continuations of a path behind its first hit (path; default: none)")
      ->check(CLI::Range(1, 1 << 16))
      ->type_name("S");
  command.add_option("--continuation-strategy", r.continuation_strategy,
                     "of the light samples behind it (default: --strategy)");
  command
      .add_option("--max-depth", r.max_depth,
                  "surfaces a path scatters at (default: the scene's, or 5)")
      ->check(CLI::Range(0u, kMaxDepth));
  AddParsed(command, "--filter", "pixel filter (default: the scene's, or blackman-harris)",
            "box|triangle|gaussian|blackman-harris", r.filter, Parse<PixelFilter>);
  command.add_option("--filter-radius", o.filter_radius, "[pixels] (default: the filter's own)")
      ->check(FiniteNumber(0, 100));
  // It pays where light has to find its way in, and costs where it finds it anyway.
  command.add_flag("--guide,!--no-guide", o.guide,
                   "light, bdpt, photon, vcm: light paths of a map start where a pilot of camera "
                   "paths has needed them");
  AddPhotonFlags(command, o.photons);
  command.add_option("--seed", o.seed, "of the random numbers")->capture_default_str();

  command.add_option("--threads", o.threads, "0: as many as the process may use")
      ->check(CLI::Range(0, 4096))
      ->capture_default_str();
  command.add_option("--wave", o.wave, "rows of a wave, a multiple of 8")
      ->check(CLI::Range(1, 1 << 20))
      ->capture_default_str();
  AddParsed(command, "--backend", "how rays reach Embree, but for camera rays (default: best)",
            "best|stream|packet|array|single", o.backend, Parse<Backend>);
  command.add_option("--embree-config", r.embree_config, "for rtcNewDevice, for example isa=avx2");
}

std::string SceneFlags(const JobRequest& r, const RenderOptions& o) {
  std::string text = Quoted(r.scene);
  const EnvironmentRequest& e = r.environment;
  if (!e.path.empty()) text += " --env " + Quoted(e.path);
  if (e.projection) {
    text += fmt::format(" --env-projection {}", ToString(*e.projection));
  }
  if (e.rotation_degrees != 0) text += fmt::format(" --env-rotate {}", e.rotation_degrees);
  if (e.intensity != 1) text += fmt::format(" --env-intensity {}", e.intensity);
  if (e.up_axis) text += fmt::format(" --env-up {}", *e.up_axis);
  if (e.limits.trust_input) text += " --trust-input";
  if (r.ground) text += " --ground";
  text += CameraFlags(r.camera);
  const bool cropped = o.film_width > 0;
  text += fmt::format(" --size {}x{} --integrator {}", cropped ? o.film_width : o.width,
                      cropped ? o.film_height : o.height, ToString(o.integrator));
  if (cropped) {
    text += fmt::format(" --crop {}x{}+{}+{}", o.width, o.height, o.crop_x, o.crop_y);
  }
  const IntegratorDescriptor& integrator = Describe(o.integrator);
  if (integrator.light_samples == LightSamples::kRequested || o.split > 0) {
    text += fmt::format(" --light-samples {}", o.light_samples);
  }
  if (integrator.has_photons()) text += PhotonFlags(o);
  if (o.split > 0) text += fmt::format(" --split {}", o.split);
  if (!r.continuation_strategy.empty()) {
    text += " --continuation-strategy " + Quoted(r.continuation_strategy);
  }
  text += fmt::format(" --max-depth {} --filter {} --filter-radius {} --seed {}", o.max_depth,
                      ToString(o.filter), o.filter_radius, o.seed);
  if (o.subpath_lengths)
    text += fmt::format(" --paths {},{}", o.subpath_lengths->light, o.subpath_lengths->eye);
  if (!o.mis) text += " --no-mis";
  if (o.guide && integrator.has_light_paths()) text += " --guide";
  if (!r.embree_config.empty()) text += " --embree-config " + Quoted(r.embree_config);
  return text;
}

std::string RepeatCommand(const JobRequest& request, const RenderOptions& options) {
  const std::string aovs = options.aovs == 0 ? "" : " --aovs " + ToString(options.aovs);
  return fmt::format("skywave render {} --strategy {} --spp {}{}", SceneFlags(request, options),
                     Quoted(request.strategy), options.samples_per_pixel, aovs);
}

}  // namespace skywave
