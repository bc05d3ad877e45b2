// These functions look up textures on vectors.
#if defined(SKYWAVE_KERNELS_TEXTURE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SKYWAVE_KERNELS_TEXTURE_INL_H_
#undef SKYWAVE_KERNELS_TEXTURE_INL_H_
#else
#define SKYWAVE_KERNELS_TEXTURE_INL_H_
#endif

#include "kernels/material_fields-inl.h"
#include "kernels/packed_radiance-inl.h"
#include "kernels/simd/math-inl.h"
#include "kernels/surface/instances-inl.h"
#include "kernels/surface/texture.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

// Brings a coordinate into [0, 1].
HWY_INLINE VF WrapCoordinate(VF u, VU wrap) {
  const VF one = Set(1.0f);
  const VF repeated = u - hn::Floor(u);
  const VF half = u * 0.5f;
  const VF pair = 2.0f * (half - hn::Floor(half));
  const VF mirrored = one - hn::Abs(one - pair);
  const MF clamps = hn::RebindMask(F(), hn::Eq(wrap, SetU(std::uint32_t(TextureWrap::kClamp))));
  const MF mirrors = hn::RebindMask(F(), hn::Eq(wrap, SetU(std::uint32_t(TextureWrap::kMirror))));
  return IfThen(clamps, Clamp(u, 0.0f, 1.0f), IfThen(mirrors, mirrored, repeated));
}

// In a line of `count` texels, `at` in [0, 1] lies between the centres of these two; `share` is
// that of the second one.
struct Neighbours {
  HWY_INLINE Neighbours(VF at, VU count, VU wrap) {
    const VF size = ToFloat(count), last = size - 1.0f;
    // Texel i has its centre at (i + 1/2) / count.
    const VF x = at * size - 0.5f;
    const VF low = hn::Floor(x), high = low + 1.0f;
    share = x - low;
    const MF repeats = hn::RebindMask(F(), hn::Eq(wrap, SetU(std::uint32_t(TextureWrap::kRepeat))));
    const VF zero = hn::Zero(F());
    first = ToUnsigned(IfThen(hn::Lt(low, zero), IfThen(repeats, last, zero), low));
    second = ToUnsigned(IfThen(hn::Gt(high, last), IfThen(repeats, zero, last), high));
  }
  VU first, second;
  VF share;
};

// Reads the words of one texture's record per lane.
struct TextureLanes {
  HWY_INLINE TextureLanes(const TextureView& view, VU texture)
      : words(reinterpret_cast<const std::uint32_t*>(view.records)),
        at(hn::ShiftLeft<kLogTextureWords>(texture)) {}
  HWY_INLINE VU Word(std::uint32_t field) const { return Gather(words, at + SetU(field)); }
  HWY_INLINE VF Number(std::uint32_t field) const { return AsFloat(Word(field)); }

  const std::uint32_t* words;
  VU at;
};

// Returns the first word of the coordinates that each lane's texture has on its triangle.
HWY_INLINE VU UvsOf(const TextureView& view, const TextureLanes& record, VU triangle) {
  if (view.two_uv_sets) {
    triangle = triangle + record.Word(SKYWAVE_WORD(TextureRecord, first_uvs));
  }
  return hn::ShiftLeft<kLogUvWords>(triangle);
}

// Looks up one level of one texture per lane at barycentric (b1, b2) of its triangle, whose
// coordinates begin at word `uvs`. `unpack` turns packed texels into a V3.
template <class Unpack>
HWY_INLINE V3 LookUpLevel(const TextureView& view, const TextureLanes& record, VU level, VU uvs,
                          VF b1, VF b2, const Unpack& unpack) {
  const auto* corners = reinterpret_cast<const float*>(view.uvs);
  const auto corner = [&](std::uint32_t f) HWY_ATTR { return Gather(corners, uvs + SetU(f)); };
  const VF b0 = 1.0f - b1 - b2;
  const auto interpolate = [&](std::uint32_t f) HWY_ATTR {
    return corner(f) * b0 + corner(f + 2) * b1 + corner(f + 4) * b2;
  };
  const VF u = interpolate(0), v = interpolate(1);
  constexpr std::uint32_t kTransform = SKYWAVE_WORD(TextureRecord, transform);
  const auto transformed = [&](std::uint32_t row) HWY_ATTR {
    const VF along_u = record.Number(row) * u, along_v = record.Number(row + 1) * v;
    return along_u + along_v + record.Number(row + 2);
  };
  const VF tu = transformed(kTransform), tv = transformed(kTransform + 3);

  const auto* levels = reinterpret_cast<const std::uint32_t*>(view.levels);
  const VU entry = hn::ShiftLeft<kLogLevelWords>(level);
  const auto of_level = [&](std::uint32_t f) HWY_ATTR { return Gather(levels, entry + SetU(f)); };
  const VU first = of_level(SKYWAVE_WORD(TextureLevel, first_texel)),
           columns = of_level(SKYWAVE_WORD(TextureLevel, width)),
           rows = of_level(SKYWAVE_WORD(TextureLevel, height));
  const VU wrap_u = record.Word(SKYWAVE_WORD(TextureRecord, wrap_u)),
           wrap_v = record.Word(SKYWAVE_WORD(TextureRecord, wrap_v));
  const Neighbours x(WrapCoordinate(tu, wrap_u), columns, wrap_u);
  const Neighbours y(WrapCoordinate(tv, wrap_v), rows, wrap_v);
  const auto texel = [&](VU column, VU row) HWY_ATTR {
    const VU place = first + (row * columns + column);
    return unpack(Gather(view.texels, place));
  };
  return Mix(Mix(texel(x.first, y.first), texel(x.second, y.first), x.share),
             Mix(texel(x.first, y.second), texel(x.second, y.second), x.share), y.share);
}

