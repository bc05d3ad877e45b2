// The records that flow between stages, each declared once: a struct of column pointers, one
// comment a column (meaning, unit or space, writer), one visitor. wavefront/soa.h owns the memory;
// kernels and stages take these structs as they are.
//
// Every column is aligned to kColumnAlignment and has room for PaddedRows(rows) values: kernels run
// over whole vectors and may write anything into the padding behind the last row, and whatever they
// read there is never looked at.
#pragma once

#include <cstddef>
#include <cstdint>

namespace skywave {

inline constexpr std::size_t kColumnAlignment = 64;  // [bytes], one cache line
inline constexpr std::uint32_t kPadRows = 16;        // widest vector of 32-bit lanes

// Room for `rows` rows and a store of a whole vector that begins at any of them.
constexpr std::uint32_t PaddedRows(std::uint32_t rows) {
  return (rows + kPadRows - 1) / kPadRows * kPadRows + kPadRows;
}

// The BSDFs, one line each: a file kernels/bsdf_*.cc defines NameKernels(), everything else
// follows. Each has a queue, in this order. The first list takes light samples; the second one are
// delta distributions, which no light sample can meet.
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
  BSDF(Measured)
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

// One row = one path of the wave. Written by generate; radiance grows until the film takes it.
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

// One row = one active ray. Written by generate and scatter, t_far also by intersect.
struct RayColumns {
  float *org_x, *org_y, *org_z;                       // world space
  float *dir_x, *dir_y, *dir_z;                       // world space, unit length
  float* t_far;                                       // in: infinity, out: distance of the hit
  float *throughput_r, *throughput_g, *throughput_b;  // product of f cos / pdf along the path
  float* pdf;           // of dir by BSDF sampling [1/sr]; 0: no density
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

// One row = the hit of the ray in the same row. Written by intersect; meaningless where geom is
// kNoHit (Embree leaves the rest as it was).
struct HitColumns {
  float *ng_x, *ng_y, *ng_z;  // geometric normal, world space, not normalised, as wound
  float *u, *v;               // barycentric coordinates of corners 1 and 2
  std::uint32_t* triangle;    // index into the triangle records
  std::uint32_t* geom;        // 0 or kNoHit

  template <class Self, class F>
  static constexpr void ForEachColumn(Self& self, F f) {
    f(self.ng_x), f(self.ng_y), f(self.ng_z);
    f(self.u), f(self.v), f(self.triangle), f(self.geom);
  }
};

// One row = one ray that met light: left the scene, or hit what shines. Written by partition,
// radiance and light_pdf by the environment strategy; or all by the kernel of local lights.
struct EscapeColumns {
  float *dir_x, *dir_y, *dir_z;  // world space, unit length
  float *throughput_r, *throughput_g, *throughput_b;
  float* pdf;                                   // as in RayColumns
  std::uint32_t* path;                          // row in PathColumns
  std::uint32_t* from;                          // row in SurfaceColumns of the bounce before
  float *radiance_r, *radiance_g, *radiance_b;  // what it sees there
  float* light_pdf;                             // of dir by light samples [1/sr]

  template <class Self, class F>
  static constexpr void ForEachColumn(Self& self, F f) {
    f(self.dir_x), f(self.dir_y), f(self.dir_z);
    f(self.throughput_r), f(self.throughput_g), f(self.throughput_b);
    f(self.pdf), f(self.path), f(self.from);
    f(self.radiance_r), f(self.radiance_g), f(self.radiance_b), f(self.light_pdf);
  }
};

// One row = one point to shade; the rows of a BSDF are contiguous (SurfaceRanges). The first block
// is moved here by partition, the second computed by surface preparation.
struct SurfaceColumns {
  float *wo_x, *wo_y, *wo_z;  // world space, unit, towards the eye
  float *ng_x, *ng_y, *ng_z;  // in: as in HitColumns; out: unit, on wo's side
  float *throughput_r, *throughput_g, *throughput_b;  // before this surface scatters
  float* t;                                           // distance along the ray
  float *u, *v;                                       // barycentric
  std::uint32_t* triangle;                            // index into the triangle records
  std::uint32_t* path;                                // row in PathColumns
  float *org_x, *org_y, *org_z;        // in: ray origin; out: the hit, lifted by `lift` along ng
  float *ns_x, *ns_y, *ns_z;           // shading normal, unit, on wo's side
  float *color_r, *color_g, *color_b;  // reflectance at the hit
  // Distance between the hit and org; negative: org lies behind the surface, because a BSDF that
  // transmits has put it on the side of the light sample at hand.
  float* lift;
  std::uint32_t* material;  // row in MaterialTable | kBackFace
  // What the light strategy keeps of the row, from its samples to the rays that leave it.
  float* light_norm;
  // Parameters of the row's BSDF that vary over a surface, as BsdfKernels::varying says.
  float *varying_0, *varying_1;

