#include "kernels/surface/layers.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/surface/layers.cc"
#include "hwy/foreach_target.h"
#include "hwy/highway.h"
#include "kernels/surface/layers-inl.h"
#include "kernels/surface/surface.h"
#include "kernels/surface/texture-inl.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

// Returns the square root of a number in [0, 1] as a byte.
HWY_INLINE VU RootByte(VF x) { return ByteOf(hn::Sqrt(Clamp(x, 0.0f, 1.0f))); }
// Returns varying_2.
HWY_INLINE VF PackSpecular(const V3& color, VF specular) {
  return Bytes(RootByte(color.x), RootByte(color.y), RootByte(color.z), ByteOf(specular));
}

// Turns the tangent that PrepareTangents has written by the grain of the material and by its
// texture, counter-clockwise as seen from the side that the mesh's normals point to, or clockwise
// where the triangle mirrors images, and packs it as if it were seen from there.
HWY_INLINE VF PackGrain(VF cosine, VF sine, const V3& image, VF grain_x, VF grain_y, MF mirrored,
                        MF back) {
  const VF front = IfThen(back, -sine, sine);
  const VF x = image.x * grain_x - image.y * grain_y;
  const VF turn = image.x * grain_y + image.y * grain_x, y = IfThen(mirrored, -turn, turn);
  const VF c = cosine * x - front * y, s = front * x + cosine * y;
  // Without a length, which only rounding leaves, it is the tangent.
  const MF usable = hn::Gt(c * c + s * s, Set(1e-12f));
  return PackFacetTurn({IfThen(usable, c, cosine), IfThen(usable, s, front), hn::Zero(F())});
}

// Looks up textures that materials name in a field of their records, at rows from i on.
struct NamedTextures {
  // Returns `otherwise` where there is no texture.
  HWY_INLINE V3 LookUpOr(MaterialField texture, const V3& otherwise) const {
    if (view.records == nullptr) return otherwise;
    const TexturedLanes<kLogMaterialWords> textured(materials, std::uint32_t(texture), s, i, n);
    if (!textured.any) return otherwise;
    return IfThen(textured.lanes, LookUp(view, textured, pixel_angle, s, i, UnpackColor),
                  otherwise);
  }

  const TextureView& view;
  const MaterialRecord* materials;
  float pixel_angle;
  const SurfaceColumns& s;
  std::uint32_t i, n;
};

void PrepareLayers(const TextureView& view, const MaterialRecord* materials,
                   const std::uint32_t* tangents, float pixel_angle, std::uint32_t n,
                   const SurfaceColumns& s) {
  const VF one = Set(1.0f), zero = hn::Zero(F());
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    const NamedTextures textures = {view, materials, pixel_angle, s, i, n};
    const auto look_up = [&](MaterialField texture, const V3& otherwise)
                             HWY_ATTR { return textures.LookUpOr(texture, otherwise); };
    const V3 white = {one, one, one};
    const V3 base = look_up(MaterialField::kRoughnessTexture, white);
    const V3 sheen = look_up(MaterialField::kSheenTexture, white);
    const V3 color = look_up(MaterialField::kSpecularColorTexture, white);
    const VF coat_roughness = look_up(MaterialField::kCoatAlphaTexture, white).y;
    const VF sheen_roughness = look_up(MaterialField::kSheenAlphaTexture, white).y;
    const VF specular = look_up(MaterialField::kSpecularTexture, white).y;
    const VF film = look_up(MaterialField::kFilmTexture, white).y;
    const VF thickness = look_up(MaterialField::kFilmThicknessTexture, white).y;

    VF turn = zero, anisotropy = one;
    if (tangents != nullptr) {
      const V3 grain = look_up(MaterialField::kAnisotropyTexture, {one, Set(0.5f), one});
      anisotropy = grain.z;
      const VU fields = MaterialFields(s, i, n);
      const VU triangle = hn::IfThenElseZero(RowsBelow(i, n), Load(s.triangle + i));
      const MF mirrored =
          hn::RebindMask(F(), hn::TestBit(Gather(tangents, triangle), SetU(kMirroredTangent)));
      const MF back = hn::RebindMask(F(), hn::TestBit(Load(s.material + i), SetU(kBackFace)));
      turn = PackGrain(Load(s.varying_0 + i), Load(s.varying_1 + i), grain * 2.0f - white,
                       Field(materials, fields, MaterialField::kGrain, 0),
                       Field(materials, fields, MaterialField::kGrain, 1), mirrored, back);
    }
    StoreBelow(
        Bytes(ByteOf(base.y), ByteOf(base.z), ByteOf(coat_roughness), ByteOf(sheen_roughness)),
        s.varying_0, i, n);
    StoreBelow(Bytes(RootByte(sheen.x), RootByte(sheen.y), RootByte(sheen.z), LowTurn(turn)),
               s.varying_1, i, n);
    StoreBelow(PackSpecular(color, specular), s.varying_2, i, n);
    StoreBelow(Bytes(ByteOf(film), ByteOf(thickness), ByteOf(anisotropy), HighTurn(turn)),
               s.varying_3, i, n);
  }
}

void PrepareGlassLayers(const TextureView& view, const MaterialRecord* materials, float pixel_angle,
                        std::uint32_t n, const SurfaceColumns& s) {
  const VU none = hn::Zero(U());
  const V3 white = Splat(Set(1.0f));
  for (std::uint32_t i = 0; i < n; i += hn::Lanes(F())) {
    const NamedTextures textures = {view, materials, pixel_angle, s, i, n};
    const V3 color = textures.LookUpOr(MaterialField::kSpecularColorTexture, white);
    const VF specular = textures.LookUpOr(MaterialField::kSpecularTexture, white).y;
    const VF film = textures.LookUpOr(MaterialField::kFilmTexture, white).y;
    const VF thickness = textures.LookUpOr(MaterialField::kFilmThicknessTexture, white).y;
    StoreBelow(PackSpecular(color, specular), s.varying_2, i, n);
    StoreBelow(Bytes(ByteOf(film), ByteOf(thickness), none, none), s.varying_3, i, n);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace skywave {

HWY_EXPORT(PrepareLayers);
HWY_EXPORT(PrepareGlassLayers);

void PrepareLayers(const TextureView& textures, const MaterialRecord* materials,
                   const std::uint32_t* tangents, float pixel_angle, std::uint32_t n,
                   const SurfaceColumns& surfaces) {
  HWY_DYNAMIC_DISPATCH(PrepareLayers)(textures, materials, tangents, pixel_angle, n, surfaces);
}
void PrepareGlassLayers(const TextureView& textures, const MaterialRecord* materials,
                        float pixel_angle, std::uint32_t n, const SurfaceColumns& surfaces) {
  HWY_DYNAMIC_DISPATCH(PrepareGlassLayers)(textures, materials, pixel_angle, n, surfaces);
}

}  // namespace skywave
#endif  // HWY_ONCE