// Returns the number of texels of level 0 per unit of length in the world, of rows i and on, whose
// coordinates begin at word `uvs`.
template <class Textured>
HWY_INLINE VF TexelsALength(const TextureView& view, const Textured& textured,
                            const TextureLanes& record, VU uvs, const SurfaceColumns& s,
                            std::uint32_t i) {
  const auto* corners = reinterpret_cast<const float*>(view.uvs);
  VF density = Gather(corners, uvs + SetU(SKYWAVE_WORD(TriangleUvs, density)));
  if (view.instances != nullptr) {
    const InstanceLanes instance(view.instances, s, i, hn::RebindMask(U(), textured.lanes));
    const V3 ng = Load3(s.ng_x + i, s.ng_y + i, s.ng_z + i);
    density = density * hn::Sqrt(instance.AreaInObject(ng));
  }
  return density * record.Number(SKYWAVE_WORD(TextureRecord, texels));
}

// Finds the lanes of rows below n whose material has a texture in word `field` of its record of
// 2^kLogWords words, and what they look up; the others look up texture 0 at triangle 0.
template <int kLogWords>
struct TexturedLanes {
  HWY_INLINE TexturedLanes(const void* records, std::uint32_t field, const SurfaceColumns& s,
                           std::uint32_t i, std::uint32_t n) {
    const auto* words = static_cast<const std::uint32_t*>(records);
    const MU inside = RowsBelow(i, n);
    material = hn::IfThenElseZero(inside, hn::And(Load(s.material + i), SetU(kMaterialMask)));
    const VU named = Gather(words, hn::ShiftLeft<kLogWords>(material) + SetU(field));
    const MU has = hn::And(inside, hn::Ne(named, hn::Zero(U())));
    any = !hn::AllFalse(U(), has);
    lanes = hn::RebindMask(F(), has);
    texture = hn::IfThenElseZero(has, named - SetU(1));
    triangle = hn::IfThenElseZero(has, Load(s.triangle + i));
  }
  bool any;
  MF lanes;
  VU material, texture, triangle;
};

// Looks up one texture per lane (TexturedLanes), at the level that the ray's cone asks for.
template <class Textured, class Unpack>
HWY_INLINE V3 LookUp(const TextureView& view, const Textured& textured, float pixel_angle,
                     const SurfaceColumns& s, std::uint32_t i, const Unpack& unpack) {
  const TextureLanes record(view, textured.texture);
  const VU uvs = UvsOf(view, record, textured.triangle);
  // The number of texels across the cone is squared, so the level is half the exponent.
  const VF cosine = hn::Max(
      Dot(Load3(s.ng_x + i, s.ng_y + i, s.ng_z + i), Load3(s.wo_x + i, s.wo_y + i, s.wo_z + i)),
      Set(0.01f));
  const VF width = Load(s.t + i) * pixel_angle * TexelsALength(view, textured, record, uvs, s, i);
  const VF area = hn::Max(width * width / cosine, Set(1.0f));
  const VU exponent = hn::And(hn::ShiftRight<23>(AsBits(area)), SetU(0xFFu));
  const VU wanted = hn::ShiftRight<1>(exponent - SetU(127));
  const VU last = record.Word(SKYWAVE_WORD(TextureRecord, levels)) - SetU(1);
  const VU level = record.Word(SKYWAVE_WORD(TextureRecord, first_level)) + hn::Min(wanted, last);
  // Padding rows may hold anything, which would be no place on an image.
  const VF b1 = hn::IfThenElseZero(textured.lanes, Load(s.u + i));
  const VF b2 = hn::IfThenElseZero(textured.lanes, Load(s.v + i));
  return LookUpLevel(view, record, level, uvs, b1, b2, unpack);
}

HWY_INLINE V3 UnpackColor(VU packed) { return UnpackRadiance(packed, 1.0f); }

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
