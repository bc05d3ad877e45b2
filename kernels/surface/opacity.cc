#include "kernels/surface/opacity.h"

#include <cstddef>

namespace skywave {
namespace {

// Mixes all bits (Wellons 2018, "lowbias32").
std::uint32_t Mix(std::uint32_t x) {
  x = (x ^ x >> 16) * 0x7feb352du;
  x = (x ^ x >> 15) * 0x846ca68bu;
  return x ^ x >> 16;
}

const OpacityRecord& RecordOf(const OpacityView& view, std::uint32_t triangle) {
  const TriangleRecord& record = view.triangles[triangle];
  const bool mixed = (record.tag & kMixedTriangle) != 0;
  return view.records[mixed ? record.normal[2] : record.tag & kMaterialMask];
}

}  // namespace

float Opacity(const OpacityView& view, std::uint32_t triangle, float u, float v) {
  const OpacityRecord& record = RecordOf(view, triangle);
  float opacity = record.factor;
  if (record.texture != 0) {
    opacity *= FirstChannel(view.textures, record.texture - 1, triangle, u, v);
  }
  if (view.of_corners != nullptr) {
    const float* const corner = view.of_corners + 3 * std::size_t{triangle};
    opacity *= corner[0] * (1 - u - v) + corner[1] * u + corner[2] * v;
  }
  return opacity;
}

bool StopsRay(const OpacityView& view, std::uint32_t key, std::uint32_t triangle, float u,
              float v) {
  const float opacity = Opacity(view, triangle, u, v);
  const float cutoff = RecordOf(view, triangle).cutoff;
  if (cutoff >= 0) return opacity >= cutoff;
  return float(Mix(key ^ triangle * 0x9E3779B9u) >> 8) * 0x1p-24f < opacity;
}

void DrawRayKeys(const PathColumns& paths, const std::uint32_t* rows, std::uint32_t n,
                 std::uint32_t event, std::uint32_t* keys) {
  for (std::uint32_t i = 0; i < n; ++i) {
    const std::uint32_t row = rows[i];
    keys[i] = Mix(Mix(paths.seed[row] ^ event * 0x9E3779B9u) + paths.sample[row]);
  }
}

}  // namespace skywave
