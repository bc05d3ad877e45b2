// Links say on which surfaces a light shines, and which surfaces throw its shadows.
//
// Light is left out where a surface takes it: a light sample of a surface that is not linked to its
// light has no radiance, and neither has what a BSDF sample from there sees of the light, so that
// both techniques of multiple importance sampling lose the same light. What the camera sees of
// lights stays.
//
// A BSDF sample is stopped by all surfaces. So lights of which some throw no shadow are seen by
// light samples alone, and by mirrors and glass, which have no other way, with all shadows.
#pragma once

#include <algorithm>
#include <cstdint>

#include "wavefront/frame.h"
#include "wavefront/scratch.h"
#include "wavefront/stages/stages.h"
#include "wavefront/worker.h"

namespace skywave {

inline constexpr std::uint32_t kMostLinks = 32;

// How many links a job has, of which each is a bit.
struct LinkOptions {
  std::uint32_t count = 0;
};

// Of lights, `links` are the links that name them.
struct LinkView {
  const std::uint32_t* unlit = nullptr;     // by material: links whose lights do not shine on it
  const std::uint32_t* of_light = nullptr;  // by local light: links
  std::uint32_t of_environment = 0;         // links
  std::uint32_t of_shadows = 0;             // links that say what throws shadows
  // By such a link, then by material: 1 if it throws shadows of the link's light; null: all do.
  const std::uint8_t* const* stops = nullptr;
};

struct LinkColumns {
  std::uint32_t* links;  // by surface: of the light of its current light sample
  float* t_far;          // by surface: of its shadow ray
  std::uint32_t* seen;   // by ray: 1 if it keeps its throughput
  float *r, *g, *b;      // by ray: its throughput

  template <class Self, class F>
  static constexpr void ForEachColumn(Self& self, F f) {
    f(self.links), f(self.t_far), f(self.seen), f(self.r), f(self.g), f(self.b);
  }
};

// A worker needs these tables where there are links.
struct LinkTables {
  explicit LinkTables(std::uint32_t wave) : rows(wave) {}
  soa::Table<LinkColumns> rows;
};

void AddLinkTables(const RenderOptions& options, Worker& worker);

// Takes the radiance of light samples to which their surfaces are not linked. Does nothing without
// links, as all of these functions.
void LinkSamples(const FrameView& frame, const LightReach& reach, const Worker& w);

// Calls trace(tracer) for the shadow rays of w.lights: without links once.
template <class Trace>
void TraceByLinks(const FrameView& frame, const Worker& w, const Trace& trace);

// Takes the throughput of those of rays [0, n) that meet light for which the surfaces that they
// have left are not linked to it; ShowLights gives it back. `left` are these surfaces.
void HideLights(const FrameView& frame, const RayColumns& rays, std::uint32_t n,
                std::uint32_t bounce, const SurfaceColumns& left, const Worker& w);
void ShowLights(const FrameView& frame, const RayColumns& rays, std::uint32_t n, const Worker& w);

// ---- Implementation ----

// Returns the links of a worker that has some; null: there are none.
const LinkColumns* LinkRows(const FrameView& frame, const Worker& w);

// Opens, of the shadow rays that `kept` had open, those of links that are among `links`, or are of
// no light with links of shadows if that is 0; closes the others.
void OpenShadows(const LinkView& view, const LinkColumns& kept, std::uint32_t links,
                 std::uint32_t n, float* t_far);
// Keeps what came of them.
void KeepShadows(const LinkView& view, const LinkColumns& kept, std::uint32_t links,
                 std::uint32_t n, const float* t_far);

template <class Trace>
void TraceByLinks(const FrameView& frame, const Worker& w, const Trace& trace) {
  const LinkColumns* const kept = LinkRows(frame, w);
  if (kept == nullptr || frame.find<LinkView>()->of_shadows == 0) return trace(frame.tracer);
  const LinkView& view = *frame.find<LinkView>();
  const std::uint32_t n = w.ranges.light_sampled();
  float* const t_far = w.lights->t_far;
  std::copy_n(t_far, n, kept->t_far);
  for (std::uint32_t link = 0; link <= kMostLinks; ++link) {
    const std::uint32_t bit = link < kMostLinks ? 1u << link : 0;
    if (bit != 0 && (view.of_shadows & bit) == 0) continue;
    Tracer tracer = frame.tracer;
    if (bit != 0) tracer.only = view.stops[link];
    OpenShadows(view, *kept, bit, n, t_far);
    trace(tracer);
    KeepShadows(view, *kept, bit, n, t_far);
  }
  std::copy_n(kept->t_far, n, t_far);
}

}  // namespace skywave
