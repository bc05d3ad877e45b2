#include "job/resolve.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "job/denoise/denoise.h"
#include "scene/warnings.h"
#include "wavefront/film/aovs.h"
#include "wavefront/option_checks.h"
#include "wavefront/option_names.h"
#include "wavefront/policies/emission_pilot.h"
#include "wavefront/render_option.h"

namespace skywave {
namespace {

// Kernels find rows and columns of pixels by float arithmetic that is exact up to these.
constexpr int kMaxFilmSide = 32768;
constexpr std::int64_t kMaxFilmPixels = std::int64_t{1} << 28;

// The window that a scene file gives as fractions of a film of `width` x `height` pixels. As in
// pbrt the product is rounded to a float before it is rounded up, so that a tenth of 160 is 16.
CropWindow PixelsOf(const CropFractions& crop, int width, int height) {
  const auto pixel = [](float fraction, int size) {
    return int(std::ceil(fraction * float(size)));
  };
  const int x = pixel(crop.left, width), y = pixel(crop.top, height);
  return {x, y, pixel(crop.right, width) - x, pixel(crop.bottom, height) - y};
}

}  // namespace

std::uint32_t MostPointsOfASample(const RenderOptions& options) {
  return std::max(options.light_samples, options.bsdf_samples);
}

void ResolveSize(JobRequest& request, const SceneDefaults& scene) {
  RenderOptions& options = request.options;
  options.width = request.width.value_or(scene.settings.width.value_or(options.width));
  options.height = request.height.value_or(scene.settings.height.value_or(options.height));
  if (options.width <= 0 || options.height <= 0 || options.width > kMaxFilmSide ||
      options.height > kMaxFilmSide ||
      std::int64_t{options.width} * options.height > kMaxFilmPixels) {
    throw InputError(
        InputPosition::File(scene.scene),
        fmt::format("a film of {} x {} pixels cannot be rendered: the limit is {} a side and {} "
                    "pixels",
                    options.width, options.height, kMaxFilmSide, kMaxFilmPixels));
  }
  request.width = options.width, request.height = options.height;
}

void ResolveIntegrator(JobRequest& request, const SceneDefaults& scene) {
  Integrator& integrator = request.options.integrator;
  integrator = request.integrator.value_or(
      Parse<Integrator>(scene.settings.integrator.value_or("")).value_or(integrator));
  request.integrator = integrator;
}

void ResolveStrategy(JobRequest& request, const SceneDefaults& scene) {
  if (!request.strategy.empty()) return;
  request.strategy = "importance";
  // The portals of a scene or a user ask for a strategy with which no light path can start.
  if (Describe(request.options.integrator).light_paths == LightPaths::kStrategy) return;
  if (!request.portals.empty()) {
    request.strategy = "portal";
  } else if (scene.settings.strategy) {
    request.strategy = *scene.settings.strategy;
  }
}

void ResolveCrop(JobRequest& request, const SceneDefaults& scene) {
  RenderOptions& options = request.options;
  if (!request.crop && scene.settings.crop) {
    request.crop = PixelsOf(*scene.settings.crop, options.width, options.height);
  }
  if (!request.crop) return;
  const CropWindow& crop = *request.crop;
  if (crop.x < 0 || crop.y < 0 || crop.width <= 0 || crop.height <= 0 ||
      crop.x > options.width - crop.width || crop.y > options.height - crop.height) {
    throw InputError(
        InputPosition::File(scene.scene),
        fmt::format("no pixel, or not all, of the part {}x{}+{}+{} is on the film of {} x {}",
                    crop.width, crop.height, crop.x, crop.y, options.width, options.height));
  }
  options.film_width = options.width, options.film_height = options.height;
  options.width = crop.width, options.height = crop.height;
  options.crop_x = crop.x, options.crop_y = crop.y;
}

namespace {

// Returns whether the integrator can have the filter of the scene, if that has one.
bool TakesFilter(Integrator integrator, const SceneDefaults& scene) {
  const std::optional<PixelFilter>& filter = scene.settings.filter;
  return !filter || !HasSigns(*filter) || !Describe(integrator).has_splats;
}

// Adds a warning of the scene, or throws InputError where it is read strictly.
void NoteWarning(const JobRequest& request, const std::string& text,
                 std::vector<std::string>& notes) {
  Warnings warnings = {.entries = {}, .by_text = {}, .strict = request.read.strict};
  AddWarning(warnings, InputPosition::File(request.scene), text);
  notes.push_back(WarningLines(warnings).front());
}

}  // namespace

void ResolveFilter(JobRequest& request, const SceneDefaults& scene) {
  RenderOptions& options = request.options;
  const bool fits = TakesFilter(options.integrator, scene);
  const bool from_scene = !request.filter && fits;
  if (request.filter) options.filter = *request.filter;
  if (from_scene) options.filter = scene.settings.filter.value_or(options.filter);
  if (options.filter_radius <= 0) {
    const float own = DefaultFilterRadius(options.filter);
    options.filter_radius = from_scene ? scene.settings.filter_radius.value_or(own) : own;
  }
  request.filter = options.filter;
}

void LimitDepth(JobRequest& request, std::vector<std::string>& notes) {
  std::uint32_t& depth = request.options.max_depth;
  if (depth <= kMaxDepth) return;
  notes.push_back(
      fmt::format("{}: a depth of {} is lowered to {}", request.scene, depth, kMaxDepth));
  depth = kMaxDepth;
  request.max_depth = depth;
}

void NoteOtherFilter(const JobRequest& request, const SceneDefaults& scene,
                     std::vector<std::string>& notes) {
  const RenderOptions& options = request.options;
  if (TakesFilter(options.integrator, scene) || options.filter == *scene.settings.filter) return;
  NoteWarning(
      request,
      fmt::format("the filter {} has negative weights, which --integrator {} does not take: "
                  "{} is used",
                  ToString(*scene.settings.filter), ToString(options.integrator),
                  ToString(options.filter)),
      notes);
}

void NoteUnknownLimits(const JobRequest& request, const SceneDefaults& scene,
                       std::vector<std::string>& notes) {
  const Integrator integrator = request.options.integrator;
  if (Takes(integrator, "clamp-sample")) return;
  const auto note = [&](const char* what, const std::optional<float>& limit) {
    if (!limit) return;
    NoteWarning(
        request,
        fmt::format("samples are not limited to {} of {:.6g}: --integrator {} has no clamps", what,
                    *limit, ToString(integrator)),
        notes);
  };
  note("a largest component", scene.settings.largest_of_sample);
  note("a luminance", scene.settings.luminance_of_sample);
}

void NoteUselessGuide(const JobRequest& request, std::vector<std::string>& notes) {
  const RenderOptions& options = request.options;
  if (!options.of<GuideOptions>().guide || Describe(options.integrator).has_light_paths()) return;
  notes.push_back(fmt::format("--guide changes nothing: --integrator {} has no light paths",
                              ToString(options.integrator)));
}

void CheckDenoised(const RenderOptions& options) {
  const auto refuse = [](const std::string& why) { throw OptionError("denoise", "", why); };
  if (options.samples_per_pixel < kFewestDenoiserSamples) {
    refuse(
        fmt::format("{} samples per pixel say too little about their noise: give `spp {}` or more",
                    options.samples_per_pixel, kFewestDenoiserSamples));
  }
  if (options.max_depth == 0) refuse("at `max-depth 0` no surface is looked at");
  if (Describe(options.integrator).has_splats) {
    refuse(
        fmt::format("the splats of `integrator {}` are not samples of a pixel, so their noise is "
                    "unknown",
                    ToString(options.integrator)));
  }
}

void CheckResolved(const JobRequest& request) {
  const RenderOptions& options = request.options;
  if (options.samples_per_pixel == 0) {
    throw InputError(InputPosition::File(request.scene), "0 samples per pixel show nothing");
  }
  const bool goes_on = options.bsdf_samples > 0 && !Describe(options.integrator).direct_light_only;
  if (!goes_on && !request.continuation_strategy.empty()) {
    throw OptionError("continuation-strategy", "",
                      "belongs to paths that split at their first hit: give `split S` as well");
  }
  if (std::uint64_t{options.samples_per_pixel} * MostPointsOfASample(options) > 0xFFFFFFFFu) {
    throw InputError(InputPosition::File(request.scene),
                     fmt::format("{} samples per pixel with {} light samples or continuations each "
                                 "are more than the 2^32 points of a pixel's sequence",
                                 options.samples_per_pixel, MostPointsOfASample(options)),
                     kExitUsage);
  }
  if (options.max_depth == 0 && ReadsHits(options.aovs)) {
    throw OptionError("aovs", ToString(options.aovs), "at `max-depth 0` no surface is looked at");
  }
  CheckIntegrator(options);
  if (request.denoise != Denoiser::kNone) CheckDenoised(options);
}

}  // namespace skywave
