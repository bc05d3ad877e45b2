// Compares the weights of bidirectional paths, computed from two numbers per sub-path, with those
// by definition in double (support/path_densities.h): random paths with all kinds of lights, with
// and without delta BSDFs, for all connections and merges.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/support/path_densities.h"
#include "tests/support/targets.h"
#include "wavefront/stages/bidirectional_tables.h"

namespace skywave {
namespace {

constexpr std::uint32_t kPaths = 96;
constexpr std::size_t kMostSurfaces = 5;
constexpr float kLightPaths = 700;

BidirectionalPath RandomPath(Random& random, std::size_t surfaces, double delta_share,
                             double eta_vcm) {
  BidirectionalPath path;
  path.eta_vcm = eta_vcm;
  const auto density = [&] { return std::exp(random.Between(-3, 4)); };
  const auto point = [&] { return random.Between(0.5, 3) * random.Direction(); };
  path.eye = point();
  path.eye_pdf = std::exp(random.Between(0, 12));
  path.light_paths = kLightPaths;
  for (std::size_t i = 0; i < surfaces; ++i) {
    PathSurface surface = {point(), random.Direction(), random.Float() < delta_share, 1, 1};
    if (!surface.delta) surface.pdf_to_light = density(), surface.pdf_to_eye = density();
    path.surfaces.push_back(surface);
  }
  path.light = PathLight(random.Word() % 4);
  path.light_point = path.distant() ? random.Direction() : point();
  path.light_normal = random.Direction();
  path.light_pdf = density();
  path.emission_pdf = 0.1 * density();
  return path;
}

void Fill(float value, std::uint32_t row, float* r, float* g, float* b) {
  r[row] = g[row] = b[row] = value;
}

// Many paths with the same number of surfaces, one per row, in the form used by the stages. Rows of
// the light's vertices are reversed, so that ignoring an index is detected.
class Subpaths {
 public:
  explicit Subpaths(std::vector<BidirectionalPath> paths) : paths_(std::move(paths)) {
    for (std::size_t i = 0; i < surfaces(); ++i)
      eye_.emplace_back(kPaths), light_.emplace_back(kPaths);
    WalkFromEye();
    WalkFromLight();
  }
  std::size_t surfaces() const { return paths_[0].surfaces.size(); }

  // Returns the kernels' weights of the technique with that many vertices from the light.
  std::vector<double> Weights(std::size_t lights) {
    if (lights == 0) return HitLight();
    if (lights == 1) return LightSamples();
    return lights == surfaces() + 1 ? Splats() : Connections(lights - 2);
  }

  // Returns the weights of the technique that merges both sub-paths at a surface.
  std::vector<double> MergeWeights(std::size_t surface) {
    const LightVertices &eye = eye_[surface], &light = light_[surface];
    const soa::Table<LightColumns> lights(kPaths);
    const soa::Table<IndexColumns> vertex(kPaths);
    const BothDirections seen(kPaths);
    for (std::uint32_t i = 0; i < kPaths; ++i) {
      Fill(1, i, lights->r, lights->g, lights->b);
      Fill(1, i, seen.forward->r, seen.forward->g, seen.forward->b);
      seen.forward->pdf[i] = float(paths_[i].surfaces[surface].pdf_to_light);
      seen.backward->pdf[i] = float(paths_[i].surfaces[surface].pdf_to_eye);
      vertex->index[i] = LightRow(i);
    }
    MergeVertices(eye.surfaces, eye.at, seen.forward, seen.backward->pdf, light.at, vertex->index,
                  kPaths, mis_techniques(), lights);
    return {lights->g, lights->g + kPaths};
  }

 private:
  MisTechniques mis_techniques() const { return {.mis = {}, .eta_vcm = float(paths_[0].eta_vcm)}; }
  static std::uint32_t LightRow(std::uint32_t path) { return kPaths - 1 - path; }

