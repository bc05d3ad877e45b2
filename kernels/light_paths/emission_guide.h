// Where light paths of the sky start if that is learnt (kernels/light_paths/emission.h): a table
// over cells of directions, each with a box on the disk of the scene's sphere and a tree that cuts
// it into parts.
//
// The disk is the unit square, mapped by SampleDisc (kernels/simd/sphere-inl.h), which keeps areas.
// Some light paths start evenly over all of it, some over the disk of a smaller sphere. For the
// others a tree cuts the cell's box, in u and v by turns, and every one of its leaves gets the same
// share: the pair of uniforms that places an origin is warped, digit by digit, so points that are
// stratified stay so. Nothing is rejected.
#pragma once

#include <cstdint>

#include "kernels/columns.h"
#include "kernels/light_paths/emission.h"

namespace skywave {

// Cells of directions, of equal solid angle: rows of equal height along the world's z, turns about
// it. A boundary of rows lies at z = 0, where the frame of the disk (MakeFrame) jumps.
inline constexpr std::uint32_t kGuideRows = 16, kGuideTurns = 16;
inline constexpr std::uint32_t kGuideCells = kGuideRows * kGuideTurns;
inline constexpr std::uint32_t kGuideLevels = 10, kGuideLeaves = 1u << kGuideLevels;

struct GuideCell {
  // How much more often directions of the cell start light paths than light samples; those of
  // directional and distant lights are not drawn anew.
  float gain = 1;
  float even = 1;                           // share of paths that start evenly over the disk
  float focused = 0;                        // and over that of the focus
  float low[2] = {0, 0}, high[2] = {1, 1};  // the box of the others in u and v
  float unused = 0;
};
inline constexpr std::uint32_t kGuideCellFloats = sizeof(GuideCell) / sizeof(float);

struct EmissionGuideView {
  const GuideCell* cells = nullptr;  // null: starts are even over the disk
  // A tree a cell, kGuideLeaves words each, the first one unused: where node k, the root being 1,
  // cuts the box, by u at even levels and by v at odd ones. Its lower part is node 2 k.
  const float* cuts = nullptr;
  SceneSphere focus = {};  // within the scene's; holds most of the surfaces that need light
};

// Directions towards the sky (unit) and points of the lines along them: those of surfaces
// rows[0, n), of the surface in the same row where `rows` is null.
struct EnvironmentLines {
  const float *dir_x, *dir_y, *dir_z;
  const SurfaceColumns& surfaces;
  const std::uint32_t* rows = nullptr;
  const float* pdf = nullptr;  // of the directions as light samples (LightColumns); null: finite
};

struct DiskPlaceColumns {
  std::uint32_t* cell;  // of the direction
  float *u, *v;         // in the unit square

  template <class Self, class F>
  static constexpr void ForEachColumn(Self& self, F f) {
    f(self.cell), f(self.u), f(self.v);
  }
};

// Where on the disk lines [0, n) enter the scene.
void LocateOnDisk(const SceneSphere& sphere, const EnvironmentLines& lines, std::uint32_t n,
                  const DiskPlaceColumns& places);

// The cells of directions [0, n).
void FindGuideCells(const float* dir_x, const float* dir_y, const float* dir_z, std::uint32_t n,
                    std::uint32_t* cell);

// The density with which light paths from infinitely far away arrive along lines [0, n), given
// their direction's density as of light samples (kernels/light_paths/arrival.h) [1/length^2].
void EnvironmentArrivals(const SceneSphere& sphere, const EmissionGuideView& guide,
                         const EnvironmentLines& lines, std::uint32_t n, float* arrival);

// Starts rays among [0, n) that come from infinitely far away, as EmitFromEnvironment and
// EmitFromLocalLights have left them, where their light is needed: `disk` is warped to a new
// origin, and the flux divided by how crowded it is there. Makes the record of the start what light
// samples and EnvironmentArrivals say of the same direction and place: weights of bidirectional
// paths add up to 1 only if both ends say the same. The flux has the density that was drawn, which
// is another where the border of a cell cuts a texel. `light_pdf`: of light samples of the sky in
// these directions [1/sr]; null: rays of the sky have started with light samples.
void GuideStarts(const SceneSphere& sphere, const EmissionGuideView& guide,
                 const UniformColumns& disk, const float* light_pdf, std::uint32_t n,
                 const RayColumns& rays, const EmissionColumns& emission);

}  // namespace skywave
