#include "wavefront/option_checks.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <vector>

#include "base/error.h"
#include "wavefront/option_names.h"
#include "wavefront/policy.h"
#include "wavefront/render_option.h"
#include "wavefront/stages/links.h"

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

// Refuses options that only other integrators take, where they cannot just be left out.
void CheckTaken(const RenderOptions& options, const IntegratorDescriptor& integrator) {
  const RenderOptions defaults;
  for (const RenderOption& option : RenderOptionTable()) {
    if (option.refused.empty() || Takes(options.integrator, option.name)) continue;
    const std::vector<std::string> value = option.get(options);
    if (value == option.get(defaults)) continue;
    throw OptionError(
        std::string(option.name), Joined(option, value),
        fmt::format("{}, which `integrator {}` does not: use `integrator {}`", option.refused,
                    ToString(options.integrator), fmt::join(IntegratorsOf(option), " or ")));
  }
  if (HasSigns(options.filter) && integrator.has_splats) {
    throw OptionError("filter", std::string(ToString(options.filter)),
                      fmt::format("has weights that are partly negative, which the splats of "
                                  "`integrator {}` do not take",
                                  ToString(options.integrator)));
  }
}

// Light paths start at lights that are picked by power, and their weights suppose that the other
// techniques pick lights by power, too.
void CheckSelection(const RenderOptions& options, const IntegratorDescriptor& integrator) {
  if (!integrator.has_light_paths() || options.light_selection == LightSelection::kPower) return;
  throw OptionError(
      "light-selection", std::string(ToString(options.light_selection)),
      fmt::format("is for integrators whose paths all start at the camera, as path and "
                  "direct; paths of `integrator {}` also start at lights, which they "
                  "pick by power",
                  ToString(options.integrator)));
}

// Refuses layers that only other integrators keep.
void CheckLayers(const RenderOptions& options, const IntegratorDescriptor& integrator) {
  const auto refuse = [&](const std::string& why) {
    throw OptionError("aovs", ToString(options.aovs), why);
  };
  const bool one_start = integrator.has_light_groups && options.bsdf_samples == 0;
  if (Sums(options.aovs, AovSum::kLightGroups) && !one_start) {
    refuse(fmt::format("light groups are kept by `integrator {}`, without `split`",
                       NamesWith(&IntegratorDescriptor::has_light_groups)));
  }
  if (Sums(options.aovs, AovSum::kDifference) &&
      !(integrator.has_catchers && options.bsdf_samples == 0)) {
    throw OptionError("catcher", "",
                      fmt::format("catchers are known to `integrator {}`, without `split`",
                                  NamesWith(&IntegratorDescriptor::has_catchers)));
  }
  if (Sums(options.aovs, AovSum::kBackdrop) &&
      !(integrator.has_catchers && options.bsdf_samples == 0)) {
    throw OptionError("dome", "",
                      fmt::format("is known to `integrator {}`, without `split`",
                                  NamesWith(&IntegratorDescriptor::has_catchers)));
  }
  if (options.of<LinkOptions>().count > 0 && !one_start) {
    throw OptionError("link", "",
                      fmt::format("lights are linked by `integrator {}`, without `split`",
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

}  // namespace

void CheckIntegrator(const RenderOptions& options) {
  const IntegratorDescriptor& integrator = Describe(options.integrator);
  CheckTaken(options, integrator);
  CheckSelection(options, integrator);
  CheckLayers(options, integrator);
  if (integrator.check != nullptr) integrator.check(options);
  for (const PolicyDescriptor& policy : Policies()) {
    if (policy.check != nullptr) policy.check(options);
  }
}

}  // namespace skywave
