#include "wavefront/stages/clamps.h"

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "wavefront/option_names.h"
#include "wavefront/stages/path_stages.h"

namespace skywave {
namespace {

// Returns the factor that brings a radiance down to a limit.
float FactorOf(float r, float g, float b, float limit) {
  const float most = std::max({std::abs(r), std::abs(g), std::abs(b)});
  return most > limit ? limit / most : 1;
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
  };
  // clang-format on
  return table;
}

void CheckClamps(const RenderOptions& options) {
  if (!options.of<ClampOptions>().any() || !Sums(options.aovs, AovSum::kLightGroups)) return;
  const bool direct = options.of<ClampOptions>().direct > 0;
  throw OptionError(direct ? "clamp-direct" : "clamp-indirect", "",
                    "is of all light of a path, and light groups are parts of it: leave out "
                    "`aovs lights`, or the clamp");
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
    if (limit > 0) {
      const float factor = FactorOf(paths.r[i], paths.g[i], paths.b[i], limit);
      paths.r[i] *= factor, paths.g[i] *= factor, paths.b[i] *= factor;
    }
    direct.r[i] = paths.r[i], direct.g[i] = paths.g[i], direct.b[i] = paths.b[i];
  }
}

void ClampDirectOfEnded(const FrameView& frame, std::uint32_t bounce, const Worker& w) {
  if (bounce <= kFirstIndirectBounce) ClampDirect(frame, kFirstIndirectBounce, w);
}

void ClampIndirect(const FrameView& frame, const Worker& w) {
  const float limit = frame.options.of<ClampOptions>().indirect;
  const auto* const tables = w.tables.find<ClampTables>();
  if (tables == nullptr || !(limit > 0)) return;
  const RadianceColumns& direct = tables->direct;
  const PathColumns& paths = w.paths;
  for (std::uint32_t i = 0; i < frame.options.wave; ++i) {
    const float r = paths.r[i] - direct.r[i], g = paths.g[i] - direct.g[i],
                b = paths.b[i] - direct.b[i];
    const float factor = FactorOf(r, g, b, limit);
    if (!(factor < 1)) continue;
    paths.r[i] = direct.r[i] + factor * r;
    paths.g[i] = direct.g[i] + factor * g;
    paths.b[i] = direct.b[i] + factor * b;
  }
}

}  // namespace skywave
