// The list of policies, and how each of them describes itself in its own file.
//
// A policy says how the light and scatter samples of a frame are drawn, or what of their light is
// known beforehand. Pilots, coarse renders before the frame, may teach it. What it has learnt
// reaches the stages through the frame: as another strategy, or as data that a stage looks for
// (FrameView::find).
#pragma once

#include <memory>
#include <span>
#include <string_view>

#include "wavefront/frame.h"
#include "wavefront/pilot_reports.h"

namespace skywave {

// The policies, one line each, in the order in which they learn: a file of wavefront/policies/
// defines NamePolicy(), and everything else follows.
#define SKYWAVE_POLICIES(POLICY) \
  POLICY(Strategy)               \
  POLICY(Control)                \
  POLICY(Guide)

struct RenderOption;
struct Worker;
class WorkerPool;

// What a policy that learns is given.
struct Pilots {
  WorkerPool& pool;
  float brightest_radiance;  // that the film of the frame will hold
  PilotReports& reports;     // to which it adds its own
};

struct PolicyDescriptor {
  // Its options; null: none. An option of a policy says which integrators it applies to.
  std::span<const RenderOption> (*options)() = nullptr;
  // Throws OptionError if options do not go together with this policy. Null: there is nothing to
  // check.
  void (*check)(const RenderOptions& options) = nullptr;
  // Adds the tables that this policy needs to a worker, if the options ask for the policy.
  void (*add_tables)(const RenderOptions& options, Worker& worker) = nullptr;
  // Has pilots teach the policy, if the frame asks for it, and makes the frame draw by what was
  // learnt. Returns what the frame refers to from then on. What is learnt depends on neither
  // threads nor wave, nor on which part of the film or which samples the frame has; statistics of
  // the workers stay as they are, and no rays are recorded.
  std::shared_ptr<const void> (*teach)(FrameView& frame, const Pilots& pilots) = nullptr;
};

std::span<const PolicyDescriptor> Policies();

// Adds the tables of all policies that the options ask for.
void AddPolicyTables(const RenderOptions& options, Worker& worker);

#define SKYWAVE_DECLARE(policy) PolicyDescriptor policy##Policy();
SKYWAVE_POLICIES(SKYWAVE_DECLARE)
#undef SKYWAVE_DECLARE

}  // namespace skywave
