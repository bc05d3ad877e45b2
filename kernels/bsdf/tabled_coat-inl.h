// A dielectric coat over a BSDF that takes it into account, by tables of the material
// (coat_tables.h): the lobe of the coat itself, by exact Fresnel reflectance, the light that its
// medium returns, and `Below`, whose value has what the coat lets through in both directions.
#if defined(SKYWAVE_KERNELS_TABLED_COAT_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SKYWAVE_KERNELS_TABLED_COAT_INL_H_
#undef SKYWAVE_KERNELS_TABLED_COAT_INL_H_
#else
#define SKYWAVE_KERNELS_TABLED_COAT_INL_H_
#endif

#include "kernels/bsdf/coat-inl.h"
#include "kernels/bsdf/coat_tables.h"

HWY_BEFORE_NAMESPACE();
namespace skywave {
namespace HWY_NAMESPACE {

// One vector of tables.
struct CoatLanes {
  HWY_INLINE CoatLanes(const MaterialView& m, VU fields, std::uint32_t i, std::uint32_t n)
      : words(reinterpret_cast<const float*>(m.coats)) {
    // Rows beyond the end have another material.
    const VU index = hn::IfThenElseZero(RowsBelow(i, n), IndexField(m, fields, kCoatTable));
    first = index * SetU(kCoatWords);
    medium = hn::And(hn::RebindMask(F(), RowsBelow(i, n)),
                     hn::Gt(Field(m, fields, kCoatMedium), hn::Zero(F())));
    has_medium = !hn::AllFalse(F(), medium);
  }

  // A neighbour among the tables of several widths: its distance in words, 0 where there is one
  // table, and its share.
  struct Neighbour {
    VU words;
    VF share;
  };
  // Goes to the table of the row below a width, in lanes whose widths have an image; tables of
  // neighbouring rows are so many words apart.
  HWY_INLINE Neighbour Approach(VF width, MU lanes, std::uint32_t words_a_row) {
    varied = true;
    const VF at = hn::Sqrt(width) * float(kCoatRows - 1);
    const VU row = hn::Min(ToUnsigned(at), SetU(kCoatRows - 2));
    const VU step = hn::IfThenElseZero(lanes, SetU(words_a_row));
    first = first + row * step;
    return {step, at - ToFloat(row)};
  }
  HWY_INLINE VF ReadMetal(VU at) const {
    const VF narrow = Gather(words, at);
    if (!over_metals) return narrow;
    const VF wide = Gather(words, at + metals.words);
    return narrow + metals.share * (wide - narrow);
  }
  // Reads a word of the table, or between the tables of neighbouring widths.
  HWY_INLINE VF Read(VU at) const {
    if (!varied) return Gather(words, at);
    const VF narrow = ReadMetal(at), wide = ReadMetal(at + coats.words);
    return narrow + coats.share * (wide - narrow);
  }

  // The place of a cosine in the columns.
  struct Place {
    VU column;
    VF share;
  };
  static HWY_INLINE Place PlaceOf(VF cosine) {
    const VF at = hn::Sqrt(Clamp(cosine, 0.0f, 1.0f)) * float(kAlbedoColumns - 1);
    const VU column = hn::Min(ToUnsigned(at), SetU(kAlbedoColumns - 1));
    return {column, at - ToFloat(column)};
  }
  HWY_INLINE VF Look(std::size_t member, const Place& place) const {
    const VU at = first + place.column + SetU(std::uint32_t(member / sizeof(float)));
    const VF low = Read(at), high = Read(at + SetU(1));
    return low + place.share * (high - low);
  }
  HWY_INLINE V3 Look3(std::size_t member, const Place& place) const {
    return {Look(member, place), Look(member + sizeof(CoatColumn), place),
            Look(member + 2 * sizeof(CoatColumn), place)};
  }
  HWY_INLINE V3 Constants(std::size_t member) const {
    const VU at = first + SetU(std::uint32_t(member / sizeof(float)));
    return {Read(at), Read(at + SetU(1)), Read(at + SetU(2))};
  }

  HWY_INLINE VF Own(VF cosine) const { return Look(offsetof(CoatTable, own), PlaceOf(cosine)); }
  // Returns the light that the medium returns without touching what lies below.
  HWY_INLINE V3 Medium(const V3& wo, const V3& wi) const {
    const VF zero = hn::Zero(F());
    if (!has_medium) return {zero, zero, zero};
    const V3 o = Look3(offsetof(CoatTable, medium), PlaceOf(wo.z));
    const V3 i = Look3(offsetof(CoatTable, medium), PlaceOf(wi.z));
    return IfThen(medium, o * i * wi.z, V3{zero, zero, zero});
  }

