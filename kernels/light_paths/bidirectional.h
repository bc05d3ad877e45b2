// Two sub-paths are connected: one from the eye, one from a light. Every technique to connect them
// gives a sample of the same path, and the power heuristic (Veach and Guibas 1995) weights the
// techniques by their densities. The sums over all of them that it needs are carried along a
// sub-path in two numbers, so that only the last vertex is looked at (Georgiev 2012, "Implementing
// Vertex Connection and Merging", dVCM and dVC).
//
// Techniques that merge the ends of two sub-paths, if these are near each other, take part if they
// are enabled (MisTechniques). The third number of that report, dVM, is dVC over the square of
// eta_vcm at every vertex, so two numbers are enough for them as well.
//
// Conventions: densities of vertices are areal [1/length^2], measured with geometric normals; those
// of a vertex infinitely far away are in solid angle. A delta BSDF counts as density 1 in both
// directions, and no technique connects at it. There is one light sub-path per path; a picture has
// `light_paths` of them for every sample of a pixel. Roulette does not count. Without multiple
// importance sampling (MisPolicy) every weight is 1, and each technique alone is an estimate of
// what it can find.
#pragma once

#include <cstdint>

#include "kernels/bsdf/bsdf.h"
#include "kernels/columns.h"
#include "kernels/light_paths/emission.h"

namespace skywave {

// A sub-path carries ratios of densities, those of the other techniques over its own, combined by
// the root of the sum of squares, which floats hold where the sum itself would overflow.
struct SubpathColumns {
  // The ratio of the technique that connects at the vertex before (dVCM); at a vertex [length^2],
  // between vertices [sr]. It is negative for an end infinitely far away, and then distance does
  // not count.
  float* d_vcm;
  // The ratio of all techniques that connect farther back, without the density with which the
  // current vertex samples back (dVC).
  float* d_vc;

  template <class Self, class F>
  static constexpr void ForEachColumn(Self& self, F f) {
    f(self.d_vcm), f(self.d_vc);
  }
};

// These columns of a surface differ where it is seen from behind.
struct TurnedColumns {
  float *ng_x, *ng_y, *ng_z;
  float *ns_x, *ns_y, *ns_z;
  std::uint32_t* material;

