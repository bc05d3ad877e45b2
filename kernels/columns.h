// This file declares the records that flow between stages, each of them once: as a struct of column
// pointers with one comment per column (meaning, unit or space, writer) and one visitor.
// wavefront/soa.h owns the memory; kernels and stages take these structs as they are.
//
// Every column is aligned to kColumnAlignment and has room for PaddedRows(rows) values: kernels run
// over whole vectors and may write anything into the padding after the last row, and nothing reads
// what they compute from it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>

namespace skywave {

inline constexpr std::size_t kColumnAlignment = 64;  // [bytes], one cache line
inline constexpr std::uint32_t kPadRows = 16;        // widest vector of 32-bit lanes

// Returns the room for `rows` rows and for a store of a whole vector that begins at any of them.
constexpr std::uint32_t PaddedRows(std::uint32_t rows) {
  return (rows + kPadRows - 1) / kPadRows * kPadRows + kPadRows;
}

// The BSDFs, one line each. A file of kernels/bsdf defines NameKernels(), and everything else
// follows from it. Each BSDF has a queue, in this order. Those of the first list take light
// samples; those of the second list are delta distributions, which no light sample can meet.
#define SKYWAVE_DENSE_BSDFS(BSDF) \
  BSDF(Lambert)                   \
  BSDF(Conductor)                 \
  BSDF(MetallicRoughness)         \
  BSDF(OrenNayar)                 \
  BSDF(DiffuseTransmission)       \
  BSDF(RoughDielectric)           \
  BSDF(AnisotropicConductor)      \
  BSDF(BeckmannConductor)         \
  BSDF(Phong)                     \
  BSDF(Blinn)                     \
  BSDF(Ward)                      \
  BSDF(CoatedMetallicRoughness)   \
  BSDF(CoatedConductor)           \
  BSDF(CoatedDiffuse)             \
  BSDF(Measured)                  \
  BSDF(RoughThinDielectric)       \
  BSDF(GlossyDiffuse)             \
  BSDF(FresnelBlend)              \
  BSDF(LayeredMetallicRoughness)  \
  BSDF(CoatedDiffuseTransmission) \
  BSDF(CoatedRoughDielectric)     \
  BSDF(CoatedRoughThinDielectric)
#define SKYWAVE_DELTA_BSDFS(BSDF) \
  BSDF(Mirror)                    \
  BSDF(Dielectric)                \
  BSDF(ThinDielectric)

#define SKYWAVE_KIND(name) k##name,
#define SKYWAVE_COUNT(name) +1
enum class BsdfKind : std::uint32_t {
  SKYWAVE_DENSE_BSDFS(SKYWAVE_KIND) SKYWAVE_DELTA_BSDFS(SKYWAVE_KIND)
};
inline constexpr std::uint32_t kFirstDeltaBsdf = 0 SKYWAVE_DENSE_BSDFS(SKYWAVE_COUNT);
inline constexpr std::uint32_t kBsdfKinds = kFirstDeltaBsdf SKYWAVE_DELTA_BSDFS(SKYWAVE_COUNT);
#undef SKYWAVE_KIND
#undef SKYWAVE_COUNT

inline constexpr std::uint32_t kNoHit = 0xFFFFFFFFu;  // HitColumns::geom of a ray that hit nothing

// One row is one path of the wave. Generate writes it; its radiance grows until the film takes it.
struct PathColumns {
  std::uint32_t* seed;    // hash of pixel and frame seed: decorrelates pixels
  std::uint32_t* sample;  // index of the sample in its pixel
  std::uint32_t* pixel;   // row-major index in the film
  float *r, *g, *b;       // radiance gathered so far [scene radiance]

  template <class Self, class F>
  static constexpr void ForEachColumn(Self& self, F f) {
    f(self.seed), f(self.sample), f(self.pixel);
    f(self.r), f(self.g), f(self.b);
  }
};

// One row is one active ray. Generate and scatter write it; intersect writes t_far, too.
struct RayColumns {
  float *org_x, *org_y, *org_z;                       // world space
  float *dir_x, *dir_y, *dir_z;                       // world space, unit length
  float* t_far;                                       // in: infinity, out: distance of the hit
  float *throughput_r, *throughput_g, *throughput_b;  // product of f cos / pdf along the path
  float* pdf;           // density of dir by BSDF sampling [1/sr]; 0: no density
  std::uint32_t* path;  // row in PathColumns
  std::uint32_t* from;  // row in SurfaceColumns of the bounce before

