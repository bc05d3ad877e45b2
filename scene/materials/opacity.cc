#include "scene/materials/opacity.h"

namespace skywave {
namespace {

// For closest hits and occlusion alike. `N` rays, in arrays of that length.
void DropTransparent(const RTCFilterFunctionNArguments* arguments) {
  const auto& filter = *static_cast<const AlphaFilter*>(arguments->geometryUserPtr);
  const unsigned n = arguments->N;
  for (unsigned i = 0; i < n; ++i) {
    if (arguments->valid[i] == 0) continue;
    const std::uint32_t triangle = filter.first + RTCHitN_primID(arguments->hit, n, i);
    const float u = RTCHitN_u(arguments->hit, n, i), v = RTCHitN_v(arguments->hit, n, i);
    const std::uint32_t key = RTCRayN_id(arguments->ray, n, i);
    if (!StopsRay(filter.opacity, key, triangle, u, v)) arguments->valid[i] = 0;
  }
}

}  // namespace

std::vector<OpacityRecord> MakeOpacityRecords(const std::vector<Material>& materials) {
  std::vector<OpacityRecord> records;
  for (const Material& material : materials) {
    records.push_back({.factor = material.opacity,
                       .cutoff = material.opacity_cutoff.value_or(-1),
                       .texture = material.opacity_texture ? *material.opacity_texture + 1 : 0,
                       .unused = 0});
  }
  return records;
}

void SetAlphaFilter(RTCGeometry geometry, const AlphaFilter& filter) {
  rtcSetGeometryUserData(geometry, const_cast<AlphaFilter*>(&filter));
  rtcSetGeometryIntersectFilterFunction(geometry, DropTransparent);
  rtcSetGeometryOccludedFilterFunction(geometry, DropTransparent);
}

}  // namespace skywave
