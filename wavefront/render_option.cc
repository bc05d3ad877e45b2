#include "wavefront/render_option.h"

#include <algorithm>

#include "wavefront/integrator.h"
#include "wavefront/policy.h"

namespace skywave {
namespace {

// Whether the integrator itself describes the option.
bool Describes(Integrator integrator, std::string_view option) {
  const auto options = Describe(integrator).options;
  if (options == nullptr) return false;
  const std::span<const RenderOption> own = options();
  return std::any_of(own.begin(), own.end(),
                     [&](const RenderOption& some) { return some.name == option; });
}

}  // namespace

const std::vector<RenderOption>& RenderOptionTable() {
  static const std::vector<RenderOption> table = [] {
    std::vector<RenderOption> all;
    const auto add = [&](std::span<const RenderOption> some) {
      for (const RenderOption& option : some) {
        const bool known = std::any_of(all.begin(), all.end(), [&](const RenderOption& other) {
          return other.name == option.name;
        });
        if (!known) all.push_back(option);
      }
    };
    for (const Integrator integrator : ValuesOf<Integrator>()) {
      if (Describe(integrator).options != nullptr) add(Describe(integrator).options());
    }
    for (RenderOption& option : all) {
      option.applies = [name = option.name](Integrator integrator) {
        return Describes(integrator, name);
      };
    }
    for (const PolicyDescriptor& policy : Policies()) {
      if (policy.options != nullptr) add(policy.options());
    }
    return all;
  }();
  return table;
}

bool Takes(Integrator integrator, std::string_view option) {
  for (const RenderOption& some : RenderOptionTable()) {
    if (some.name == option) return some.applies == nullptr || some.applies(integrator);
  }
  return false;
}

}  // namespace skywave
