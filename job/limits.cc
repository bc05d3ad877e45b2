#include "job/limits.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <limits>

#include "base/error.h"
#include "wavefront/adaptive.h"

namespace skywave {
namespace {

// The first samples after which the noise is looked at. Variances of fewer samples are too noisy to
// end a render by.
constexpr std::uint32_t kFirstLook = 8;

// Returns the smallest first * 2^k above `done`.
std::uint32_t NextLook(std::uint32_t done, std::uint32_t first = kFirstLook) {
  std::uint64_t look = first;
  while (look <= done) look *= 2;
  return std::uint32_t(std::min<std::uint64_t>(look, std::numeric_limits<std::uint32_t>::max()));
}

bool IsLook(std::uint32_t done, std::uint32_t first = kFirstLook) {
  return done >= first && NextLook(done, first) == 2ull * done;
}

// Returns how many samples of every pixel fit the time that is left; 0: none.
std::uint32_t SamplesInTime(std::uint32_t done, double elapsed, double seconds) {
  if (done == 0) return 1;
  const double left = (seconds - elapsed) / elapsed * done;
  return std::uint32_t(std::clamp(left, 0.0, double(done)));
}

}  // namespace

Codec<SampleRange> SampleRanges() {
  return {.values = "FIRST:END with FIRST < END, for example 0:16",
          .metavar = "FIRST:END",
          .parse = [](const std::string& text) -> std::optional<SampleRange> {
            SampleRange range;
            const char* const end = text.data() + text.size();
            const auto first = std::from_chars(text.data(), end, range.first);
            if (first.ec != std::errc() || first.ptr == end || *first.ptr != ':') return {};
            const auto last = std::from_chars(first.ptr + 1, end, range.end);
            if (last.ec != std::errc() || last.ptr != end) return {};
            return range.first < range.end ? std::optional(range) : std::nullopt;
          },
          .print = [](const SampleRange& r) { return fmt::format("{}:{}", r.first, r.end); }};
}

#define FIELD SKYWAVE_FIELD
std::vector<OptionOf<RenderLimits>> LimitOptions() {
  const auto option = [](OptionInfo info, auto field, auto codec) {
    info.group = "Limits";
    info.scope = OptionScope::kPixels;
    return MakeOption<RenderLimits>(info, field, codec);
  };
  // clang-format off
  return {
    option({.name = "sample-range", .help = "render these samples of --spp only: a part, for --film and skywave merge", .example = "--spp 5 --sample-range 1:4", .default_text = "all"}, FIELD(samples), SampleRanges()),
    option({.name = "time", .help = "end after about this time with the samples that every pixel has then, at most --spp", .example = "--spp 4096 --time 0.001", .default_text = "no limit", .metavar = "SECONDS"}, FIELD(seconds), Unless(0.0, Doubles(0.001, 1e9))),
    option({.name = "noise", .help = "end as soon as the noise, relative to the mean of the picture, is no larger; looked at whenever the samples have doubled, at most --spp", .example = "--spp 16 --noise 10", .default_text = "no limit", .metavar = "E"}, FIELD(noise), Unless(0.0, Doubles(1e-9, 1e9))),
    option({.name = "adaptive", .help = "sample where the noise is, until the error of the picture, relative to the brightness of each place, is no larger; looked at whenever the samples have doubled, at most --spp", .example = "--spp 32 --adaptive 0.2", .default_text = "all pixels get --spp", .metavar = "E", .excludes = "noise"}, FIELD(adaptive), Unless(0.0, Doubles(1e-9, 1e9))),
    option({.name = "adaptive-min", .help = "samples that every pixel gets before --adaptive chooses", .example = "--spp 32 --adaptive 0.2 --adaptive-min 4", .metavar = "N", .needs = "adaptive"}, FIELD(adaptive_min), Numbers(2u, 1u << 24)),
  };
  // clang-format on
}
#undef FIELD

SampleRange ChooseSamples(const RenderLimits& limits, std::uint32_t samples_per_pixel) {
  const SampleRange range = limits.samples.value_or(SampleRange{0, samples_per_pixel});
  if (range.end > samples_per_pixel) {
    throw OptionError(
        "sample-range", SampleRanges().print(range),
        fmt::format("the picture has samples 0:{}; `spp` gives their number", samples_per_pixel));
  }
  return range;
}

AovSet LayersForLimits(const RenderLimits& limits, Integrator integrator) {
  const IntegratorDescriptor& descriptor = Describe(integrator);
  if (limits.adaptive > 0 && (descriptor.has_splats || descriptor.for_each_pass != nullptr)) {
    throw OptionError("adaptive", fmt::format("{}", limits.adaptive),
                      fmt::format("pixels of `integrator {}` share the light that was stored or "
                                  "splatted, so their samples do not show their error; use "
                                  "`integrator path` or `integrator direct`",
                                  ToString(integrator)));
  }
  if (limits.noise <= 0 && limits.adaptive <= 0) return 0;
  if (descriptor.has_splats) {
    throw OptionError("noise", fmt::format("{}", limits.noise),
                      fmt::format("the splats of `integrator {}` are not samples of a pixel, so "
                                  "their variance is unknown; limit `time` or `spp`",
                                  ToString(integrator)));
  }
  return *ParseAovs("variance");
}

std::function<std::uint32_t(std::uint32_t done)> StopRule(const RenderLimits& limits,
                                                          const SampleRange& samples,
                                                          const Film& film,
                                                          std::function<double()> elapsed) {
  return [=, &film](std::uint32_t end_of_last) {
    const std::uint32_t done = end_of_last - samples.first;
    std::uint32_t stop = samples.count();
    if (limits.noise > 0) {
      if (IsLook(done) && film.Noise(done) <= limits.noise) return end_of_last;
      stop = std::min(stop, NextLook(done));
    }
    if (limits.adaptive > 0) stop = std::min(stop, NextLook(done, limits.adaptive_min));
    if (limits.seconds > 0) {
      stop = std::min(stop, done + SamplesInTime(done, elapsed(), limits.seconds));
    }
    return samples.first + stop;
  };
}

double EndBlocks(const RenderLimits& limits, const SampleRange& samples, const FrameView& frame,
                 const Film& film, RenderState& state) {
  const std::uint32_t done = state.step.first - samples.first, most = samples.count();
  std::vector<double> wanted;
  if (IsLook(done, limits.adaptive_min)) {
    wanted = WantedSamples(film, SamplesByPixel(frame, state), limits.adaptive);
    state.ended.resize(wanted.size());
    for (std::size_t i = 0; i < wanted.size(); ++i) {
      if (state.ended[i] == 0 && wanted[i] <= done) state.ended[i] = state.step.first;
    }
  }
  double spared = 0;
  for (std::size_t i = 0; i < state.ended.size(); ++i) {
    double end = most;
    if (state.ended[i] != 0) {
      end = state.ended[i] - samples.first;
    } else if (!wanted.empty() && wanted[i] < most) {
      end = std::min(most, NextLook(std::uint32_t(wanted[i]), limits.adaptive_min));
    }
    spared += 1 - end / most;
  }
  return state.ended.empty() ? 0 : spared / double(state.ended.size());
}

}  // namespace skywave
