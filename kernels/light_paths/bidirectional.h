// Two sub-paths that are joined: one from the eye, one from a light. Every way to join them gives a
// sample of the same path, and the power heuristic (Veach and Guibas 1995) weights the ways by
// their densities. The sums over all of them that it needs are carried along a sub-path in two
// numbers, so that no vertex but the last one is looked at (Georgiev 2012, "Implementing Vertex
// Connection and Merging", dVCM and dVC).
//
// Ways that merge the ends of two sub-paths, where they are near each other, take part if there are
// such (MisTechniques). The third number of that report, dVM, is dVC over `merged`, squared, at
// every vertex, so two numbers are enough for them as well.
//
// Conventions. Densities of vertices are areal [1/length^2], measured with geometric normals; those
// of a vertex infinitely far away are in solid angle. A delta BSDF counts as density 1 in both
// directions, and no way joins at it. A light sub-path is one a path; a picture has `light_paths`
// of them for every sample of a pixel. Roulette does not count. Without multiple importance
// sampling (MisPolicy) every weight is 1, and each way alone is an estimate of what it can find.
#pragma once

#include <cstdint>

#include "kernels/bsdf/bsdf.h"
#include "kernels/columns.h"
#include "kernels/light_paths/emission.h"

namespace skywave {

// What a sub-path knows of the other ways to make it: ratios of densities, theirs over its own,
// joined by the root of the sum of squares, which floats hold where the sum itself would overflow.
struct SubpathColumns {
  // Of the way that joins at the vertex before (dVCM); at a vertex [length^2], on the way to it
  // [sr], or negative: of an end infinitely far away, and then distance does not count.
  float* d_vcm;
  // Of all ways that join farther back, but for the density with which the vertex at hand samples
  // back (dVC).
  float* d_vc;

