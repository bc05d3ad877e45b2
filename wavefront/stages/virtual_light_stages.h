// The stage of virtual point lights: they shine on the surfaces that camera paths hit.
#pragma once

#include <cstdint>

#include "wavefront/frame.h"
#include "wavefront/stages/bidirectional_tables.h"
#include "wavefront/worker.h"

namespace skywave {

// Virtual point lights need these tables.
struct VirtualLightTables {
  explicit VirtualLightTables(std::uint32_t wave)
      : light(wave), to_eye(wave), partner(wave), turned(wave), seen(wave), seen_by_light(wave) {}
  LightVertices light;  // the current light, repeated for every surface that it shines on
  soa::Table<LightColumns> to_eye;
  soa::Table<IndexColumns> partner;
  soa::Table<TurnedColumns> turned;  // while the light is evaluated
  // Ends of connections; what only weights would need stays 0, as do sub-paths.
  BothDirections seen, seen_by_light;
};

// Adds what the current surfaces reflect of the virtual lights of the pass to their paths, light by
// light, so that a stream of shadow rays aims at one point. Lights whose path and the surfaces of
// `bounce` would be more than max_depth together do not count.
void AddVirtualLights(const FrameView& frame, std::uint32_t bounce, Worker& w, StageClock& clock);

}  // namespace skywave
