#include "kernels/surface/texture.h"

#include <algorithm>
#include <bit>
#include <cmath>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/surface/texture.cc"
#include "hwy/foreach_target.h"
#include "hwy/highway.h"
#include "kernels/packed_radiance.h"
#include "kernels/surface/facet_turn-inl.h"
#include "kernels/surface/texture-inl.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

void TextureColors(const TextureView& view, const MaterialRecord* materials, float pixel_angle,
                   std::uint32_t n, const SurfaceColumns& s) {
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    const TexturedLanes<kLogMaterialWords> textured(
        materials, SKYWAVE_WORD(MaterialRecord, color_texture), s, i, n);
    if (!textured.any) continue;
    const V3 seen = LookUp(view, textured, pixel_angle, s, i, UnpackColor);
    const V3 color = Load3(s.color_r + i, s.color_g + i, s.color_b + i);
    Store3(IfThen(textured.lanes, color * seen, color), s.color_r + i, s.color_g + i,
           s.color_b + i);
  }
}

void TintByVertices(const std::uint32_t* colors, std::uint32_t n, const SurfaceColumns& s) {
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    const MU inside = RowsBelow(i, n);
    const VU triangle = hn::IfThenElseZero(inside, Load(s.triangle + i));
    const VU first = triangle + (triangle + triangle);
    const auto corner = [&](std::uint32_t c)
                            HWY_ATTR { return UnpackColor(Gather(colors, first + SetU(c))); };
    const VF u = Load(s.u + i), v = Load(s.v + i), w = 1.0f - u - v;
    const V3 tint = corner(0) * w + corner(1) * u + corner(2) * v;
    const V3 color = Load3(s.color_r + i, s.color_g + i, s.color_b + i);
    Store3(IfThen(hn::RebindMask(F(), inside), color * tint, color), s.color_r + i, s.color_g + i,
           s.color_b + i);
  }
}

// Writes alpha, times the texture's green channel squared, and another field of materials times
// what `factor` makes of the texture, not below `least` nor above 1.
template <class Factor>
HWY_INLINE void PrepareAlphaAnd(MaterialField second_field, float least, const Factor& factor,
                                const TextureView& view, const MaterialRecord* materials,
                                float pixel_angle, std::uint32_t n, const SurfaceColumns& s) {
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    const VU fields = MaterialFields(s, i, n);
    VF alpha = Field(materials, fields, MaterialField::kAlpha);
    VF second = Field(materials, fields, second_field);
    if (view.records != nullptr) {
      const TexturedLanes<kLogMaterialWords> textured(
          materials, SKYWAVE_WORD(MaterialRecord, roughness_texture), s, i, n);
      if (textured.any) {
        const V3 seen = LookUp(view, textured, pixel_angle, s, i, UnpackColor);
        const VF wider = alpha * (seen.y * seen.y);
        alpha = IfThen(textured.lanes, Clamp(wider, 1e-3f, 1.0f), alpha);
        const VF scaled = second * factor(seen);
        second = IfThen(textured.lanes, Clamp(scaled, least, 1.0f), second);
      }
    }
    StoreBelow(alpha, s.varying_0, i, n);
    StoreBelow(second, s.varying_1, i, n);
  }
}

void PrepareMetallicRoughness(const TextureView& view, const MaterialRecord* materials,
                              float pixel_angle, std::uint32_t n, const SurfaceColumns& s) {
  const auto metallic = [](const V3& seen) HWY_ATTR { return seen.z; };
  PrepareAlphaAnd(MaterialField::kMetallic, 0.0f, metallic, view, materials, pixel_angle, n, s);
}

void PrepareCoatWidths(const TextureView& view, const MaterialRecord* materials, float pixel_angle,
                       std::uint32_t n, const SurfaceColumns& s) {
  const auto width = [](const V3& seen) HWY_ATTR { return seen.x * seen.x; };
  PrepareAlphaAnd(MaterialField::kCoatAlpha, 1e-3f, width, view, materials, pixel_angle, n, s);
}

