// From points of the world to the film: what a camera ray that meets them would have begun with.
#pragma once

#include <cstdint>

#include "kernels/bsdf/bsdf.h"
#include "kernels/camera.h"
#include "kernels/columns.h"

namespace skywave {

// One row = one connection of a point to the camera. x, y and importance written by ConnectCamera,
// the rest by ChoosePixels.
struct CameraColumns {
  float *x, *y;  // where the point is seen, on the whole film [pixels]
  // Pixels of the film over area at the point, perpendicular to the connection [1/area]: what flux
  // is multiplied with to be seen, and, times the cosine at the point's surface, the density there
  // of a camera ray that was drawn evenly over a pixel.
  float* importance;
  std::uint32_t* pixel;  // row-major index in the film; unspecified where the connection is closed
  float* weight;         // sum of the filters of all pixels there; 1 in the mean

  template <class Self, class F>
  static constexpr void ForEachColumn(Self& self, F f) {
    f(self.x), f(self.y), f(self.importance), f(self.pixel), f(self.weight);
  }
};

// The pixel filter as a density: kFilterCells cells over [-radius, radius], each the mean over it
// [1/pixel]. Made from the same table as CameraView::filter_offset.
struct FilterView {
  const float* density = nullptr;
  float radius = 0;  // [pixels]
};

// Connects points [0, n) (org of `points`) to the camera: unit directions to it and distances in
// dir and t_far of `lights`, negative where the camera cannot see the point. With a lens (uniforms
// `lens`, read only then) to an even point of it, drawn as GenerateCameraRays draws it.
void ConnectCamera(const CameraView& camera, const SurfaceColumns& points,
                   const UniformColumns& lens, std::uint32_t n, const LightColumns& lights,
                   const CameraColumns& out);

// Draws the pixel that gets connection i among those whose filter reaches it, by weight, so that
// with `weight` the expectation of every pixel is that of camera rays which sample the filter
// (GenerateCameraRays). Closes connections that no pixel of the film gets (t_far of `lights`
// negative). `uniforms`: to choose the column and the row.
void ChoosePixels(const CameraView& camera, const FilterView& filter,
                  const UniformColumns& uniforms, std::uint32_t n, const LightColumns& lights,
                  const CameraColumns& connections);

// What connections [0, n) bring to their pixels if nothing is in between: r, g, b of `lights` =
// throughput * value * importance * weight. Closes those that bring nothing. `values`: of flux
// (kernels/light_paths/flux.h).
void WeighConnections(const SurfaceColumns& surfaces, const BsdfValueColumns& values,
                      const CameraColumns& connections, std::uint32_t n,
                      const LightColumns& lights);

}  // namespace skywave
