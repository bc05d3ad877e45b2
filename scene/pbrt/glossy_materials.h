// pbrt-v3's materials of a body (Kd) and a gloss (Ks), whose light is added and not layered.
#pragma once

#include "scene/pbrt/material_parameters.h"

namespace skywave {

Material PbrtPlastic(PbrtMaterialContext& context);
Material PbrtSubstrate(PbrtMaterialContext& context);
// With Kr or Kt, this is a sum with smooth glass: two parts, which are added to the scene.
Material PbrtUber(PbrtMaterialContext& context);
// Its gloss is rough glass, so this is a sum likewise, unless Ks is black.
Material PbrtTranslucent(PbrtMaterialContext& context);

}  // namespace skywave