  template <class Self, class F>
  static constexpr void ForEachColumn(Self& self, F f) {
    f(self.wo_x), f(self.wo_y), f(self.wo_z);
    f(self.ng_x), f(self.ng_y), f(self.ng_z);
    f(self.throughput_r), f(self.throughput_g), f(self.throughput_b);
    f(self.t), f(self.u), f(self.v), f(self.triangle), f(self.path);
    f(self.org_x), f(self.org_y), f(self.org_z);
    f(self.ns_x), f(self.ns_y), f(self.ns_z);
    f(self.color_r), f(self.color_g), f(self.color_b);
    f(self.lift), f(self.material), f(self.light_norm);
    f(self.varying_0), f(self.varying_1);
  }
};

// Rows [begin[k], begin[k + 1]) of the surface table belong to BSDF k.
struct SurfaceRanges {
  std::uint32_t begin[kBsdfKinds + 1] = {};
  std::uint32_t count(std::uint32_t kind) const { return begin[kind + 1] - begin[kind]; }
  std::uint32_t total() const { return begin[kBsdfKinds]; }
  std::uint32_t light_sampled() const { return begin[kFirstDeltaBsdf]; }
};

// One row = one light sample, and then one shadow ray, of the surface in the same row. Written by
// the strategy and local lights; the BSDF turns radiance into the contribution and closes t_far
// where there is none.
struct LightColumns {
  float *dir_x, *dir_y, *dir_z;  // world space, unit, towards the light
  float *r, *g, *b;              // in: radiance; out: what the path gains if nothing is in between
  // Samples of the surface a steradian around dir [1/sr]. <= 0: no sample. Infinite: a light
  // without extent, r, g, b are its irradiance, and no BSDF sample can meet it.
  float* pdf;
  float* t_far;  // distance of the light or infinity: trace; negative: nothing to, or occluded

  template <class Self, class F>
  static constexpr void ForEachColumn(Self& self, F f) {
    f(self.dir_x), f(self.dir_y), f(self.dir_z);
    f(self.r), f(self.g), f(self.b), f(self.pdf), f(self.t_far);
  }
};

// Uniform random numbers in [0, 1) of one pair of dimensions, one row a path or surface.
struct UniformColumns {
  float *u, *v;

  template <class Self, class F>
  static constexpr void ForEachColumn(Self& self, F f) {
    f(self.u), f(self.v);
  }
};

// Luminance of linear RGB: the same weights as image/image.h.
inline constexpr float kLuminance[3] = {0.2125f, 0.7154f, 0.0721f};

// A slice of a table: the same columns from row `begin` on.
template <class Columns>
Columns Slice(Columns columns, std::uint32_t begin) {
  Columns::ForEachColumn(columns, [begin](auto*& column) { column += begin; });
  return columns;
}

// ---- Tables of a scene: written once, then only read, at random, so a record lies together ----

// What shading must know of a triangle: 16 bytes, one gather of a line.
struct TriangleRecord {
  std::uint32_t normal[3];  // of the corners, octahedral, 16 bits a coordinate (EncodeNormal)
  std::uint32_t tag;        // material | kFlatTriangle | kind << kKindShift
};
inline constexpr std::uint32_t kMaterialMask = (1u << 20) - 1;
inline constexpr std::uint32_t kFlatTriangle = 1u << 20;  // shaded with its geometric normal
// Of a mixture of two materials: the record is not shaded. normal[0] is the row of a record of the
// same triangle with the first material, the next row has the second one; normal[1] is the share of
// the second one, a float's bits; normal[2] is the mixture itself, a material.
inline constexpr std::uint32_t kMixedTriangle = 1u << 21;
inline constexpr std::uint32_t kKindShift = 24;
inline constexpr std::uint32_t kBackFace = 1u << 31;  // in SurfaceColumns::material

// Parameters of the BSDFs, 16 floats a material, read by gathers at material * 16 + field. Each
// BSDF has the fields that its file names.
struct MaterialRecord {
  float color[3];  // reflectance
  float alpha;     // width of microfacets, along the tangent; Oren-Nayar: roughness
  // Conductors: index, real part; metallic-roughness: metallic in eta[0]; diffuse transmission:
  // what passes through; Phong: the gloss.
  float eta[3];
  float ior;  // dielectrics, coats: inside / outside; anisotropic lobes: width across the tangent
  // Conductors: index, imaginary part; dielectrics: absorption inside [1/length]; coated
  // metallic-roughness: see its file.
  float k[3];
  std::uint32_t color_texture;  // row in the texture table + 1; 0: none
  // Conductor: factor of (1 - E(wo)) (1 - E(wi)), Kulla and Conty 2017; coated metallic-roughness:
  // colour of the sheen.
  float multiscatter[3];
  // Metallic-roughness: as color_texture, G roughness, B metallic; coated conductor: width of the
  // coat, a float's bits; measured: index of the first float of its table.
  std::uint32_t roughness_texture;
};
static_assert(sizeof(MaterialRecord) == 16 * sizeof(float));

// A measured BRDF in the coordinates of the MERL database (Matusik et al. 2003): half angle (bins
// of equal size in its square root), angle between half vector and wi, and azimuth of wi about it,
// in half a turn; the last one runs fastest, three floats (RGB) a bin [1/sr].
inline constexpr std::uint32_t kMeasuredHalf = 90, kMeasuredDifference = 90, kMeasuredTurn = 180;
inline constexpr std::uint32_t kMeasuredFloats =
    3 * kMeasuredHalf * kMeasuredDifference * kMeasuredTurn;

// Texture coordinates of a triangle's corners: 8 floats, read only where a material has a texture.
struct TriangleUvs {
  float uv[3][2];
  float density;  // square root of area in uv over area in the world [1/length]
  float unused;
};
static_assert(sizeof(TriangleUvs) == 8 * sizeof(float));

enum class TextureWrap : std::uint32_t { kRepeat, kClamp, kMirror };

// An image, how it is wrapped and how it is laid: 16 words. (0, 0) is the corner of the first texel
// of the first row, (1, 1) the corner opposite.
struct TextureRecord {
  std::uint32_t first_level, levels;  // rows of the level table
  TextureWrap wrap_u, wrap_v;
  float transform[6];  // (u, v) -> (t0 u + t1 v + t2, t3 u + t4 v + t5)
  float texels;        // of level 0 in a length of 1 of (u, v) before the transform
  float unused[5];
};
static_assert(sizeof(TextureRecord) == 16 * sizeof(float));

struct TextureLevel {
  std::uint32_t first_texel, width, height, unused;
};

}  // namespace skywave