  const float* words;
  VU first;
  MF medium;
  bool has_medium;
  bool varied = false;  // some lane's widths have an image: the coat's, and with over_metals both
  bool over_metals = false;
  Neighbour coats, metals;  // set if `varied`, and if `over_metals`
};

// Returns the lanes of the least width.
HWY_INLINE MF IsMirror(const Ggx& ggx) { return hn::Le(ggx.alpha, Set(1e-3f)); }

template <class Below>
struct UnderCoat {
  HWY_INLINE UnderCoat(const SurfaceColumns& s, const MaterialView& m, std::uint32_t i,
                       std::uint32_t n)
      : below(s, m, i, n),
        coat(m, below.fields, i, n),
        ggx(Clamp(Field(m, below.fields, Below::kCoatWidth), 1e-3f, 1.0f)),
        ratio(1.0f / hn::Max(Field(m, below.fields, kIor), Set(1e-3f))) {
    if (!m.varied) return;
    const VU image = IndexField(m, below.fields, kRoughnessTexture);
    const MU lanes = hn::And(RowsBelow(i, n), hn::Ne(image, hn::Zero(U())));
    if (!hn::AllFalse(U(), lanes)) ggx = Ggx(below.Vary(s, i, lanes, coat));
  }

  HWY_INLINE VF Reflectance(const V3& wo, const V3& h) const {
    return FresnelDielectric(Clamp(Dot(wo, h), 0.0f, 1.0f), ratio).reflectance;
  }
  HWY_INLINE VF Blurred(const V3& wo, const V3& wi, VF radius) const {
    const VF own = Reflectance(wo, Ggx::HalfVector(wo, wi)) * ggx.Blurred(wo, wi, radius);
    return own + below.Blurred(coat, wo, wi, radius);
  }

  HWY_INLINE BsdfValue Evaluate(const V3& wo, const V3& wi) const {
    return EvaluateWithoutMirrors(wo, wi, hn::MaskFromVec(hn::Zero(F())));
  }
  // A lobe of the least width stands for a mirror. What a light without extent would show in it is
  // single pixels, as bright as the lobe is narrow.
  HWY_INLINE BsdfValue EvaluateWithoutMirrors(const V3& wo, const V3& wi, MF lanes) const {
    const VF one = Set(1.0f);
    const V3 h = Ggx::HalfVector(wo, wi);
    const VF d = Ggx::Distribution(h, ggx.alpha * ggx.alpha);
    const VF lobe = d * (0.25f / hn::Max(wo.z, Set(1e-6f)));
    const VF lambda_o = ggx.Lambda(wo), lambda_i = ggx.Lambda(wi);
    const VF facets = Reflectance(wo, h) * (lobe / (one + lambda_o + lambda_i));
    const VF own = hn::IfThenZeroElse(hn::And(lanes, IsMirror(ggx)), facets);
    const VF own_pdf = lobe / (one + lambda_o);
    BsdfValue base = below.Evaluate(coat, wo, wi);
    if constexpr (Below::kMayMirror) {
      const MF hidden = hn::And(lanes, IsMirror(below.ggx));
      const VF zero = hn::Zero(F());
      base.value = IfThen(hidden, V3{zero, zero, zero}, base.value);
    }
    const V3 rest = base.value + coat.Medium(wo, wi);
    const VF share = LayerShare(coat.Own(wo.z));
    return {V3{own, own, own} + rest, base.pdf + share * (own_pdf - base.pdf)};
  }
  HWY_INLINE BsdfSample Draw(const V3& wo, VF u, VF v, VF lobe) const {
    const VF share = LayerShare(coat.Own(wo.z));
    const V3 wi = IfThen(hn::Lt(lobe, share), ggx.Reflect(wo, u, v),
                         below.Direction(wo, u, v, BelowLayer(lobe, share)));
    return SampleOf(wi, Evaluate(wo, wi));
  }
  template <class Base = Below>
  HWY_INLINE auto Diffuse(const V3& wo) const
      -> decltype(std::declval<const Base&>().Diffuse(std::declval<const CoatLanes&>(), wo)) {
    return below.Diffuse(coat, wo);
  }

  Below below;
  CoatLanes coat;
  Ggx ggx;
  VF ratio;  // index outside over that of the coat
};

}  // namespace HWY_NAMESPACE
}  // namespace skywave
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
