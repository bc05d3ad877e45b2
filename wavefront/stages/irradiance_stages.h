// The stages of the irradiance cache: diffuse surfaces look it up, and paths end there.
#pragma once

#include <cstdint>

#include "wavefront/frame.h"
#include "wavefront/stages/bidirectional_tables.h"
#include "wavefront/worker.h"

namespace skywave {

// The irradiance cache needs these tables.
struct IrradianceTables {
  explicit IrradianceTables(std::uint32_t wave) : direct(wave), found(wave), ended(wave) {}
  soa::Table<RadianceColumns> direct;  // what the rays of records see at once
  soa::Table<IndexColumns> found;      // 1 for surfaces that have found records, else 0
  soa::Table<RayColumns> ended;        // rays of those, which see nothing but light
};

// Adds what the current diffuse surfaces reflect of cached irradiance to their paths.
// IrradianceTables::found keeps which of them have found records: none in pilots, which have no
// cache.
void AddCachedIrradiance(const FrameView& frame, Worker& w, StageClock& clock);

// Moves those of rays [0, n) whose surfaces have found records to IrradianceTables::ended, and
// their number to `ended`: their paths end with the light that they meet. Returns the number of the
// others, which stay.
std::uint32_t EndCachedPaths(const RayColumns& rays, std::uint32_t n, Worker& w,
                             std::uint32_t& ended);

}  // namespace skywave
