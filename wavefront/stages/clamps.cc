#include "wavefront/stages/clamps.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "base/error.h"
#include "image/image.h"
#include "wavefront/option_names.h"
#include "wavefront/stages/path_stages.h"

namespace skywave {
namespace {

// Returns the factor that brings a size down to a limit, which is none where it is 0.
float FactorOf(float size, float limit) { return limit > 0 && size > limit ? limit / size : 1; }

float Largest(float r, float g, float b) {
  return std::max({std::abs(r), std::abs(g), std::abs(b)});
}

void Scale(const PathColumns& paths, std::uint32_t i, float factor) {
  paths.r[i] *= factor, paths.g[i] *= factor, paths.b[i] *= factor;
}

void ClampIndirect(const RadianceColumns& direct, const PathColumns& paths, std::uint32_t n,
                   float limit) {
  for (std::uint32_t i = 0; i < n; ++i) {
    const float r = paths.r[i] - direct.r[i], g = paths.g[i] - direct.g[i],
                b = paths.b[i] - direct.b[i];
    const float factor = FactorOf(Largest(r, g, b), limit);
    if (!(factor < 1)) continue;
    paths.r[i] = direct.r[i] + factor * r;
    paths.g[i] = direct.g[i] + factor * g;
    paths.b[i] = direct.b[i] + factor * b;
  }
}

void ClampWhole(const PathColumns& paths, std::uint32_t n, float limit, float luminance) {
  for (std::uint32_t i = 0; i < n; ++i) {
    Scale(paths, i, FactorOf(Largest(paths.r[i], paths.g[i], paths.b[i]), limit));
    const float rgb[3] = {paths.r[i], paths.g[i], paths.b[i]};
    Scale(paths, i, FactorOf(Luminance(rgb), luminance));
  }
}

// Takes a limit of the scene where the user gives none and the integrator knows limits.
template <float ClampOptions::*kLimit, std::optional<float> RenderSettings::*kOfScene>
void ResolveLimit(RenderOptions& options, const RenderSettings& settings) {
  if (!Takes(options.integrator, "clamp-sample")) return;
  float& limit = options.of<ClampOptions>().*kLimit;
  if (limit <= 0) limit = (settings.*kOfScene).value_or(0);
}

}  // namespace

std::span<const RenderOption> ClampOptionTable() {
  constexpr std::string_view kWhy = "limits what a path brings";
  // clang-format off
  static const RenderOption table[] = {
      Refused(kWhy, MakeRenderOption({.name = "clamp-direct", .group = "Paths", .help = "largest radiance that a path brings of direct light, against fireflies; the picture gets darker where it works", .scope = OptionScope::kPixels, .example = "--clamp-direct 0.4", .default_text = "no limit"},
                       SKYWAVE_FIELD_OF(ClampOptions, direct), Unless(0.0f, Floats(1e-12, 1e12)))),
      Refused(kWhy, MakeRenderOption({.name = "clamp-indirect", .group = "Paths", .help = "the same of indirect light: that of second and later surfaces, caustics too", .scope = OptionScope::kPixels, .example = "--clamp-indirect 0.2", .default_text = "no limit"},
                       SKYWAVE_FIELD_OF(ClampOptions, indirect), Unless(0.0f, Floats(1e-12, 1e12)))),
      OfScene(Refused(kWhy, MakeRenderOption({.name = "clamp-sample", .group = "Paths", .help = "the same of all light that a sample of a pixel brings; 1e12 lifts the limit of a file", .scope = OptionScope::kPixels, .example = "--clamp-sample 0.5", .default_text = "no limit"},
                       SKYWAVE_FIELD_OF(ClampOptions, sample), Unless(0.0f, Floats(1e-12, 1e12)))),
              ResolveLimit<&ClampOptions::sample, &RenderSettings::largest_of_sample>),
      OfScene(Refused(kWhy, MakeRenderOption({.name = "clamp-luminance", .group = "Paths", .help = "largest luminance of a sample of a pixel", .scope = OptionScope::kPixels, .example = "--clamp-luminance 0.3", .default_text = "no limit"},
                       SKYWAVE_FIELD_OF(ClampOptions, luminance), Unless(0.0f, Floats(1e-12, 1e12)))),
              ResolveLimit<&ClampOptions::luminance, &RenderSettings::luminance_of_sample>),
  };
  // clang-format on
  return table;
}

void CheckClamps(const RenderOptions& options) {
  if (!options.of<ClampOptions>().any() || !Sums(options.aovs, AovSum::kLightGroups)) return;
  const ClampOptions& clamps = options.of<ClampOptions>();
  const char* const name = ClampOptions::Works(clamps.direct)     ? "clamp-direct"
                           : ClampOptions::Works(clamps.indirect) ? "clamp-indirect"
                           : ClampOptions::Works(clamps.sample)   ? "clamp-sample"
                                                                  : "clamp-luminance";
  throw OptionError(name, "",
                    "is of all light of a path, and light groups are parts of it: leave out "
                    "`aovs lights`, or the clamp (1e12 lifts that of a file)");
}

void AddClampTables(const RenderOptions& options, Worker& worker) {
  if (options.of<ClampOptions>().any()) worker.tables.Add<ClampTables>(options.wave);
}

void ClampDirect(const FrameView& frame, std::uint32_t bounce, const Worker& w) {
  const auto* const tables = w.tables.find<ClampTables>();
  if (tables == nullptr || bounce != kFirstIndirectBounce) return;
  const RadianceColumns& direct = tables->direct;
  const PathColumns& paths = w.paths;
  const float limit = frame.options.of<ClampOptions>().direct;
  for (std::uint32_t i = 0; i < frame.options.wave; ++i) {
    Scale(paths, i, FactorOf(Largest(paths.r[i], paths.g[i], paths.b[i]), limit));
    direct.r[i] = paths.r[i], direct.g[i] = paths.g[i], direct.b[i] = paths.b[i];
  }
}

void ClampDirectOfEnded(const FrameView& frame, std::uint32_t bounce, const Worker& w) {
  if (bounce <= kFirstIndirectBounce) ClampDirect(frame, kFirstIndirectBounce, w);
}

void ClampIndirectAndWhole(const FrameView& frame, const Worker& w) {
  const auto* const tables = w.tables.find<ClampTables>();
  if (tables == nullptr) return;
  const auto& clamps = frame.options.of<ClampOptions>();
  const std::uint32_t n = frame.options.wave;
  ClampIndirect(tables->direct, w.paths, n, clamps.indirect);
  ClampWhole(w.paths, n, clamps.sample, clamps.luminance);
}

}  // namespace skywave