  // Sets the surface as seen by a sub-path that arrives along -wo from `distance` away.
  static void Set(const PathSurface& surface, Vec wo, double distance, std::uint32_t path,
                  std::uint32_t row, const LightVertices& vertices) {
    const SurfaceColumns& s = vertices.surfaces;
    const Vec ng = Dot(surface.normal, wo) < 0 ? -surface.normal : surface.normal;
    Put(wo, row, s.wo_x, s.wo_y, s.wo_z);
    Put(ng, row, s.ng_x, s.ng_y, s.ng_z);
    constexpr float kLift = 0x1p-12f;
    Put(surface.point + kLift * ng, row, s.org_x, s.org_y, s.org_z);
    s.lift[row] = kLift, s.t[row] = float(distance), s.path[row] = path;
    Fill(1, row, s.throughput_r, s.throughput_g, s.throughput_b);
    vertices.row_of_path->index[path] = row;
  }
  // Rays that leave from all rows, and the density of the reverse sampling.
  struct Leaving {
    Leaving() : rays(kPaths), back(kPaths) {}
    void Set(std::uint32_t i, std::uint32_t row, const PathSurface& surface, Vec dir, double pdf,
             double back_pdf) {
      Put(dir, i, rays->dir_x, rays->dir_y, rays->dir_z);
      rays->pdf[i] = surface.delta ? 0 : float(pdf);
      rays->path[i] = i, rays->from[i] = row;
      back->u[row] = float(back_pdf);
    }
    soa::Table<RayColumns> rays;
    soa::Table<UniformColumns> back;
  };

  Vec ToLight(const BidirectionalPath& path, std::size_t surface) const {
    if (surface + 1 < surfaces()) {
      return path.surfaces[surface + 1].point - path.surfaces[surface].point;
    }
    return path.distant() ? path.light_point : path.light_point - path.surfaces[surface].point;
  }
  Vec ToEye(const BidirectionalPath& path, std::size_t surface) const {
    return (surface == 0 ? path.eye : path.surfaces[surface - 1].point) -
           path.surfaces[surface].point;
  }

  void WalkFromEye() {
    const soa::Table<UniformColumns> density(kPaths);
    for (std::uint32_t i = 0; i < kPaths; ++i) density->u[i] = float(paths_[i].eye_pdf);
    LeaveEye(density->u, kLightPaths, /*parallel=*/false, kPaths, eye_flying_);
    for (std::size_t j = 0; j < surfaces(); ++j) {
      Leaving leaving;
      for (std::uint32_t i = 0; i < kPaths; ++i) {
        const PathSurface& surface = paths_[i].surfaces[j];
        const Vec back = ToEye(paths_[i], j);
        Set(surface, Unit(back), Length(back), i, i, eye_[j]);
        leaving.Set(i, i, surface, Unit(ToLight(paths_[i], j)), surface.pdf_to_light,
                    surface.pdf_to_eye);
      }
      ArriveAtSurfaces(eye_[j].surfaces, kPaths, eye_flying_, eye_[j].at);
      LeaveSurfaces(eye_[j].surfaces, eye_[j].at, leaving.back->u, mis_techniques(), leaving.rays,
                    kPaths, eye_flying_);
    }
  }

  void WalkFromLight() {
    const soa::Table<SubpathColumns> flying(kPaths);
    const soa::Table<EmissionColumns> emission(kPaths);
    for (std::uint32_t i = 0; i < kPaths; ++i) {
      const BidirectionalPath& path = paths_[i];
      const Vec dir = Unit(ToLight(path, surfaces() - 1));
      emission->pdf[i] = float(path.light_pdf * path.emission_pdf);
      emission->light_pdf[i] = float(path.light_pdf);
      emission->cosine[i] =
          path.light == PathLight::kArea ? float(std::fabs(Dot(path.light_normal, dir))) : 1;
      emission->light[i] = path.light == PathLight::kEnvironment ? kNoLight : 3;
      emission->delta[i] = path.light == PathLight::kPosition    ? kDeltaPosition
                           : path.light == PathLight::kDirection ? kDeltaDirection
                                                                 : 0;
    }
    LeaveLights(emission, kPaths, flying);
    for (std::size_t j = surfaces(); j-- > 0;) {
      Leaving leaving;
      for (std::uint32_t i = 0; i < kPaths; ++i) {
        const PathSurface& surface = paths_[i].surfaces[j];
        const Vec back = ToLight(paths_[i], j);
        // Light from infinitely far away arrives over an arbitrary distance.
        Set(surface, Unit(back), paths_[i].distant() && j + 1 == surfaces() ? 1e3 : Length(back), i,
            LightRow(i), light_[j]);
        leaving.Set(i, LightRow(i), surface, Unit(ToEye(paths_[i], j)), surface.pdf_to_eye,
                    surface.pdf_to_light);
      }
      ArriveAtSurfaces(light_[j].surfaces, kPaths, flying, light_[j].at);
      LeaveSurfaces(light_[j].surfaces, light_[j].at, leaving.back->u, mis_techniques(),
                    leaving.rays, kPaths, flying);
    }
  }

