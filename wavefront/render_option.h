// An option of an integrator or of a policy, whose value is a field of a struct of its own.
#pragma once

#include <string_view>

#include "scene/scene.h"
#include "wavefront/frame.h"
#include "wavefront/option.h"

namespace skywave {

struct RenderOption : OptionOf<RenderOptions> {
  // Takes the value of the scene file where the user gives none. Null: scene files have none.
  void (*resolve)(RenderOptions& options, const RenderSettings& settings) = nullptr;
  // What a value other than the default does, which integrators that do not take the option
  // therefore refuse: "splits paths"; empty: it changes nothing there.
  std::string_view refused = {};
};

// The field of the struct `type` in RenderOptions, for MakeOption.
#define SKYWAVE_FIELD_OF(type, field) \
  [](auto& options) -> auto& { return options.template of<type>().field; }

template <class Field, class Value>
RenderOption MakeRenderOption(const OptionInfo& info, Field field, const Codec<Value>& codec) {
  return {MakeOption<RenderOptions>(info, field, codec)};
}

// The same option, which integrators that do not take it refuse.
inline RenderOption Refused(std::string_view why, RenderOption option) {
  option.refused = why;
  return option;
}

// The same option, which takes the value of the scene file where the user gives none.
inline RenderOption OfScene(RenderOption option,
                            void (*resolve)(RenderOptions&, const RenderSettings&)) {
  option.resolve = resolve;
  option.scene_may_set = true;
  return option;
}

// Whether an integrator takes an option of this name that it or a policy has.
bool Takes(Integrator integrator, std::string_view option);

// All options of integrators and policies; those that several integrators take once.
const std::vector<RenderOption>& RenderOptionTable();

}  // namespace skywave
