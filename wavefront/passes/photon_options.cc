#include "wavefront/passes/photon_options.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "base/error.h"
#include "base/granted.h"
#include "wavefront/option_names.h"

namespace skywave {
namespace {

constexpr std::string_view kGroup = "Photon mapping and vertex merging (photon, vcm)";

// pbrt's sppm has a pass for each sample, with photons of its own.
bool WantsPassPerSample(const RenderOptions& options, const RenderSettings& settings) {
  return settings.photons_each_sample && !Describe(options.integrator).pass_each_sample;
}

void ResolvePasses(RenderOptions& options, const RenderSettings& settings) {
  if (!WantsPassPerSample(options, settings)) return;
  std::uint32_t& passes = options.of<PhotonOptions>().passes;
  if (passes == 0) passes = options.samples_per_pixel;
}

void ResolveDistance(RenderOptions& options, const RenderSettings& settings) {
  if (!WantsPassPerSample(options, settings)) return;
  float& distance = options.of<PhotonOptions>().distance;
  if (distance <= 0) distance = settings.photon_distance.value_or(0);
}

std::vector<RenderOption> MakeTable() {
  // clang-format off
  return {
      MakeRenderOption({.name = "photons", .group = kGroup, .help = "photons to store for indirect light; vcm: light vertices that a pass keeps at most", .scope = OptionScope::kPixels, .example = "--integrator photon --photons 300"},
                       SKYWAVE_FIELD_OF(PhotonOptions, indirect), Numbers(0u, kMostPhotons)),
      MakeRenderOption({.name = "caustic-photons", .group = kGroup, .help = "photons to store for light from mirrors and glass", .scope = OptionScope::kPixels, .example = "--integrator photon --caustic-photons 100"},
                       SKYWAVE_FIELD_OF(PhotonOptions, caustic), Numbers(0u, kMostPhotons)),
      MakeRenderOption({.name = "gather", .group = kGroup, .help = "rays of a final gather per hit; 0: photons are seen directly", .scope = OptionScope::kPixels, .example = "--integrator photon --gather 2"},
                       SKYWAVE_FIELD_OF(PhotonOptions, gather), Numbers(0u, 4096u)),
      MakeRenderOption({.name = "photon-neighbors", .group = kGroup, .help = "largest number of photons of a lookup", .scope = OptionScope::kPixels, .example = "--integrator photon --photon-neighbors 7"},
                       SKYWAVE_FIELD_OF(PhotonOptions, neighbors), Numbers(2u, 1u << 16)),
      OfScene(MakeRenderOption({.name = "progressive", .group = kGroup, .help = "passes over --spp, each with photons of its own and a smaller radius", .scope = OptionScope::kPixels, .example = "--spp 6 --integrator vcm --progressive 3", .default_text = "photon 1, vcm one per sample"},
                       SKYWAVE_FIELD_OF(PhotonOptions, passes), Unless(0u, Numbers(1u, 1u << 20))), ResolvePasses),
      OfScene(MakeRenderOption({.name = "photon-distance", .group = kGroup, .help = "largest distance of a lookup; progressive, vcm: radius of the first pass; 0: by the photons and pixels", .scope = OptionScope::kPixels, .example = "--integrator photon --photon-distance 0.5"},
                       SKYWAVE_FIELD_OF(PhotonOptions, distance), Floats(0, 1e12)), ResolveDistance),
      MakeRenderOption({.name = "photon-kernel", .group = kGroup, .help = "weights of the photons of a lookup", .scope = OptionScope::kPixels, .example = "--integrator photon --photon-kernel cone"},
                       SKYWAVE_FIELD_OF(PhotonOptions, kernel), NamesOfEnum<PhotonKernel>()),
      MakeRenderOption({.name = "progressive-alpha", .group = kGroup, .help = "alpha of (i + alpha) / (i + 1), by which squared radii shrink", .scope = OptionScope::kPixels, .example = "--spp 6 --integrator vcm --progressive 3 --progressive-alpha 0.5"},
                       SKYWAVE_FIELD_OF(PhotonOptions, alpha), Floats(0.01, 1)),
  };
  // clang-format on
}

// Returns how many light vertices a pass has at most: options.of<PhotonOptions>().indirect, or all
// that its light paths could leave.
std::uint64_t MostVertices(const RenderOptions& options) {
  const std::uint64_t samples = PictureSamples(options).count() / PhotonPasses(options).size();
  const CropWindow film =
      WholeBlocks({options.crop_x, options.crop_y, options.width, options.height});
  const std::uint64_t paths = std::uint64_t(film.width) * std::uint64_t(film.height) * samples;
  return std::min<std::uint64_t>(options.of<PhotonOptions>().indirect, paths * options.max_depth);
}

}  // namespace

std::span<const RenderOption> PhotonOptionTable() {
  static const std::vector<RenderOption> table = MakeTable();
  return table;
}

std::span<const RenderOption> VertexOptionTable() {
  static const std::vector<RenderOption> table = [] {
    std::vector<RenderOption> all = MakeTable();
    std::erase_if(all, [](const RenderOption& option) {
      return option.name == "caustic-photons" || option.name == "gather";
    });
    return all;
  }();
  return table;
}

std::vector<PhotonPass> PhotonPasses(const RenderOptions& options) {
  const SampleRange picture = PictureSamples(options);
  const std::uint32_t samples = picture.count(), wanted = options.of<PhotonOptions>().passes;
  const bool each_sample = Describe(options.integrator).pass_each_sample && wanted == 0;
  const std::uint32_t passes = each_sample ? samples : std::clamp(wanted, 1u, samples);
  const auto first_of = [&](std::uint32_t pass) {
    return picture.first + std::uint32_t(std::uint64_t(samples) * pass / passes);
  };
  std::vector<PhotonPass> list;
  double shrink2 = 1;
  const auto shrink = [&](std::uint32_t pass) {
    shrink2 *= (pass + 1 + double(options.of<PhotonOptions>().alpha)) / (pass + 2);
  };
  // If a pass is a sample, it is the same pass in every picture.
  const std::uint32_t before = each_sample ? picture.first : 0;
  for (std::uint32_t i = 0; i < before; ++i) shrink(i);
  for (std::uint32_t i = 0; i < passes; ++i) {
    list.push_back(
        {.samples = {first_of(i), first_of(i + 1)}, .shrink = float(std::sqrt(shrink2))});
    shrink(before + i);
  }
  return list;
}

void RefusePhotons(const RenderOptions& options, const std::string& why) {
  std::vector<OptionValue> asked = {
      {"photons", fmt::format("{}", options.of<PhotonOptions>().indirect)}};
  if (Takes(options.integrator, "caustic-photons")) {
    asked.push_back({"caustic-photons", fmt::format("{}", options.of<PhotonOptions>().caustic)});
  }
  throw OptionError(std::move(asked), why + "; ask for fewer");
}

void CheckPhotonMemory(const RenderOptions& options, bool vertices, std::uint64_t memory) {
  const PhotonOptions& photons = options.of<PhotonOptions>();
  const std::uint64_t count =
      vertices ? MostVertices(options) : std::uint64_t{photons.indirect} + photons.caustic;
  const std::uint64_t bytes = count * PhotonBytes(/*with_subpaths=*/vertices);
  constexpr double kGigabyte = 1e9;
  if (std::max(photons.indirect, photons.caustic) > kMostPhotons) {
    RefusePhotons(options, fmt::format("a map has room for {}", kMostPhotons));
  }
  if (bytes > memory) {
    RefusePhotons(options,
                  fmt::format("they take {:.1f} GB while maps are built, and there are {:.1f} GB",
                              double(bytes) / kGigabyte, double(memory) / kGigabyte));
  }
}

void CheckPhotonPasses(const RenderOptions& options, bool vertices) {
  const std::uint32_t passes = options.of<PhotonOptions>().passes;
  if (passes > PictureSamples(options).count()) {
    throw OptionError("progressive", fmt::format("{}", passes),
                      fmt::format("each pass needs a sample a pixel, and `spp` is {}",
                                  PictureSamples(options).count()));
  }
  CheckPhotonMemory(options, vertices, GrantedHere().memory_bytes);
}

}  // namespace skywave
