// The options of photon mapping and of vertex connection and merging, and the memory that they ask
// for.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "wavefront/records/photon_map.h"
#include "wavefront/render_option.h"

namespace skywave {

// A pass of a picture has photons of its own.
struct PhotonPass {
  SampleRange samples;
  float shrink;  // its radius over that of the first pass
};

// Returns the passes of a picture: PhotonOptions::passes of them. 0 means one, or one for each
// sample (IntegratorDescriptor::pass_each_sample), with radii that go by the number of the sample.
// A frame that has some of the picture's samples renders parts of some of the passes. Radii shrink
// as in Knaus and Zwicker 2011 (eq. 15): r_(i+1)^2 = r_i^2 (i + alpha) / (i + 1). Variance and bias
// of the mean of all passes then both vanish.
std::vector<PhotonPass> PhotonPasses(const RenderOptions& options);

// The options of integrators that look photons up, and of those that merge light vertices.
std::span<const RenderOption> PhotonOptionTable();
std::span<const RenderOption> VertexOptionTable();

// Throws OptionError for more photons than there is room for in `memory` [bytes]. `vertices`: light
// vertices are kept, with what weights need.
void CheckPhotonMemory(const RenderOptions& options, bool vertices, std::uint64_t memory);

// The same in the memory that is granted; and for passes without samples.
void CheckPhotonPasses(const RenderOptions& options, bool vertices);

// Throws OptionError with the numbers of photons that were asked for.
[[noreturn]] void RefusePhotons(const RenderOptions& options, const std::string& why);

}  // namespace skywave