  template <class Self, class F>
  static constexpr void ForEachColumn(Self& self, F f) {
    f(self.d_vcm), f(self.d_vc);
  }
};

// The columns of a surface that differ where it is seen from behind.
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

// How the ways to make a path share it.
struct MisTechniques {
  MisPolicy mis;
  // Light sub-paths that a vertex of the eye is merged with, times the area around it in which they
  // are (Georgiev's eta_VCM) [length^2]: the density of a merge over that of a connection before it
  // is this times the density that it leaves out. 0: sub-paths are not merged.
  float eta_vcm = 0;
};

// Rows [0, n) of `surfaces` as they look from where dir of `lights` points to: turned where that is
// behind them.
void TurnSurfaces(const SurfaceColumns& surfaces, const LightColumns& lights, std::uint32_t n,
                  const TurnedColumns& turned);

// Clears values and densities of rows [0, n) of `values` whose wo is below the surface as it is or
// as it is shaded, where BSDFs, which take wo for being above, mean nothing.
void ClearUnseen(const SurfaceColumns& surfaces, std::uint32_t n, const BsdfValueColumns& values);

// The sub-paths of rows [0, n) leave the eye. `density`: of their rays, one sample a pixel [1/sr],
// or, of parallel rays, across them [1/length^2].
void LeaveEye(const float* density, float light_paths, bool parallel, std::uint32_t n,
              const SubpathColumns& paths);

// The sub-paths of rows [0, n) leave their lights: writes `paths`, row by row.
void LeaveLights(const EmissionColumns& emission, std::uint32_t n, const SubpathColumns& paths);

// The sub-paths in rows surfaces.path of `paths` have arrived at surfaces [0, n): writes `at`.
void ArriveAtSurfaces(const SurfaceColumns& surfaces, std::uint32_t n, const SubpathColumns& paths,
                      const SubpathColumns& at);

// Rays [0, n) leave the surfaces in rows rays.from of `surfaces`, whose density for sampling back
// is `back_pdf` [1/sr]: writes rows rays.path of `paths`.
void LeaveSurfaces(const SurfaceColumns& surfaces, const SubpathColumns& at, const float* back_pdf,
                   const MisTechniques& techniques, const RayColumns& rays, std::uint32_t n,
                   const SubpathColumns& paths);

// Whether any other way makes the paths of rays that met light: pdf of rows [0, n) becomes 1, or 0
// where there is none, and they may see what no light sample shows (EscapeColumns).
void MarkPartners(const SubpathColumns& paths, std::uint32_t n, const EscapeColumns& rows);

// Weighs rays that have met light: throughput of rows [0, n) times the weight of their way, pdf 0.
// `arrival`: of the light's own sub-paths, where these rays come from
// (kernels/light_paths/arrival.h).
void WeighHitLight(const SubpathColumns& paths, const float* arrival, std::uint32_t n,
                   const MisPolicy& mis, const EscapeColumns& rows);

// Light samples that have been evaluated in both directions: turns r, g, b of rows [0, n) into what
// the path gains if the light is seen, and opens or closes their shadow rays. `arrival`: of the
// light's own sub-paths at the surface.
void WeighLightSamples(const SurfaceColumns& surfaces, const SubpathColumns& at,
                       const BsdfValueColumns& forward, const BsdfValueColumns& backward,
                       const float* arrival, std::uint32_t n, const MisTechniques& techniques,
                       const LightColumns& lights);

// Vertices [0, n) of light sub-paths that are connected to the eye: r, g, b of `to_eye`, what the
// picture gains, times the weight of that way. `back_pdf`: of wo given dir of `to_eye`. `arrival`:
// density with which the eye's own rays arrive here, one sample a pixel, but for the cosine here
// [1/length^2].
void WeighSplats(const SurfaceColumns& surfaces, const SubpathColumns& at, const float* back_pdf,
                 const float* arrival, float light_paths, std::uint32_t n,
                 const MisTechniques& techniques, const LightColumns& to_eye);

// The vertices of one bounce of a wave's light sub-paths.
struct VertexView {
  SurfaceColumns surfaces;
  SubpathColumns at;
  const std::uint32_t* row_of_path;  // of a path's vertex in these tables; kNoRow: none
};

// Aims at the partner of surfaces [0, n), the vertex of the same path in `vertices`: writes its row
// (or kNoRow) to `partner`, and dir and distance (t_far; negative: no partner) to `to_light`, row
// by row. The way back goes to dir of `to_eye` in the partner's row.
void AimAtVertices(const SurfaceColumns& surfaces, std::uint32_t n, const VertexView& vertices,
                   std::uint32_t* partner, const LightColumns& to_light,
                   const LightColumns& to_eye);

// Both ends of connections, each evaluated in both directions: that of the eye from wo to dir,
// that of the light from wo to the eye (forward), and the other way round (backward).
struct ConnectionEnds {
  BsdfValueColumns eye_forward, eye_backward;
  BsdfValueColumns light_forward, light_backward;  // rows of the vertices
};

// Turns the connections of rows [0, n) into shadow rays: `to_light` gets what the path gains if
// nothing is in between, direction and reach. Origins at both ends are on the side of the other one
// (MoveToSide). `partner`, `to_light`: as AimAtVertices left them.
void JoinVertices(const SurfaceColumns& surfaces, const SubpathColumns& at, std::uint32_t n,
                  const MisTechniques& techniques, const VertexView& vertices,
                  const std::uint32_t* partner, const ConnectionEnds& ends,
                  const LightColumns& to_light);

// Vertices of the eye in rows [0, n) that are merged with vertices of light sub-paths, those in
// rows `vertex` of `light`: r, g, b of `lights`, which have light from dir as LoadPhotons leaves
// it, become what the path gains, and t_far tells whether that is anything. `forward`, `backward`:
// of dir given wo and of wo given dir. Where paths are merged, ways.merged is not 0.
void MergeVertices(const SurfaceColumns& surfaces, const SubpathColumns& at,
                   const BsdfValueColumns& forward, const float* backward,
                   const SubpathColumns& light, const std::uint32_t* vertex, std::uint32_t n,
                   const MisTechniques& techniques, const LightColumns& lights);

}  // namespace skywave