void PrepareTwoWidths(const TextureView& view, const MaterialRecord* materials,
                      MaterialField across_field, bool only_textured, float pixel_angle,
                      std::uint32_t n, const SurfaceColumns& s) {
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    const VU fields = MaterialFields(s, i, n);
    VF along = Field(materials, fields, MaterialField::kAlpha);
    VF across = Field(materials, fields, across_field);
    const MF nowhere = hn::Lt(across, across);
    MF written = only_textured ? nowhere : hn::Not(nowhere);
    if (view.records != nullptr) {
      const TexturedLanes<kLogMaterialWords> textured(
          materials, SKYWAVE_WORD(MaterialRecord, roughness_texture), s, i, n);
      if (textured.any) {
        const V3 seen = LookUp(view, textured, pixel_angle, s, i, UnpackColor);
        const VF wider = along * (seen.y * seen.y);
        along = IfThen(textured.lanes, Clamp(wider, 1e-3f, 1.0f), along);
        const VF wider_across = Clamp(across * (seen.x * seen.x), 1e-3f, 1.0f);
        const MF two = hn::And(textured.lanes, hn::Gt(across, hn::Zero(F())));
        across = IfThen(two, wider_across, across);
        written = hn::Or(written, textured.lanes);
      }
    }
    const VF cosine = Load(s.varying_0 + i);
    const VF sine = Load(s.varying_1 + i);
    const MF back = hn::RebindMask(F(), hn::TestBit(Load(s.material + i), SetU(kBackFace)));
    const FacetTurn turn = {cosine, IfThen(back, -sine, sine), across};
    StoreBelow(IfThen(written, along, cosine), s.varying_0, i, n);
    StoreBelow(IfThen(written, PackFacetTurn(turn), sine), s.varying_1, i, n);
  }
}

