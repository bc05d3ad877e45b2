#include "wavefront/option_checks.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <vector>

#include "base/error.h"
#include "base/granted.h"
#include "wavefront/option_names.h"
#include "wavefront/passes/photon_pass.h"
#include "wavefront/records/photon_map.h"

namespace skywave {
namespace {

// Returns the names of the integrators whose descriptor has this field set: "direct or path".
std::string NamesWith(bool IntegratorDescriptor::*field) {
  std::vector<std::string_view> names;
  for (const Integrator integrator : ValuesOf<Integrator>()) {
    if (Describe(integrator).*field) names.push_back(ToString(integrator));
  }
  return fmt::format("{}", fmt::join(names, " or "));
}

// Refuses options that only other integrators take.
void CheckTaken(const RenderOptions& options, const IntegratorDescriptor& integrator) {
  const std::string_view name = ToString(options.integrator);
  if (options.split > 0 && !integrator.splits) {
    throw OptionError("split", fmt::format("{}", options.split),
                      fmt::format("splits paths: `integrator {}` has none", name));
  }
  if (options.control != ControlVariate::kNone && !integrator.controls) {
    throw OptionError("control", std::string(ToString(options.control)),
                      fmt::format("is for light samples of paths from the camera alone: use "
                                  "`integrator {}`",
                                  NamesWith(&IntegratorDescriptor::controls)));
  }
  if (HasSigns(options.filter) && integrator.has_splats) {
    throw OptionError("filter", std::string(ToString(options.filter)),
                      fmt::format("has weights that are partly negative, which the splats of "
                                  "`integrator {}` do not take",
                                  name));
  }
  if (options.subpath_lengths && !integrator.selects_paths) {
    throw OptionError("paths", "",
                      fmt::format("shows what single techniques bring, which `integrator {}` does "
                                  "not; use `integrator {}`",
                                  name, NamesWith(&IntegratorDescriptor::selects_paths)));
  }
}

// Refuses layers that only other integrators keep.
void CheckLayers(const RenderOptions& options, const IntegratorDescriptor& integrator) {
  const auto refuse = [&](const std::string& why) {
    throw OptionError("aovs", ToString(options.aovs), why);
  };
  const bool one_start = integrator.has_light_groups && options.split == 0;
  if (Sums(options.aovs, AovSum::kLightGroups) && !one_start) {
    refuse(fmt::format("light groups are kept by `integrator {}`, without `split`",
                       NamesWith(&IntegratorDescriptor::has_light_groups)));
  }
  if (HasSigns(options.filter) &&
      (Sums(options.aovs, AovSum::kDirect) || Sums(options.aovs, AovSum::kIndirect) ||
       Sums(options.aovs, AovSum::kLightGroups))) {
    refuse(
        fmt::format("parts of the light are not kept with `filter {}`, whose weights are partly "
                    "negative",
                    ToString(options.filter)));
  }
  if (integrator.mixes_light &&
      (Sums(options.aovs, AovSum::kDirect) || Sums(options.aovs, AovSum::kIndirect))) {
    refuse(fmt::format("`integrator {}` does not keep direct and indirect light apart",
                       ToString(options.integrator)));
  }
  if (integrator.has_splats &&
      (Sums(options.aovs, AovSum::kVariance) || Sums(options.aovs, AovSum::kHalf) ||
       Sums(options.aovs, AovSum::kHalfVariance) || Sums(options.aovs, AovSum::kDirect) ||
       Sums(options.aovs, AovSum::kIndirect))) {
    refuse(
        fmt::format("variance, halves, direct and indirect are of samples of a pixel, which the "
                    "splats of `integrator {}` are not",
                    ToString(options.integrator)));
  }
}

// Refuses passes without samples, and more photons than there is memory for.
void CheckPasses(const RenderOptions& options) {
  if (options.photons.passes > PictureSamples(options).count()) {
    throw OptionError("progressive", fmt::format("{}", options.photons.passes),
                      fmt::format("each pass needs a sample a pixel, and `spp` is {}",
                                  PictureSamples(options).count()));
  }
  CheckPhotonMemory(options, GrantedHere().memory_bytes);
}

// Returns how many light vertices a pass has at most: options.photons.indirect, or all that its
// light paths could leave.
std::uint64_t MostVertices(const RenderOptions& options) {
  const std::uint64_t samples = PictureSamples(options).count() / PhotonPasses(options).size();
  const CropWindow film =
      WholeBlocks({options.crop_x, options.crop_y, options.width, options.height});
  const std::uint64_t paths = std::uint64_t(film.width) * std::uint64_t(film.height) * samples;
  return std::min<std::uint64_t>(options.photons.indirect, paths * options.max_depth);
}

bool StoresVertices(const RenderOptions& options) {
  return Describe(options.integrator).stores == StoredLight::kVertices;
}

}  // namespace

void RefusePhotons(const RenderOptions& options, const std::string& why) {
  std::vector<OptionValue> asked = {{"photons", fmt::format("{}", options.photons.indirect)}};
  if (!StoresVertices(options)) {
    asked.push_back({"caustic-photons", fmt::format("{}", options.photons.caustic)});
  }
  throw OptionError(std::move(asked), why + "; ask for fewer");
}

void CheckPhotonMemory(const RenderOptions& options, std::uint64_t memory) {
  const PhotonOptions& photons = options.photons;
  const bool vertices = StoresVertices(options);
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

void CheckIntegrator(const RenderOptions& options) {
  const IntegratorDescriptor& integrator = Describe(options.integrator);
  CheckTaken(options, integrator);
  CheckLayers(options, integrator);
  if (integrator.check != nullptr) integrator.check(options);
  if (integrator.has_photons()) CheckPasses(options);
}

}  // namespace skywave
