// Tables of a map that do not depend on how it lies in the world: all its orientations share them.
#pragma once

#include <array>
#include <memory>
#include <utility>

#include "kernels/lights/environment.h"
#include "lights/maps/environment_map.h"

namespace skywave {

// `Tables` has a member `texels` (lights/tables/texels.h), and is immutable.
template <class Tables>
class OrientedTables {
 public:
  OrientedTables(std::shared_ptr<const Tables> tables, const EnvironmentMap& map)
      : tables_(std::move(tables)), map_from_world_(map.map_from_world) {}

  // Returns the same tables for the same map as it lies in `map`.
  OrientedTables Turned(const EnvironmentMap& map) const { return {tables_, map}; }

  const Tables* operator->() const { return tables_.get(); }
  EnvironmentView texels() const { return tables_->texels.view(map_from_world_); }

 private:
  std::shared_ptr<const Tables> tables_;
  std::array<float, 9> map_from_world_;
};

}  // namespace skywave