  template <class Self, class F>
  static constexpr void ForEachColumn(Self& self, F f) {
    f(self.org_x), f(self.org_y), f(self.org_z);
    f(self.dir_x), f(self.dir_y), f(self.dir_z);
    f(self.t_far);
    f(self.throughput_r), f(self.throughput_g), f(self.throughput_b);
    f(self.pdf), f(self.path), f(self.from);
  }
};

// One row is the hit of the ray in the same row. Intersect writes it; it means nothing where geom
// is kNoHit, because Embree leaves the other columns as they were.
struct HitColumns {
  float *ng_x, *ng_y, *ng_z;  // geometric normal, world space, not normalised, as wound
  float *u, *v;               // barycentric coordinates of corners 1 and 2
  std::uint32_t* triangle;    // index into the triangle records
  // kNoHit, 0 for a triangle of the world, or 1 + i for one of the object of instance i.
  std::uint32_t* geom;

  template <class Self, class F>
  static constexpr void ForEachColumn(Self& self, F f) {
    f(self.ng_x), f(self.ng_y), f(self.ng_z);
    f(self.u), f(self.v), f(self.triangle), f(self.geom);
  }
};

// EscapeColumns::pdf of a ray without a density that sees the texels of an unbiased strategy
// (EnvStrategy::unbiased) all the same.
inline constexpr float kSeesTexels = -1;

// One row is one ray that met light: it left the scene or hit an emitter. Partition writes it, and
// the environment strategy writes radiance and light_pdf; or the kernel of local lights writes all.
struct EscapeColumns {
  float *dir_x, *dir_y, *dir_z;  // world space, unit length
  float *throughput_r, *throughput_g, *throughput_b;
  float* pdf;                                   // as in RayColumns, or kSeesTexels
  std::uint32_t* path;                          // row in PathColumns
  std::uint32_t* from;                          // row in SurfaceColumns of the bounce before
  float *radiance_r, *radiance_g, *radiance_b;  // the light that the ray sees
  float* light_pdf;                             // density of dir by light samples [1/sr]

  template <class Self, class F>
  static constexpr void ForEachColumn(Self& self, F f) {
    f(self.dir_x), f(self.dir_y), f(self.dir_z);
    f(self.throughput_r), f(self.throughput_g), f(self.throughput_b);
    f(self.pdf), f(self.path), f(self.from);
    f(self.radiance_r), f(self.radiance_g), f(self.radiance_b), f(self.light_pdf);
  }
};

// One row is one point to shade; the rows of a BSDF are contiguous (SurfaceRanges). Partition moves
// the first block here, and surface preparation computes the second one.
struct SurfaceColumns {
  float *wo_x, *wo_y, *wo_z;  // world space, unit, towards the eye
  float *ng_x, *ng_y, *ng_z;  // in: as in HitColumns; out: unit, on wo's side
  float *throughput_r, *throughput_g, *throughput_b;  // before this surface scatters
  float* t;                                           // distance along the ray
  float *u, *v;                                       // barycentric
  std::uint32_t* triangle;                            // index into the triangle records
  std::uint32_t* path;                                // row in PathColumns
  std::uint32_t* instance;             // as HitColumns::geom; unset in scenes without instances
  float *org_x, *org_y, *org_z;        // the hit, lifted by `lift` along ng
  float *ns_x, *ns_y, *ns_z;           // shading normal, unit, on wo's side
  float *color_r, *color_g, *color_b;  // reflectance at the hit
  // The distance between the hit and org. It is negative where org lies behind the surface, because
  // a BSDF that transmits has put it on the side of the current light sample.
  float* lift;
  std::uint32_t* material;  // row in MaterialTable | kBackFace
  // The light strategy may keep a number here, from the light samples of the row to the rays that
  // leave it.
  float* light_norm;
  // The parameters of the row's BSDF that vary over a surface; BsdfTraits::varying says which.
  float *varying_0, *varying_1;
  float *varying_2, *varying_3;  // of Varying::kLayers and BsdfTraits::glass_layers alone
  // Likewise, and only with MaterialView::base_normals: the normal of what lies below a coat
  // (EncodeNormal), world space, which may face away from wo, or kSameNormal, where it is ns.
  std::uint32_t* base_normal;

