// The subcommands of `skywave probe`, one file each, and their shared helpers that read a map.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "cli/commands.h"
#include "image/image.h"
#include "lights/light_sets/probe_lights.h"
#include "lights/maps/environment_map.h"

namespace skywave {

struct MapFlags {
  std::string path;
  std::optional<Projection> projection;
  ReadLimits limits;
};
void AddMapFlags(CLI::App& command, MapFlags& flags);

// A map as read and repaired, with its projection.
struct ProbeFile {
  Image image;
  Projection projection = Projection::kLatLong;
  bool assumed = false;  // given by --projection instead of by its shape
  BadPixels bad;
};
// Reports bad pixels on standard error.
ProbeFile ReadProbe(const MapFlags& flags);
Image ReadProbeAsLatLong(const MapFlags& flags);

// Adds --method, -n and the other flags that make lights.
void AddLightFlags(CLI::App& command, LightRequest& request);
// Adds --strata.
void AddStrataFlag(CLI::App& command, std::optional<StrataRequest>& request);

void AddProbeInfoCommand(CLI::App& probe, Run& run);
void AddProbeConvertCommand(CLI::App& probe, Run& run);
void AddProbeLightsCommand(CLI::App& probe, Run& run);
void AddProbePresampleCommand(CLI::App& probe, Run& run);
void AddProbePlotCommand(CLI::App& probe, Run& run);
void AddProbeCalibrateCommand(CLI::App& probe, Run& run);

}  // namespace skywave
