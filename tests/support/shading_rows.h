// Surfaces and materials for tests of BSDFs.
#pragma once

#include <array>
#include <bit>
#include <cmath>
#include <complex>
#include <string>
#include <vector>

#include "kernels/bsdf/bsdf.h"
#include "kernels/bsdf/coat_tables.h"
#include "kernels/bsdf/conductor_tables.h"
#include "kernels/bsdf/dielectric_tables.h"
#include "kernels/surface/surface.h"
#include "tests/support/random_rows.h"

namespace skywave {

// Returns the words of a record, by which records are compared.
inline auto WordsOf(const MaterialRecord& record) {
  return std::bit_cast<std::array<std::uint32_t, 1 << kLogMaterialWords>>(record);
}

struct MaterialCase {
  std::string name;
  BsdfKind kind;
  MaterialRecord record;
  bool back = false;  // seen from the side opposite to the mesh's normals
  double turn = 0;    // from the frame's first axis to the tangent [rad]
  // Of Varying::kLayers and of the layers of glass; the bytes of the turn are added.
  std::array<std::uint32_t, 4> layers = {~0u, ~0u, ~0u, ~0u};
  Vec base_normal = {0, 0, 1};  // of what lies below a coat, in the frame of the tangent
};
inline bool IsTilted(const MaterialCase& material) { return material.base_normal.z < 1; }

// The kernels' frame about a normal (Duff et al. 2017), rotated to the tangent, in double.
class TangentFrame {
 public:
  TangentFrame(Vec n, double turn) : n_(n) {
    const double sign = std::copysign(1.0, n.z), a = -1 / (sign + n.z), b = n.x * n.y * a;
    const Vec s = {1 + sign * n.x * n.x * a, sign * b, -sign * n.x};
    const Vec t = {b, sign + n.y * n.y * a, -n.y};
    s_ = std::cos(turn) * s + std::sin(turn) * t;
    t_ = std::cos(turn) * t - std::sin(turn) * s;
  }
  Vec To(Vec w) const { return {Dot(w, s_), Dot(w, t_), Dot(w, n_)}; }
  Vec From(Vec w) const { return w.x * s_ + w.y * t_ + w.z * n_; }