  template <class Self, class F>
  static constexpr void ForEachColumn(Self& self, F f) {
    f(self.ng_x), f(self.ng_y), f(self.ng_z);
    f(self.ns_x), f(self.ns_y), f(self.ns_z), f(self.material);
  }
};

inline constexpr std::uint32_t kNoRow = 0xFFFFFFFFu;

// The techniques that can make a path share it as these settings say.
struct MisTechniques {
  MisPolicy mis;
  // The number of light sub-paths that a vertex of the eye is merged with, times the area around it
  // in which they are (Georgiev's eta_VCM) [length^2]: the density of a merge over that of a
  // connection before it is this times the density that it leaves out. 0: sub-paths are not merged.
  float eta_vcm = 0;
};

// Writes rows [0, n) of `surfaces` as they look from where dir of `lights` points: they are turned
// where that is behind them.
void TurnSurfaces(const SurfaceColumns& surfaces, const LightColumns& lights, std::uint32_t n,
                  const TurnedColumns& turned);

// Clears values and densities of rows [0, n) of `values` whose wo is below the geometric or the
// shading surface: BSDFs take wo to be above, so values there are meaningless.
void ClearUnseen(const SurfaceColumns& surfaces, std::uint32_t n, const BsdfValueColumns& values);

// Starts the sub-paths of rows [0, n) at the eye. `density` is that of their rays, one sample per
// pixel [1/sr], or, for parallel rays, across them [1/length^2].
void LeaveEye(const float* density, float light_paths, bool parallel, std::uint32_t n,
              const SubpathColumns& paths);

// Starts the sub-paths of rows [0, n) at their lights: writes `paths`, row by row.
void LeaveLights(const EmissionColumns& emission, std::uint32_t n, const SubpathColumns& paths);

// Writes `at` for the sub-paths in rows surfaces.path of `paths`, which have arrived at surfaces
// [0, n).
void ArriveAtSurfaces(const SurfaceColumns& surfaces, std::uint32_t n, const SubpathColumns& paths,
                      const SubpathColumns& at);

// Writes rows rays.path of `paths` for rays [0, n), which leave the surfaces in rows rays.from of
// `surfaces`. `back_pdf` is the surfaces' density for sampling back [1/sr].
void LeaveSurfaces(const SurfaceColumns& surfaces, const SubpathColumns& at, const float* back_pdf,
                   const MisTechniques& techniques, const RayColumns& rays, std::uint32_t n,
                   const SubpathColumns& paths);

// Sets pdf of rows [0, n), rays that hit light, to 1 if any other technique makes their paths and
// to 0 if none does; the latter may see what no light sample shows (EscapeColumns).
void MarkPartners(const SubpathColumns& paths, std::uint32_t n, const EscapeColumns& rows);

// Weighs rays that have hit light: multiplies throughput of rows [0, n) by the weight of their
// technique and sets pdf to 0. `arrival` is that of the light's own sub-paths, where these rays
// come from (kernels/light_paths/arrival.h).
void WeighHitLight(const SubpathColumns& paths, const float* arrival, std::uint32_t n,
                   const MisPolicy& mis, const EscapeColumns& rows);

// Weighs light samples that have been evaluated in both directions: turns r, g, b of rows [0, n)
// into what the path gains if the light is seen, and opens or closes their shadow rays. `arrival`
// is that of the light's own sub-paths at the surface.
void WeighLightSamples(const SurfaceColumns& surfaces, const SubpathColumns& at,
                       const BsdfValueColumns& forward, const BsdfValueColumns& backward,
                       const float* arrival, std::uint32_t n, const MisTechniques& techniques,
                       const LightColumns& lights);

// Weighs vertices [0, n) of light sub-paths that are connected to the eye: multiplies r, g, b of
// `to_eye`, what the picture gains, by the weight of that technique. `back_pdf` is the density of
// wo given dir of `to_eye`. `arrival` is the density with which the eye's own rays arrive here, one
// sample per pixel, without the cosine here [1/length^2].
void WeighSplats(const SurfaceColumns& surfaces, const SubpathColumns& at, const float* back_pdf,
                 const float* arrival, float light_paths, std::uint32_t n,
                 const MisTechniques& techniques, const LightColumns& to_eye);

// These are the vertices of one bounce of a wave's light sub-paths.
struct VertexView {
  SurfaceColumns surfaces;
  SubpathColumns at;
  const std::uint32_t* row_of_path;  // row of a path's vertex in these tables, or kNoRow
};

// Aims surfaces [0, n) at their partners, the vertices of the same paths in `vertices`: writes the
// partner's row (or kNoRow) to `partner`, and dir and distance (t_far; negative: no partner) to
// `to_light`, row by row. The opposite direction goes to dir of `to_eye` in the partner's row.
void AimAtVertices(const SurfaceColumns& surfaces, std::uint32_t n, const VertexView& vertices,
                   std::uint32_t* partner, const LightColumns& to_light,
                   const LightColumns& to_eye);

// Both ends of connections are evaluated in both directions: forward is from wo to dir at the eye's
// end and from wo to the eye at the light's end, backward is the reverse.
struct ConnectionEnds {
  BsdfValueColumns eye_forward, eye_backward;
  BsdfValueColumns light_forward, light_backward;  // rows of the vertices
};

// Turns the connections of rows [0, n) into shadow rays: `to_light` gets what the path gains if
// nothing is in between, direction and reach. Origins at both ends are on the side of the other one
// (MoveToSide). `partner` and `to_light` are as AimAtVertices has left them.
void JoinVertices(const SurfaceColumns& surfaces, const SubpathColumns& at, std::uint32_t n,
                  const MisTechniques& techniques, const VertexView& vertices,
                  const std::uint32_t* partner, const ConnectionEnds& ends,
                  const LightColumns& to_light);

// Merges vertices of the eye in rows [0, n) with vertices of light sub-paths, those in rows
// `vertex` of `light`: r, g, b of `lights`, which hold light from dir as LoadPhotons leaves it,
// become what the path gains, and t_far is negative where that is nothing. `forward` is of dir
// given wo, `backward` of wo given dir. techniques.eta_vcm is not 0 where paths are merged.
void MergeVertices(const SurfaceColumns& surfaces, const SubpathColumns& at,
                   const BsdfValueColumns& forward, const float* backward,
                   const SubpathColumns& light, const std::uint32_t* vertex, std::uint32_t n,
                   const MisTechniques& techniques, const LightColumns& lights);

}  // namespace skywave