  // Returns the arrival density of a light in the kernels' form, seen from the last surface.
  double Arrival(const BidirectionalPath& path) const {
    const Vec offset = ToLight(path, surfaces() - 1);
    return path.distant() ? path.emission_pdf : path.emission_pdf / Dot(offset, offset);
  }
  // Returns the density of light samples in solid angle; infinite for lights that nothing can hit.
  double LightPdf(const BidirectionalPath& path) const {
    if (path.light == PathLight::kEnvironment) return path.light_pdf;
    if (path.light != PathLight::kArea) return std::numeric_limits<double>::infinity();
    const Vec offset = ToLight(path, surfaces() - 1);
    return path.light_pdf * Dot(offset, offset) / std::fabs(Dot(path.light_normal, Unit(offset)));
  }

  std::vector<double> HitLight() {
    const soa::Table<EscapeColumns> light_hits(kPaths);
    const soa::Table<UniformColumns> arrival(kPaths);
    for (std::uint32_t i = 0; i < kPaths; ++i) {
      Fill(1, i, light_hits->throughput_r, light_hits->throughput_g, light_hits->throughput_b);
      light_hits->path[i] = i, light_hits->light_pdf[i] = float(LightPdf(paths_[i]));
      arrival->u[i] = float(Arrival(paths_[i]));
    }
    MarkPartners(eye_flying_, kPaths, light_hits);
    WeighHitLight(eye_flying_, arrival->u, kPaths, MisPolicy(), light_hits);
    return {light_hits->throughput_g, light_hits->throughput_g + kPaths};
  }

  std::vector<double> LightSamples() {
    const LightVertices& last = eye_.back();
    const soa::Table<LightColumns> lights(kPaths);
    const soa::Table<UniformColumns> arrival(kPaths);
    const BothDirections seen(kPaths);
    std::vector<double> weights(kPaths);
    for (std::uint32_t i = 0; i < kPaths; ++i) {
      const PathSurface& surface = paths_[i].surfaces.back();
      Put(Unit(ToLight(paths_[i], surfaces() - 1)), i, lights->dir_x, lights->dir_y, lights->dir_z);
      Fill(1, i, lights->r, lights->g, lights->b);
      Fill(1, i, seen.forward->r, seen.forward->g, seen.forward->b);
      lights->pdf[i] = float(LightPdf(paths_[i]));
      seen.forward->pdf[i] = float(surface.pdf_to_light);
      seen.backward->pdf[i] = float(surface.pdf_to_eye);
      arrival->u[i] = float(Arrival(paths_[i]));
    }
    WeighLightSamples(last.surfaces, last.at, seen.forward, seen.backward, arrival->u, kPaths,
                      mis_techniques(), lights);
    for (std::uint32_t i = 0; i < kPaths; ++i) {
      const double pdf = LightPdf(paths_[i]);
      weights[i] = lights->g[i] * (std::isinf(pdf) ? 1 : pdf);
    }
    return weights;
  }

  std::vector<double> Splats() {
    const LightVertices& first = light_.front();
    const soa::Table<LightColumns> to_eye(kPaths);
    const soa::Table<UniformColumns> arrival(kPaths), back(kPaths);
    std::vector<double> weights(kPaths);
    for (std::uint32_t i = 0; i < kPaths; ++i) {
      const std::uint32_t row = LightRow(i);
      const Vec offset = ToEye(paths_[i], 0);
      Put(Unit(offset), row, to_eye->dir_x, to_eye->dir_y, to_eye->dir_z);
      Fill(1, row, to_eye->r, to_eye->g, to_eye->b);
      arrival->u[row] = float(paths_[i].eye_pdf / Dot(offset, offset));
      back->u[row] = float(paths_[i].surfaces[0].pdf_to_light);
    }
    WeighSplats(first.surfaces, first.at, back->u, arrival->u, kLightPaths, kPaths,
                mis_techniques(), to_eye);
    for (std::uint32_t i = 0; i < kPaths; ++i) weights[i] = to_eye->g[LightRow(i)];
    return weights;
  }

