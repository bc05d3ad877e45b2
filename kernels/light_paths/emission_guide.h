// A learnt guide says where light paths of the environment start (kernels/light_paths/emission.h):
// a table over cells of directions, each with a box on the disk of the scene's sphere and a tree
// that cuts it into parts.
//
// The disk is the unit square, mapped by SampleDisc (kernels/simd/sphere-inl.h), which keeps areas.
// Some light paths start uniformly over all of it, some over the disk of a smaller sphere. For the
// others a tree cuts the cell's box, in u and v by turns, and every one of its leaves gets the same
// share: the pair of uniforms that places an origin is warped, digit by digit, so points that are
// stratified stay so. Nothing is rejected.
#pragma once

#include <cstdint>

#include "kernels/columns.h"
#include "kernels/light_paths/emission.h"

namespace skywave {

// Cells of directions have equal solid angles: rows of equal height along the world's z, turns
// about it. A boundary of rows lies at z = 0, where the frame of the disk (MakeFrame) jumps.
inline constexpr std::uint32_t kGuideRows = 16, kGuideTurns = 16;
inline constexpr std::uint32_t kGuideCells = kGuideRows * kGuideTurns;
inline constexpr std::uint32_t kGuideLevels = 10, kGuideLeaves = 1u << kGuideLevels;

struct GuideCell {
  // Directions of the cell start light paths this much more often than light samples are drawn
  // there; those of directional and distant lights are not drawn anew.
  float gain = 1;
  float even = 1;                           // share of starts uniform over the disk
  float focused = 0;                        // share of starts over the disk of the focus
  float low[2] = {0, 0}, high[2] = {1, 1};  // box of the other starts in u and v
  float unused = 0;
};
inline constexpr std::uint32_t kGuideCellFloats = sizeof(GuideCell) / sizeof(float);

struct EmissionGuideView {
  const GuideCell* cells = nullptr;  // null: starts are uniform over the disk
  // One tree of kGuideLeaves words per cell, the first one unused: node k, the root being 1, cuts
  // the box there, in u at even levels and in v at odd ones. Its lower part is node 2 k.
  const float* cuts = nullptr;
  SceneSphere focus = {};  // within the scene's; holds most of the surfaces that need light
};

// Lines have unit directions towards the environment and go through surfaces rows[0, n), or the
// surface in the same row if `rows` is null.
struct EnvironmentLines {
  const float *dir_x, *dir_y, *dir_z;
  const SurfaceColumns& surfaces;
  const std::uint32_t* rows = nullptr;
  const float* pdf = nullptr;  // of dir as light samples (LightColumns); null: all finite
};

struct DiskPlaceColumns {
  std::uint32_t* cell;  // of the direction
  float *u, *v;         // in the unit square

  template <class Self, class F>
  static constexpr void ForEachColumn(Self& self, F f) {
    f(self.cell), f(self.u), f(self.v);
  }
};

// Finds the places on the disk where lines [0, n) enter the scene.
void LocateOnDisk(const SceneSphere& sphere, const EnvironmentLines& lines, std::uint32_t n,
                  const DiskPlaceColumns& places);

// Writes the cells of directions [0, n).
void FindGuideCells(const float* dir_x, const float* dir_y, const float* dir_z, std::uint32_t n,
                    std::uint32_t* cell);

// Writes the density with which light paths from infinitely far away arrive along lines [0, n),
// given the density of their direction as that of light samples (kernels/light_paths/arrival.h)
// [1/length^2].
void EnvironmentArrivals(const SceneSphere& sphere, const EmissionGuideView& guide,
                         const EnvironmentLines& lines, std::uint32_t n, float* arrival);

// Starts those rays among [0, n) that come from infinitely far away, as EmitFromEnvironment and
// EmitFromLocalLights have left them, where their light is needed: `disk` is warped to a new
// origin, and the flux is divided by how crowded it is there. The record of the start becomes what
// light samples and EnvironmentArrivals give for the same direction and place: weights of
// bidirectional paths add up to 1 only if both ends agree. The flux has the density that was drawn,
// which differs where the border of a cell cuts a texel. `light_pdf` is that of light samples of
// the environment in these directions [1/sr]; null if rays of the environment have started with
// light samples.
void GuideStarts(const SceneSphere& sphere, const EmissionGuideView& guide,
                 const UniformColumns& disk, const float* light_pdf, std::uint32_t n,
                 const RayColumns& rays, const EmissionColumns& emission);

}  // namespace skywave
