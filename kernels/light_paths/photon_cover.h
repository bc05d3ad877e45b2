// Rays that look at the disk of a photon lookup from above find how much of it is surface.
//
// A disk that hangs over an edge or reaches behind a wall can have photons on a part of it only.
// Divided by all of its area they make edges and corners dark (boundary bias). Hey and Purgathofer
// 2002 take the existing area from the triangles within the disk; rays see the same of any mesh at
// a fixed price. The disk is cut into cells that have equal shares of the kernel, with one ray
// each. Photons in cells that are not seen do not count either, nor do those that lie on another
// layer than the one that is seen: light behind a wall or above a ceiling does not leak, and
// photons and area are those of the same part of the disk.
#pragma once

#include <bit>
#include <cstdint>

#include "kernels/columns.h"
#include "kernels/light_paths/photons.h"
#include "kernels/light_paths/point_tree.h"

namespace skywave {

// A disk has two rings of eight cells, with one ray each.
inline constexpr std::uint32_t kDiskCells = 16;
inline constexpr std::uint32_t kAllCells = (1u << kDiskCells) - 1;

// Photons are looked up on a disk.
struct PhotonDisk {
  float point[3], normal[3];  // world space; geometric normal, unit
  float radius2;              // > 0
  float height;               // height of the eye above `point`, > 0
};

// A photon lies on the layer that is seen in its cell if it is no farther from it, along the mean
// of both normals, than this share of the disk's radius.
inline constexpr float kLayerHeight = 0.1f;

// The cells of a disk, as rays see them.
struct DiskSurface {
  std::uint32_t seen;  // one bit per cell
  // The point that is seen in each cell, from the middle of the disk, and its unit normal.
  alignas(kColumnAlignment) float x[kDiskCells], y[kDiskCells], z[kDiskCells];
  alignas(kColumnAlignment) float normal_x[kDiskCells], normal_y[kDiskCells], normal_z[kDiskCells];
};

// Returns true if neighbors [0, n) leave no doubt that their disk is surface all over: all lie on
// it in one layer, on its upper side, and hardly any cell is without. In doubt it returns false,
// which costs only time.
bool LooksWhole(const PhotonDisk& disk, PhotonKernel kernel, const PhotonColumns& photons,
                const PointTreeView& tree, const NeighborColumns& found, std::uint32_t n);

// Writes origins, directions and t_far of rows [0, kDiskCells): rays go from the eye to the middles
// of the cells, and as far again beyond them. Cells are turned by a hash of the point, so that
// their grain becomes noise and not bands along edges.
void AimAtDisk(const PhotonDisk& disk, PhotonKernel kernel, const RayColumns& rays);

// Writes the cells whose rays [0, kDiskCells) hit within the radius what photons may lie on, as
// LoadPhotons sees it. Mirrors and glass in between count as see-through: photons arrive behind
// them. If no cell is seen, the eye is in a bad place, and all count as seen.
void FindSeenCells(const PhotonDisk& disk, const TriangleRecord* triangles, const RayColumns& rays,
                   const HitColumns& hits, DiskSurface& surface);

// Moves those neighbors [0, n) that do not lie on what is seen out of reach of LoadPhotons.
void CloseUnseen(const PhotonDisk& disk, PhotonKernel kernel, const DiskSurface& surface,
                 const PhotonColumns& photons, const PointTreeView& tree,
                 const NeighborColumns& found, std::uint32_t n);

// Returns the share of the kernel that seen cells have.
inline float CoverOf(std::uint32_t seen) { return float(std::popcount(seen)) / float(kDiskCells); }

}  // namespace skywave