  template <class Self, class F>
  static constexpr void ForEachColumn(Self& self, F f) {
    f(self.wo_x), f(self.wo_y), f(self.wo_z);
    f(self.ng_x), f(self.ng_y), f(self.ng_z);
    f(self.throughput_r), f(self.throughput_g), f(self.throughput_b);
    f(self.t), f(self.u), f(self.v), f(self.triangle), f(self.path), f(self.instance);
    f(self.org_x), f(self.org_y), f(self.org_z);
    f(self.ns_x), f(self.ns_y), f(self.ns_z);
    f(self.color_r), f(self.color_g), f(self.color_b);
    f(self.lift), f(self.material), f(self.light_norm);
    f(self.varying_0), f(self.varying_1), f(self.varying_2), f(self.varying_3);
    f(self.base_normal);
  }
};
inline constexpr std::uint32_t kSameNormal = 0x80008000;  // which EncodeNormal never returns

// Rows [begin[k], begin[k + 1]) of the surface table belong to BSDF k.
struct SurfaceRanges {
  std::uint32_t begin[kBsdfKinds + 1] = {};
  std::uint32_t count(std::uint32_t kind) const { return begin[kind + 1] - begin[kind]; }
  std::uint32_t total() const { return begin[kBsdfKinds]; }
  std::uint32_t light_sampled() const { return begin[kFirstDeltaBsdf]; }
};

// The density of samples of the scene's lights without extent. It is finite, which distinguishes
// them from lights that stand for a part of a map.
inline constexpr float kPunctual = std::numeric_limits<float>::max();

// One row is one light sample, and then one shadow ray, of the surface in the same row. The
// strategy and local lights write it; the BSDF turns radiance into the contribution and closes
// t_far where there is none.
struct LightColumns {
  float *dir_x, *dir_y, *dir_z;  // world space, unit, towards the light
  float *r, *g, *b;              // in: radiance; out: the path's gain if nothing is in between
  // The samples of the surface per steradian around dir [1/sr]. Where it is not positive there is
  // no sample. From kPunctual on the light has no extent: r, g, b are its irradiance, and no BSDF
  // sample can meet it.
  float* pdf;
  float* t_far;  // distance of the light or infinity; negative: nothing to trace, or occluded

  template <class Self, class F>
  static constexpr void ForEachColumn(Self& self, F f) {
    f(self.dir_x), f(self.dir_y), f(self.dir_z);
    f(self.r), f(self.g), f(self.b), f(self.pdf), f(self.t_far);
  }
};

// Uniform random numbers in [0, 1) of one pair of dimensions; a row belongs to a path or a surface.
struct UniformColumns {
  float *u, *v;

  template <class Self, class F>
  static constexpr void ForEachColumn(Self& self, F f) {
    f(self.u), f(self.v);
  }
};

// The luminance of linear RGB has these weights, which are those of image/image.h.
inline constexpr float kLuminance[3] = {0.2125f, 0.7154f, 0.0721f};

// Returns a slice of a table: the same columns from row `begin` on.
template <class Columns>
Columns Slice(Columns columns, std::uint32_t begin) {
  Columns::ForEachColumn(columns, [begin](auto*& column) { column += begin; });
  return columns;
}

// ---- Tables of a scene: written once, then only read, at random, so a record lies together ----

// A triangle as shading knows it: 16 bytes, one gather of a line.
struct TriangleRecord {
  std::uint32_t normal[3];  // of the corners, octahedral, 16 bits a coordinate (EncodeNormal)
  std::uint32_t tag;        // material | kFlatTriangle and its like | kind << kKindShift
};
inline constexpr std::uint32_t kMaterialMask = (1u << 20) - 1;
inline constexpr std::uint32_t kFlatTriangle = 1u << 20;  // shaded with its geometric normal
// The tag of a mixture of two materials, whose record is not shaded itself: normal[0] is the row of
// a record of the same triangle with the first material, and the next row has the second one;
// normal[1] is the share of the second one, a float's bits; normal[2] is the mixture, a material.
inline constexpr std::uint32_t kMixedTriangle = 1u << 21;
// Camera rays pass through one side of the triangle: the one that its normals point away from or,
// where its corners were turned to agree with the normals, the other one.
inline constexpr std::uint32_t kOneSidedTriangle = 1u << 22;
inline constexpr std::uint32_t kTurnedTriangle = 1u << 23;
inline constexpr std::uint32_t kKindShift = 24;

// Returns true if the camera does not see that side of a triangle. `normal_side` is the side that
// the geometric normal is on.
inline bool IsHiddenSide(std::uint32_t tag, bool normal_side) {
  return (tag & kOneSidedTriangle) != 0 && normal_side == ((tag & kTurnedTriangle) != 0);
}

// Returns the material of a triangle, which may be a mixture.
inline std::uint32_t MaterialOf(const TriangleRecord& triangle) {
  return (triangle.tag & kMixedTriangle) != 0 ? triangle.normal[2] : triangle.tag & kMaterialMask;
}

inline constexpr std::uint32_t kBackFace = 1u << 31;  // in SurfaceColumns::material

// Returns the index of a member of a record among the record's words, for kernels that gather.
#define SKYWAVE_WORD(record, member) (offsetof(record, member) / sizeof(std::uint32_t))

// A material as its BSDF has packed it: 32 words, read by gathers. The members have the names of
// what most BSDFs keep in them; a BSDF that keeps something else there gives the word another name
// (MaterialField).
struct MaterialRecord {
  float color[3];               // reflectance
  float alpha;                  // width of microfacets
  float eta[3];                 // real part of a conductor's index
  float ior;                    // index inside / outside
  float k[3];                   // imaginary part of a conductor's index
  std::uint32_t color_texture;  // row in the texture table + 1; 0: none
  float multiscatter[3];        // Kulla and Conty 2017: factor of (1 - E(wo)) (1 - E(wi))
  // Row in the texture table + 1; 0: none. Its green channel scales the square root of alpha, its
  // red one that of the width across the tangent or of a coat over metal, and its blue one the
  // share of metal.
  std::uint32_t roughness_texture;

