// These kernels connect points of the world to the film: they find where a camera ray that hits a
// point would have begun.
#pragma once

#include <cstdint>

#include "kernels/bsdf/bsdf.h"
#include "kernels/camera.h"
#include "kernels/columns.h"

namespace skywave {

// One row is one connection of a point to the camera. ConnectCamera writes x, y and importance,
// ChoosePixels the rest.
struct CameraColumns {
  float *x, *y;  // position on the whole film [pixels]
  // Pixels of the film over area at the point, perpendicular to the connection [1/area]: it is the
  // factor of flux that is seen and, times the cosine at the point's surface, the density there of
  // a camera ray that was drawn uniformly over a pixel.
  float* importance;
  std::uint32_t* pixel;  // row-major index in the film; unspecified where the connection is closed
  float* weight;         // sum of the filters of all pixels there; 1 on average

  template <class Self, class F>
  static constexpr void ForEachColumn(Self& self, F f) {
    f(self.x), f(self.y), f(self.importance), f(self.pixel), f(self.weight);
  }
};

// The pixel filter is a density: kFilterCells cells over [-radius, radius], each the mean over it
// [1/pixel]. It is made from the same table as CameraView::filter_offset.
struct FilterView {
  const float* density = nullptr;
  float radius = 0;  // [pixels]
  // Factors of camera paths by the cells of CameraView::filter_offset that their uniforms fall
  // into, the product of both axes. Null: all are 1.
  const float* factor = nullptr;

  // Returns what a camera path counts that is at (u, v) of its filter.
  float WeightAt(float u, float v) const {
    if (factor == nullptr) return 1;
    const auto cell = [](float x) { return std::uint32_t(x * float(kFilterCells)); };
    return factor[cell(u)] * factor[cell(v)];
  }
};

// Connects points [0, n) (org of `points`) to the camera: writes unit directions to it and
// distances to dir and t_far of `lights`, negative where the camera cannot see the point. A lens is
// connected at a uniform point, drawn as GenerateCameraRays draws it (uniforms `lens`, read only
// then).
void ConnectCamera(const CameraView& camera, const SurfaceColumns& points,
                   const UniformColumns& lens, std::uint32_t n, const LightColumns& lights,
                   const CameraColumns& out);

// Draws the pixel that gets connection i among those whose filter reaches it, by weight, so that
// with `weight` the expectation of every pixel is that of camera rays which sample the filter
// (GenerateCameraRays). Closes connections that no pixel of the film gets (t_far of `lights`
// negative). `uniforms` choose the column and the row.
void ChoosePixels(const CameraView& camera, const FilterView& filter,
                  const UniformColumns& uniforms, std::uint32_t n, const LightColumns& lights,
                  const CameraColumns& connections);

// Writes the contribution of connections [0, n) to their pixels if nothing is in between,
// throughput * value * importance * weight, to r, g, b of `lights`. Closes those without any.
// `values` are of flux (kernels/light_paths/flux.h).
void WeighConnections(const SurfaceColumns& surfaces, const BsdfValueColumns& values,
                      const CameraColumns& connections, std::uint32_t n,
                      const LightColumns& lights);

}  // namespace skywave