 private:
  Vec s_, t_, n_;
};

// Returns the case of the other side of the surface. The frames of a normal and of its opposite
// share the first axis, and the tangent stays where it is; the normal below a coat is turned, too.
inline MaterialCase SeenFromBehind(MaterialCase material) {
  material.back = !material.back;
  material.turn = -material.turn;
  material.base_normal.x = -material.base_normal.x;
  return material;
}

inline MaterialRecord Conductor(float alpha, const float (&eta)[3], const float (&k)[3]) {
  MaterialRecord record = {.color = {1, 1, 1}, .alpha = alpha, .ior = 1};
  for (int c = 0; c < 3; ++c) {
    record.eta[c] = eta[c], record.k[c] = k[c];
    record.multiscatter[c] = ConductorMultiscatter(GgxTables(), alpha, eta[c], k[c]);
  }
  return record;
}
inline MaterialRecord WhiteConductor(float alpha) { return Conductor(alpha, {0, 0, 0}, {0, 0, 0}); }
inline MaterialRecord GoldConductor(float alpha) {
  return Conductor(alpha, {0.143f, 0.375f, 1.442f}, {3.983f, 2.386f, 1.603f});
}

// Returns a copper red without textures.
inline MaterialRecord MetallicRoughness(float alpha, float metallic) {
  return {.color = {0.95f, 0.64f, 0.54f}, .alpha = alpha, .eta = {metallic, 0, 0}, .ior = 1.5f};
}

const float* MeasuredForTests();  // SyntheticMeasuredTable, built once

// Returns the record of a material with a coat, and the tables of all such records. If it has a
// texture of roughness, its rows (ShadingRows) see that as white.
MaterialRecord RecordWithCoat(const Material& material);
const CoatTable* CoatsForTests();
// The same of rough glass whose facets scatter more than once.
MaterialRecord RecordOfGlass(const Material& material, const DielectricTable& table);
const DielectricTable* DielectricsForTests();

// Returns the next turn and width that a word of kernels/surface/facet_turn-inl.h can hold.
inline double HeldTurn(double turn) {
  const double c = std::cos(turn), s = std::copysign(std::sin(turn), std::sin(turn) * c);
  const double held = std::round(32767.5 * (1 + s / (std::fabs(c) + std::fabs(s)))) / 32767.5 - 1;
  return std::atan2(held, 1 - std::fabs(held));
}
inline float HeldWidth(double width) {
  const double root = std::round(65535 * std::sqrt(width)) / 65535;
  return float(root * root);
}

// Returns the word, of a surface seen from its front.
inline float FacetTurnOf(double turn, double across) {
  const double c = std::cos(turn), s = std::copysign(std::sin(turn), std::sin(turn) * c);
  const auto whole = [](double share) { return std::uint32_t(std::lround(share * 65535)); };
  const double place = 0.5 * (1 + s / (std::fabs(c) + std::fabs(s)));
  return std::bit_cast<float>(whole(place) | whole(std::sqrt(across)) << 16);
}

// One surface in all rows. Its material is record 1, so that ignoring the index is detected.
struct ShadingRows {
  ShadingRows(const MaterialCase& material, std::uint32_t rows, Vec normal, Vec wo)
      : kernels(Bsdfs()[std::size_t(material.kind)]),
        records{MaterialRecord{}, material.record},
        surfaces(rows),
        back(material.back),
        turn(material.turn),
        layers(material.layers),
        base_normal(material.base_normal) {
    if (material.kind == BsdfKind::kMeasured) measured = MeasuredForTests();
    for (std::uint32_t i = 0; i < rows; ++i) Set(i, normal, normal, wo);
  }
  void Set(std::uint32_t i, Vec shading, Vec geometric, Vec wo) {
    const SurfaceColumns& s = surfaces;
    Put(shading, i, s.ns_x, s.ns_y, s.ns_z);
    Put(geometric, i, s.ng_x, s.ng_y, s.ng_z);
    Put(wo, i, s.wo_x, s.wo_y, s.wo_z);
    s.throughput_r[i] = s.throughput_g[i] = s.throughput_b[i] = 1;
    const float* color = records[1].color;
    s.color_r[i] = color[0], s.color_g[i] = color[1], s.color_b[i] = color[2];
    s.org_x[i] = float(i), s.org_y[i] = 2, s.org_z[i] = 3;
    s.lift[i] = 0x1p-10f;
    s.path[i] = 7 * i + 1;
    s.material[i] = back ? 1 | kBackFace : 1;
    const bool tangent = kernels.varying == Varying::kTangent;
    const float across = kernels.two_widths ? records[1].multiscatter[2] : 0;
    s.varying_0[i] = tangent ? float(std::cos(turn)) : records[1].alpha;
    s.varying_1[i] = tangent ? float(std::sin(turn)) : records[1].eta[0];
    if (kernels.varying == Varying::kCoatWidths) s.varying_1[i] = records[1].multiscatter[1];
    const float word = FacetTurnOf(back ? -turn : turn, across);
    if (across > 0) s.varying_1[i] = word;
    if (kernels.glass_layers) {
      s.varying_2[i] = std::bit_cast<float>(layers[2]);
      s.varying_3[i] = std::bit_cast<float>(layers[3]);
    }
    if (kernels.varying == Varying::kLayers) SetLayers(i, std::bit_cast<std::uint32_t>(word));
    const Vec base = TangentFrame(shading, turn).From(base_normal);
    s.base_normal[i] =
        tilted() ? EncodeNormal(float(base.x), float(base.y), float(base.z)) : kSameNormal;
  }
  void SetLayers(std::uint32_t i, std::uint32_t turn_word) {
    const SurfaceColumns& s = surfaces;
    const auto column = [&](std::size_t k, std::uint32_t byte) {
      return std::bit_cast<float>((layers[k] & 0xFFFFFF) | byte << 24);
    };
    s.varying_0[i] = std::bit_cast<float>(layers[0]);
    s.varying_1[i] = column(1, turn_word & 255);
    s.varying_2[i] = std::bit_cast<float>(layers[2]);
    s.varying_3[i] = column(3, turn_word >> 8 & 255);
  }
  bool tilted() const { return base_normal.z < 1; }
  MaterialView materials() const {
    MaterialView view = {records.data(), &GgxTables(), &GetSheenTables(), measured,
                         CoatsForTests()};
    view.dielectrics = DielectricsForTests();
    view.varied = kernels.tables.coat && records[1].roughness_texture != 0;
    view.two_widths = kernels.two_widths && records[1].multiscatter[2] > 0;
    if (kernels.tables.anisotropic) view.anisotropic = &GetAnisotropicTables();
    view.base_normals = tilted(), view.flux = flux;
    // Records that were not packed (PackMaterial) have no colour there.
    view.glass_layers = kernels.glass_layers && records[1].specular_color[1] > 0;
    return view;
  }

