// One surface, scattered at a regular grid of lobe.u, which chooses the lobe: of a BSDF without
// density, shares of the grid are the probabilities of its lobes, to 1 / kSize.
#pragma once

#include <glm/vec3.hpp>

#include "tests/support/shading_rows.h"

namespace skywave {

struct LobeGrid {
  static constexpr std::uint32_t kSize = 4096;

  LobeGrid(const MaterialCase& material, Vec n, Vec wo)
      : normal(n), rows(material, kSize, n, wo), rays(kSize) {
    ScatterRows uniforms(kSize, 3);
    for (std::uint32_t i = 0; i < kSize; ++i) uniforms.lobe->u[i] = (float(i) + 0.5f) / kSize;
    alive =
        rows.kernels.scatter(rows.surfaces, rows.materials(), uniforms.view(), kSize, {}, rays, 0);
  }

  Vec Direction(std::uint32_t i) const { return RayDirection(rays, i); }
  bool Reflects(std::uint32_t i) const { return Dot(Direction(i), normal) > 0; }
  glm::dvec3 Throughput(std::uint32_t i) const {
    return {rays->throughput_r[i], rays->throughput_g[i], rays->throughput_b[i]};
  }
  double ReflectedShare() const {
    std::uint32_t count = 0;
    for (std::uint32_t i = 0; i < alive; ++i) count += Reflects(i);
    return double(count) / kSize;
  }
  // What comes back of white light from everywhere, by reflection and through the surface.
  glm::dvec3 Reflected() const { return Sum(true); }
  glm::dvec3 Transmitted() const { return Sum(false); }

  Vec normal;
  ShadingRows rows;
  soa::Table<RayColumns> rays;
  std::uint32_t alive;  // rays that go on

 private:
  glm::dvec3 Sum(bool reflects) const {
    glm::dvec3 sum(0);
    for (std::uint32_t i = 0; i < alive; ++i) {
      if (Reflects(i) == reflects) sum += Throughput(i) / double(kSize);
    }
    return sum;
  }
};

}  // namespace skywave
