#include "kernels/lights/directional.h"

#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/lights/directional.cc"
#include "hwy/foreach_target.h"
#include "hwy/highway.h"
#include "kernels/lights/search_tree-inl.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

void FillDirectional(const LightRecord& light, std::uint32_t n, const LightColumns& out) {
  const V3 direction = Set3(light.direction), irradiance = Set3(light.irradiance);
  const VF delta = Set(std::numeric_limits<float>::infinity());
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    Store3(direction, out.dir_x + i, out.dir_y + i, out.dir_z + i);
    Store3(irradiance, out.r + i, out.g + i, out.b + i);
    Store(delta, out.pdf + i);
  }
}

struct PickedLights {
  V3 direction, irradiance;
};
HWY_INLINE PickedLights FetchLights(const LightRecord* lights, VU index, float samples) {
  const auto* fields = reinterpret_cast<const float*>(lights);
  const VU at = hn::ShiftLeft<3>(index);
  const auto field = [&](std::uint32_t k) HWY_ATTR { return Gather(fields, at + SetU(k)); };
  const VF worth = 1.0f / (field(6) * samples);
  return {{field(0), field(1), field(2)}, V3{field(3), field(4), field(5)} * worth};
}

void PickDirectional(const LightRecord* lights, const SearchTreeView& tree, const float* u,
                     std::uint32_t n, float samples, const LightColumns& out) {
  const VF delta = Set(std::numeric_limits<float>::infinity());
  SearchColumns search;
  for (std::uint32_t begin = 0; begin < n; begin += kChunk) {
    const std::uint32_t rows = std::min(kChunk, n - begin);
    Search(tree, u + begin, rows, search);
    for (std::uint32_t i = 0; i < rows; i += hn::Lanes(F())) {
      const VU index = hn::IfThenElseZero(RowsBelow(i, rows), Load(search.item + i));
      const PickedLights light = FetchLights(lights, index, samples);
      const std::uint32_t to = begin + i;
      Store3(light.direction, out.dir_x + to, out.dir_y + to, out.dir_z + to);
      Store3(light.irradiance, out.r + to, out.g + to, out.b + to);
      Store(delta, out.pdf + to);
    }
  }
}

void SplitUniforms(const float* u, std::uint32_t n, float share, float* rest) {
  const VF scale = Set(1.0f / (1.0f - share));
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    const VF value = (Load(u + i) - share) * scale;
    Store(Clamp(value, 0.0f, 0x1.fffffep-1f), rest + i);
  }
}

void PickOverSplit(const LightRecord* lights, const SearchTreeView& tree, const float* u,
                   std::uint32_t n, float share, float samples, const LightColumns& out) {
  const VF delta = Set(std::numeric_limits<float>::infinity());
  const VF inverse_share = Set(1.0f / share);
  SearchColumns search;
  for (std::uint32_t begin = 0; begin < n; begin += kChunk) {
    const std::uint32_t rows = std::min(kChunk, n - begin);
    for (std::uint32_t i = 0; i < rows; i += hn::Lanes(F())) {
      const VF scaled = Load(u + begin + i) * inverse_share;
      Store(Clamp(scaled, 0.0f, 0x1.fffffep-1f), search.x + i);
    }
    Search(tree, search.x, rows, search);
    for (std::uint32_t i = 0; i < rows; i += hn::Lanes(F())) {
      const std::uint32_t to = begin + i;
      const VU index = hn::IfThenElseZero(RowsBelow(i, rows), Load(search.item + i));
      const PickedLights light = FetchLights(lights, index, samples * share);
      const MF picked = hn::Lt(Load(u + to), Set(share));
      const V3 direction = Load3(out.dir_x + to, out.dir_y + to, out.dir_z + to);
      const V3 radiance = Load3(out.r + to, out.g + to, out.b + to);
      Store3(IfThen(picked, light.direction, direction), out.dir_x + to, out.dir_y + to,
             out.dir_z + to);
      Store3(IfThen(picked, light.irradiance, radiance), out.r + to, out.g + to, out.b + to);
      Store(IfThen(picked, delta, Load(out.pdf + to)), out.pdf + to);
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace skywave {

HWY_EXPORT(FillDirectional);
HWY_EXPORT(PickDirectional);
HWY_EXPORT(SplitUniforms);
HWY_EXPORT(PickOverSplit);

void FillDirectional(const LightRecord& light, std::uint32_t n, const LightColumns& out) {
  HWY_DYNAMIC_DISPATCH(FillDirectional)(light, n, out);
}
void PickDirectional(const LightRecord* lights, const SearchTreeView& tree, const float* u,
                     std::uint32_t n, float samples, const LightColumns& out) {
  HWY_DYNAMIC_DISPATCH(PickDirectional)(lights, tree, u, n, samples, out);
}
void SplitUniforms(const float* u, std::uint32_t n, float share, float* rest) {
  HWY_DYNAMIC_DISPATCH(SplitUniforms)(u, n, share, rest);
}
void PickOverSplit(const LightRecord* lights, const SearchTreeView& tree, const float* u,
                   std::uint32_t n, float share, float samples, const LightColumns& out) {
  HWY_DYNAMIC_DISPATCH(PickOverSplit)(lights, tree, u, n, share, samples, out);
}

}  // namespace skywave
#endif  // HWY_ONCE