  // The rest is of layered metallic-roughness, which keeps its coat and its sheen as coated
  // metallic-roughness does (Material has their meanings), and of what lies over glass.
  float specular_color[3];
  float specular;
  float grain[2];  // anisotropy as a vector: cosine and sine of its turn, times its strength
  float film, film_ior;
  // Rows in the texture table + 1; 0: none.
  std::uint32_t sheen_texture, sheen_alpha_texture, coat_alpha_texture, specular_texture,
      specular_color_texture, anisotropy_texture, film_texture, film_thickness_texture;
};
inline constexpr int kLogMaterialWords = 5;
static_assert(sizeof(MaterialRecord) == sizeof(std::uint32_t) << kLogMaterialWords);

// The words of a MaterialRecord by name: what PutField (kernels/bsdf/pack.h) writes and Field
// (kernels/material_fields-inl.h) gathers. A field of three floats is named by its first word.
enum class MaterialField : std::uint32_t {
  kColor = SKYWAVE_WORD(MaterialRecord, color),
  kAlpha = SKYWAVE_WORD(MaterialRecord, alpha),
  kEta = SKYWAVE_WORD(MaterialRecord, eta),
  kIor = SKYWAVE_WORD(MaterialRecord, ior),
  kK = SKYWAVE_WORD(MaterialRecord, k),
  kColorTexture = SKYWAVE_WORD(MaterialRecord, color_texture),
  kMultiscatter = SKYWAVE_WORD(MaterialRecord, multiscatter),
  kRoughnessTexture = SKYWAVE_WORD(MaterialRecord, roughness_texture),
  // Other names of these words that more than one file needs; names of a single BSDF stand in its
  // own file.
  kAlphaAcross = kIor,  // anisotropic BSDFs: width across the tangent; alpha is that along it
  kMetallic = kEta,     // metallic-roughness: share of metal
  kSecondTexture = kRoughnessTexture,  // that of the second colour
  // Metallic-roughness under a coat and sheen.
  kClearCoat = SKYWAVE_WORD(MaterialRecord, k[0]),
  kClearCoatAlpha = SKYWAVE_WORD(MaterialRecord, k[1]),
  kSheenAlpha = SKYWAVE_WORD(MaterialRecord, k[2]),
  kSheen = SKYWAVE_WORD(MaterialRecord, multiscatter),
  // BSDFs with a table of their coat (kernels/bsdf/coat_tables.h): its index, its width, and
  // whether its medium makes it coloured.
  kCoatTable = SKYWAVE_WORD(MaterialRecord, multiscatter[0]),
  kCoatAlpha = SKYWAVE_WORD(MaterialRecord, multiscatter[1]),
  kCoatMedium = SKYWAVE_WORD(MaterialRecord, multiscatter[2]),
  // Rough dielectrics: the index of a table (kernels/bsdf/dielectric_tables.h) + 1, 0 without one;
  // DiffuseTransmittance; and the width across the tangent, 0 where there is one width.
  kDielectricTable = SKYWAVE_WORD(MaterialRecord, multiscatter[0]),
  kDielectricTransmittance = SKYWAVE_WORD(MaterialRecord, multiscatter[1]),
  kDielectricAcross = SKYWAVE_WORD(MaterialRecord, multiscatter[2]),
  // Thickness of the film where its texture is 0, and where it is 1: of layered metallic-roughness,
  // and of glass, whose eta is taken by its reflection.
  kFilmThin = SKYWAVE_WORD(MaterialRecord, eta[1]),
  kFilmThick = SKYWAVE_WORD(MaterialRecord, eta[2]),
  kGlassFilmThin = SKYWAVE_WORD(MaterialRecord, grain[0]),
  kGlassFilmThick = SKYWAVE_WORD(MaterialRecord, grain[1]),
  // The coat of glass, which has no sheen, and may have an inside where k is.
  kGlassCoat = SKYWAVE_WORD(MaterialRecord, sheen_texture),
  kGlassCoatAlpha = SKYWAVE_WORD(MaterialRecord, sheen_alpha_texture),
  kSpecularColor = SKYWAVE_WORD(MaterialRecord, specular_color),
  kSpecular = SKYWAVE_WORD(MaterialRecord, specular),
  kGrain = SKYWAVE_WORD(MaterialRecord, grain),  // two words
  kFilm = SKYWAVE_WORD(MaterialRecord, film),
  kFilmIor = SKYWAVE_WORD(MaterialRecord, film_ior),
  kSheenTexture = SKYWAVE_WORD(MaterialRecord, sheen_texture),
  kSheenAlphaTexture = SKYWAVE_WORD(MaterialRecord, sheen_alpha_texture),
  kCoatAlphaTexture = SKYWAVE_WORD(MaterialRecord, coat_alpha_texture),
  kSpecularTexture = SKYWAVE_WORD(MaterialRecord, specular_texture),
  kSpecularColorTexture = SKYWAVE_WORD(MaterialRecord, specular_color_texture),
  kAnisotropyTexture = SKYWAVE_WORD(MaterialRecord, anisotropy_texture),
  kFilmTexture = SKYWAVE_WORD(MaterialRecord, film_texture),
  kFilmThicknessTexture = SKYWAVE_WORD(MaterialRecord, film_thickness_texture),
  kGloss = kEta,       // a body and a gloss: colour of the gloss
  kReflection = kEta,  // dielectrics: that of Material, 0 where it is unset
  kAbsorption = kK     // BSDFs with an inside (BsdfTraits): absorption there [1/length], RGB
};

// A measured BRDF has the coordinates of the MERL database (Matusik et al. 2003): the half angle
// (bins of equal size in its square root), the angle between half vector and wi, and the azimuth of
// wi about the half vector, over half a turn. The last one runs fastest; a bin has three floats,
// RGB [1/sr].
inline constexpr std::uint32_t kMeasuredHalf = 90, kMeasuredDifference = 90, kMeasuredTurn = 180;
inline constexpr std::uint32_t kMeasuredFloats =
    3 * kMeasuredHalf * kMeasuredDifference * kMeasuredTurn;

// The texture coordinates of a triangle's corners: 8 floats, read only where a material has a
// texture.
struct TriangleUvs {
  float uv[3][2];
  float density;  // square root of the area in uv over the area in the world [1/length]
  float unused;
};
inline constexpr int kLogUvWords = 3;
static_assert(sizeof(TriangleUvs) == sizeof(std::uint32_t) << kLogUvWords);

enum class TextureWrap : std::uint32_t { kRepeat, kClamp, kMirror };

// An image, how it is wrapped and how it is laid: 16 words. (0, 0) is the corner of the first texel
// of the first row, (1, 1) the opposite corner of the image.
struct TextureRecord {
  std::uint32_t first_level, levels;  // rows of the level table
  TextureWrap wrap_u, wrap_v;
  float transform[6];       // (u, v) -> (t0 u + t1 v + t2, t3 u + t4 v + t5)
  float texels;             // number of level 0 in a length of 1 of (u, v) before the transform
  std::uint32_t first_uvs;  // row of TextureView::uvs that has those of triangle 0
  float unused[4];
};
inline constexpr int kLogTextureWords = 4;
static_assert(sizeof(TextureRecord) == sizeof(std::uint32_t) << kLogTextureWords);

struct TextureLevel {
  std::uint32_t first_texel, width, height, unused;
};
inline constexpr int kLogLevelWords = 2;
static_assert(sizeof(TextureLevel) == sizeof(std::uint32_t) << kLogLevelWords);

}  // namespace skywave
