// The subcommands of `skywave probe`, one file each, and their shared helpers that read a map.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "cli/command.h"
#include "image/image.h"
#include "lights/light_sets/probe_lights.h"
#include "lights/maps/environment_map.h"
#include "lights/probe/probe_map.h"

namespace skywave {

struct MapFlags {
  std::string path;
  std::optional<Projection> projection;
  ReadLimits limits;
};
void AddMapOptions(Command& command, const std::shared_ptr<MapFlags>& flags);

// Reports bad pixels on standard error.
ProbeMap ReadProbe(const MapFlags& flags);
Image ReadProbeAsLatLong(const MapFlags& flags);

// Adds --method, -n and the other options that make lights.
void AddLightOptions(Command& command, const std::shared_ptr<LightRequest>& request);

Command ProbeInfoCommand();
Command ProbeConvertCommand();
Command ProbeLightsCommand();
Command ProbePresampleCommand();
Command ProbePlotCommand();
Command ProbeCalibrateCommand();
Command ProbeAssembleCommand();
Command ProbeJoinCommand();

}  // namespace skywave
