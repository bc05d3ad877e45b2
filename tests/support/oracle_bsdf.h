// The BSDFs of the oracle, in double, written from the formulae. kernels/bsdf/bsdf.h defines the
// conventions.
#pragma once

#include <glm/glm.hpp>
#include <memory>

#include "scene/scene.h"
#include "tests/support/oracle_random.h"

namespace skywave {

struct MaterialCase;

struct OracleMaterial {
  BsdfKind bsdf;
  glm::dvec3 reflectance, eta, k;
  double alpha, alpha_across, ior, metallic;
  glm::dvec3 multiscatter;  // conductor: factor of (1 - E(wo)) (1 - E(wi)) cos [1/sr]
  // Those BSDFs that are evaluated by the formulae of bsdf_cases.h have this, and no textures.
  std::shared_ptr<const MaterialCase> formula, formula_of_back;
  bool delta() const { return std::uint32_t(bsdf) >= kFirstDeltaBsdf; }
};
// Throws std::logic_error for a material that the oracle does not know in all of its parts.
OracleMaterial MakeOracleMaterial(const Material& material);

// A point to shade; directions are unit vectors in the world, and normals are on wo's side.
struct OracleSurface {
  const OracleMaterial* material;
  glm::dvec3 wo, ng, ns;
  bool back;              // seen from the side opposite to the triangle's normal
  glm::dvec3 tangent{0};  // anisotropic ones: direction of the first width
};

struct OracleValue {
  glm::dvec3 value;  // f |cos| [1/sr]
  double pdf;        // density of wi [1/sr]
};
// The material must not be a delta distribution.
OracleValue EvaluateBsdf(const OracleSurface& surface, const glm::dvec3& wi);

struct OracleScatter {
  glm::dvec3 wi, weight;  // `weight` is f |cos| / pdf, or the factor of a delta lobe
  double pdf = 0;         // 0: delta
  bool alive = false;     // false: absorbed
};
OracleScatter ScatterBsdf(const OracleSurface& surface, OracleRandom& random);

}  // namespace skywave