void PrepareSecondColor(const TextureView& view, const MaterialRecord* materials, float pixel_angle,
                        std::uint32_t n, const SurfaceColumns& s) {
  const VF one = Set(1.0f);
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    V3 color = {one, one, one};
    if (view.records != nullptr) {
      const TexturedLanes<kLogMaterialWords> textured(
          materials, std::uint32_t(MaterialField::kSecondTexture), s, i, n);
      if (textured.any) {
        color =
            IfThen(textured.lanes, LookUp(view, textured, pixel_angle, s, i, UnpackColor), color);
      }
    }
    const auto share = [&](VF x)
                           HWY_ATTR { return ToUnsigned(Clamp(x, 0.0f, 1.0f) * 65535.0f + 0.5f); };
    const VU pair = hn::Or(share(color.x), hn::ShiftLeft<16>(share(color.y)));
    StoreBelow(AsFloat(pair), s.varying_0, i, n);
    StoreBelow(Clamp(color.z, 0.0f, 1.0f), s.varying_1, i, n);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace skywave {
namespace {

// Returns std::floor without a call, for values below 2^63.
float Floor(float x) {
  const float whole = float(std::int64_t(x));
  return whole > x ? whole - 1 : whole;
}

// This is Neighbours of texture-inl.h, preceded by the wrapping.
struct ScalarNeighbours {
  ScalarNeighbours(float at, std::uint32_t count, TextureWrap wrap) {
    const float half = at * 0.5f;
    const float pair = 2.0f * (half - Floor(half));
    const float inside = wrap == TextureWrap::kClamp    ? std::min(std::max(at, 0.0f), 1.0f)
                         : wrap == TextureWrap::kMirror ? 1.0f - std::fabs(1.0f - pair)
                                                        : at - Floor(at);
    const float last = float(count) - 1.0f, x = inside * float(count) - 0.5f;
    const float low = Floor(x), high = low + 1.0f;
    const bool repeats = wrap == TextureWrap::kRepeat;
    first = std::uint32_t(low < 0 ? (repeats ? last : 0.0f) : low);
    second = std::uint32_t(high > last ? (repeats ? 0.0f : last) : high);
    share = x - low;
  }
  std::uint32_t first, second;
  float share;
};

}  // namespace

HWY_EXPORT(TextureColors);
HWY_EXPORT(TintByVertices);
HWY_EXPORT(PrepareMetallicRoughness);
HWY_EXPORT(PrepareCoatWidths);
HWY_EXPORT(PrepareTwoWidths);
HWY_EXPORT(PrepareSecondColor);

void TextureColors(const TextureView& textures, const MaterialRecord* materials, float pixel_angle,
                   std::uint32_t n, const SurfaceColumns& surfaces) {
  HWY_DYNAMIC_DISPATCH(TextureColors)(textures, materials, pixel_angle, n, surfaces);
}
void TintByVertices(const std::uint32_t* colors, std::uint32_t n, const SurfaceColumns& surfaces) {
  HWY_DYNAMIC_DISPATCH(TintByVertices)(colors, n, surfaces);
}
void PrepareMetallicRoughness(const TextureView& textures, const MaterialRecord* materials,
                              float pixel_angle, std::uint32_t n, const SurfaceColumns& surfaces) {
  HWY_DYNAMIC_DISPATCH(PrepareMetallicRoughness)(textures, materials, pixel_angle, n, surfaces);
}
void PrepareCoatWidths(const TextureView& textures, const MaterialRecord* materials,
                       float pixel_angle, std::uint32_t n, const SurfaceColumns& surfaces) {
  HWY_DYNAMIC_DISPATCH(PrepareCoatWidths)(textures, materials, pixel_angle, n, surfaces);
}
void PrepareTwoWidths(const TextureView& textures, const MaterialRecord* materials,
                      MaterialField across, bool only_textured, float pixel_angle, std::uint32_t n,
                      const SurfaceColumns& surfaces) {
  HWY_DYNAMIC_DISPATCH(PrepareTwoWidths)
  (textures, materials, across, only_textured, pixel_angle, n, surfaces);
}
void PrepareSecondColor(const TextureView& textures, const MaterialRecord* materials,
                        float pixel_angle, std::uint32_t n, const SurfaceColumns& surfaces) {
  HWY_DYNAMIC_DISPATCH(PrepareSecondColor)(textures, materials, pixel_angle, n, surfaces);
}

float FirstChannel(const TextureView& textures, std::uint32_t texture, std::uint32_t triangle,
                   float u, float v) {
  const TextureRecord& record = textures.records[texture];
  const float(&uv)[3][2] = textures.uvs[record.first_uvs + triangle].uv;
  const float w = 1.0f - u - v;
  const float s = uv[0][0] * w + uv[1][0] * u + uv[2][0] * v;
  const float t = uv[0][1] * w + uv[1][1] * u + uv[2][1] * v;
  const float* m = record.transform;
  const TextureLevel& level = textures.levels[record.first_level];
  const ScalarNeighbours x(m[0] * s + m[1] * t + m[2], level.width, record.wrap_u);
  const ScalarNeighbours y(m[3] * s + m[4] * t + m[5], level.height, record.wrap_v);
  const auto texel = [&](std::uint32_t column, std::uint32_t row) {
    const std::uint32_t packed = textures.texels[level.first_texel + row * level.width + column];
    const std::uint32_t exponent = (packed >> 3 * kMantissaBits) + 127 - kMaxExponent;
    return float(packed & ((1u << kMantissaBits) - 1)) * std::bit_cast<float>(exponent << 23);
  };
  const auto mix = [](float a, float b, float share) { return a + (b - a) * share; };
  return mix(mix(texel(x.first, y.first), texel(x.second, y.first), x.share),
             mix(texel(x.first, y.second), texel(x.second, y.second), x.share), y.share);
}

std::uint32_t PackTexel(const float* rgb) {
  constexpr std::uint32_t kMantissa = (1u << kMantissaBits) - 1;
  float channel[3];
  for (int c = 0; c < 3; ++c) channel[c] = rgb[c] > 0 ? std::min(rgb[c], float(kMantissa)) : 0.0f;
  const float brightest = std::max({channel[0], channel[1], channel[2]});
  if (!(brightest > 0)) return 0;
  // The brightest mantissa is at least 2^8; rounding may lift it to 2^9, which takes the next
  // exponent.
  const int power = int(std::bit_cast<std::uint32_t>(brightest) >> 23) - 127;
  int exponent =
      std::clamp(power - int(kMantissaBits - 1) + int(kMaxExponent), 0, int(kMaxExponent));
  const auto rounded = [&](float value) {
    const double scale = double(std::uint64_t{1} << (int(kMaxExponent) - exponent));
    return std::uint32_t(value * scale + 0.5);
  };
  if (rounded(brightest) > kMantissa) exponent = std::min(exponent + 1, int(kMaxExponent));
  std::uint32_t packed = std::uint32_t(exponent) << 3 * kMantissaBits;
  for (int c = 0; c < 3; ++c) {
    packed |= std::min(rounded(channel[c]), kMantissa) << c * kMantissaBits;
  }
  return packed;
}

}  // namespace skywave
#endif  // HWY_ONCE