  // Returns the value and density of one direction per row.
  soa::Table<BsdfValueColumns> Evaluate(const std::vector<Vec>& wi) const {
    const auto n = std::uint32_t(wi.size());
    soa::Table<LightColumns> lights(n);
    for (std::uint32_t i = 0; i < n; ++i)
      Put(wi[i], i, lights->dir_x, lights->dir_y, lights->dir_z);
    soa::Table<BsdfValueColumns> out(n);
    kernels.evaluate(surfaces, materials(), lights, n, out);
    return out;
  }

  BsdfKernels kernels;
  std::vector<MaterialRecord> records;
  soa::Table<SurfaceColumns> surfaces;
  bool back;
  double turn;
  std::array<std::uint32_t, 4> layers;
  Vec base_normal;
  const float* measured = nullptr;
  bool flux = false;  // MaterialView::flux
};

// The uniforms of n scattering events.
struct ScatterRows {
  explicit ScatterRows(std::uint32_t n) : direction(n), lobe(n) {}
  ScatterRows(std::uint32_t n, std::uint32_t seed)
      : direction(RandomUniforms(n, seed)), lobe(RandomUniforms(n, seed + 1)) {}
  ScatterUniforms view() const { return {direction.columns(), lobe.columns()}; }
  soa::Table<UniformColumns> direction, lobe;
};

inline Vec RayDirection(const RayColumns& rays, std::uint32_t row) {
  return Get(row, rays.dir_x, rays.dir_y, rays.dir_z);
}

// Returns the Fresnel reflectance of unpolarised light for an index relative to the near side, by
// the amplitudes in complex numbers; an index of 0 stands for a perfect mirror.
inline double FresnelReflectance(double cosine, std::complex<double> index) {
  if (index == 0.0) return 1;
  const std::complex<double> sine2 = (1 - cosine * cosine) / (index * index);
  const std::complex<double> inner = std::sqrt(1.0 - sine2);
  const auto perpendicular = (cosine - index * inner) / (cosine + index * inner);
  const auto parallel = (index * cosine - inner) / (index * cosine + inner);
  return 0.5 * (std::norm(perpendicular) + std::norm(parallel));
}

// Returns wo at an angle to a normal, with some azimuth.
inline Vec AtAngle(Vec normal, double cosine) {
  if (cosine == 1) return normal;  // exactly
  const Vec s = Unit(Cross(normal, {0.3, 0.9, 0.2})), t = Cross(normal, s);
  const double sine = std::sqrt(1 - cosine * cosine);
  return cosine * normal + sine * std::cos(0.7) * s + sine * std::sin(0.7) * t;
}

}  // namespace skywave
