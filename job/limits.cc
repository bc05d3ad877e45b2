#include "job/limits.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <limits>

#include "base/error.h"

namespace skywave {
namespace {

// The first samples after which the noise is looked at. Variances of fewer samples are too noisy to
// end a render by.
constexpr std::uint32_t kFirstLook = 8;

// Returns the smallest kFirstLook * 2^k above `done`.
std::uint32_t NextLook(std::uint32_t done) {
  std::uint64_t look = kFirstLook;
  while (look <= done) look *= 2;
  return std::uint32_t(std::min<std::uint64_t>(look, std::numeric_limits<std::uint32_t>::max()));
}

bool IsLook(std::uint32_t done) { return done >= kFirstLook && NextLook(done) == 2ull * done; }

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
    option({.name = "time", .help = "end after about this time with the samples that every pixel has then, at most --spp", .example = "--spp 3 --time 0.001", .default_text = "no limit", .metavar = "SECONDS"}, FIELD(seconds), Unless(0.0, Doubles(0.001, 1e9))),
    option({.name = "noise", .help = "end as soon as the noise, relative to the mean of the picture, is no larger; looked at whenever the samples have doubled, at most --spp", .example = "--spp 16 --noise 10", .default_text = "no limit", .metavar = "E"}, FIELD(noise), Unless(0.0, Doubles(1e-9, 1e9))),
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
  if (limits.noise <= 0) return 0;
  if (Describe(integrator).has_splats) {
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
    if (limits.seconds > 0) {
      stop = std::min(stop, done + SamplesInTime(done, elapsed(), limits.seconds));
    }
    return samples.first + stop;
  };
}

}  // namespace skywave