  // The light sub-path has `light_surfaces` + 1 surfaces.
  std::vector<double> Connections(std::size_t light_surfaces) {
    const std::size_t j = surfaces() - 1 - light_surfaces;  // the light's end of the connection;
                                                            // the eye's is j - 1
    const LightVertices &eye = eye_[j - 1], &light = light_[j];
    const soa::Table<LightColumns> to_light(kPaths), to_eye(kPaths);
    const soa::Table<IndexColumns> partner(kPaths);
    const BothDirections at_eye(kPaths), at_light(kPaths);
    AimAtVertices(eye.surfaces, kPaths, light.view(), partner->index, to_light, to_eye);
    for (std::uint32_t i = 0; i < kPaths; ++i) {
      const std::uint32_t row = LightRow(i);
      const PathSurface &z = paths_[i].surfaces[j - 1], &y = paths_[i].surfaces[j];
      EXPECT_EQ(partner->index[i], row);
      const Vec dir = Unit(ToLight(paths_[i], j - 1));
      const Vec aimed = Get(i, to_light->dir_x, to_light->dir_y, to_light->dir_z);
      const Vec aimed_back = Get(row, to_eye->dir_x, to_eye->dir_y, to_eye->dir_z);
      EXPECT_LT(Angle(aimed, dir) + Angle(-aimed_back, dir), 1e-4);
      Fill(1, i, at_eye.forward->r, at_eye.forward->g, at_eye.forward->b);
      Fill(1, row, at_light.backward->r, at_light.backward->g, at_light.backward->b);
      at_eye.forward->pdf[i] = float(z.pdf_to_light);
      at_eye.backward->pdf[i] = float(z.pdf_to_eye);
      at_light.forward->pdf[row] = float(y.pdf_to_eye);
      at_light.backward->pdf[row] = float(y.pdf_to_light);
    }
    JoinVertices(eye.surfaces, eye.at, kPaths, mis_techniques(), light.view(), partner->index,
                 {at_eye.forward, at_eye.backward, at_light.forward, at_light.backward}, to_light);
    std::vector<double> weights(kPaths);
    for (std::uint32_t i = 0; i < kPaths; ++i) {
      const PathSurface& y = paths_[i].surfaces[j];
      const Vec offset = ToEye(paths_[i], j), in = Unit(ToLight(paths_[i], j));
      const double geometry = std::fabs(Dot(y.normal, Unit(offset))) / Dot(offset, offset) /
                              std::fabs(Dot(y.normal, in));
      weights[i] = to_light->g[i] / geometry;
    }
    return weights;
  }

  std::vector<BidirectionalPath> paths_;
  std::vector<LightVertices> eye_, light_;  // by surface from the eye
  soa::Table<SubpathColumns> eye_flying_{kPaths};
};

// `eta_vcm` is 0 for paths that are only connected.
void ExpectWeights(std::size_t surfaces, double delta_share, double eta_vcm) {
  SCOPED_TRACE(testing::Message() << surfaces << " surfaces, delta " << delta_share << ", merged "
                                  << eta_vcm);
  Random random(5);
  std::vector<BidirectionalPath> paths;
  std::vector<TechniqueWeights> expected;
  for (std::uint32_t i = 0; i < kPaths; ++i) {
    paths.push_back(RandomPath(random, surfaces, delta_share, eta_vcm));
    expected.emplace_back(paths.back());
  }
  ForEachTarget([&] {
    Subpaths subpaths(paths);
    std::vector<double> sum(kPaths);
    // Stages do not use impossible techniques, and their weights mean nothing.
    const auto compare = [&](std::uint32_t i, double weight, double density, double exact) {
      if (density == 0) return;
      EXPECT_NEAR(weight, exact, 2e-4) << "path " << i << ", light " << int(paths[i].light);
      sum[i] += weight;
    };
    for (std::size_t lights = 0; lights <= surfaces + 1; ++lights) {
      SCOPED_TRACE(testing::Message() << lights << " vertices from the light");
      const std::vector<double> weights = subpaths.Weights(lights);
      for (std::uint32_t i = 0; i < kPaths; ++i) {
        compare(i, weights[i], TechniqueDensity(paths[i], lights), expected[i].connected[lights]);
      }
    }
    for (std::size_t surface = 0; eta_vcm > 0 && surface < surfaces; ++surface) {
      SCOPED_TRACE(testing::Message() << "merged at surface " << surface);
      const std::vector<double> weights = subpaths.MergeWeights(surface);
      for (std::uint32_t i = 0; i < kPaths; ++i) {
        compare(i, weights[i], MergeDensity(paths[i], surface), expected[i].merged[surface]);
      }
    }
    for (std::uint32_t i = 0; i < kPaths; ++i) {
      if (sum[i] == 0) continue;
      EXPECT_NEAR(sum[i], 1, 1e-3) << "path " << i;
    }
  });
}

TEST(TechniqueWeights, AreThoseByDefinitionAndSumToOne) {
  for (std::size_t surfaces = 1; surfaces <= kMostSurfaces; ++surfaces) {
    for (const double delta_share : {0.0, 0.4, 1.0}) {
      for (const double eta_vcm : {0.0, 0.1, 4.0}) ExpectWeights(surfaces, delta_share, eta_vcm);
    }
  }
}

}  // namespace
}  // namespace skywave
