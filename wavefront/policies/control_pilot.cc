#include "wavefront/policies/control_pilot.h"

#include <tbb/parallel_sort.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <tuple>

#include "base/clock.h"
#include "wavefront/paths/pilot.h"
#include "wavefront/policy.h"
#include "wavefront/render_option.h"
#include "wavefront/stages/path_stages.h"

namespace skywave {
namespace {

// A node is split where so many surfaces were, and there are so many places at most.
constexpr std::size_t kSplitSurfaces = 512, kMostPlaces = 4096;
// The weight of the node above counts as so many surfaces.
constexpr double kPriorSurfaces = 16;
// Weights so near to 0 and 1 are 0 and 1.
constexpr double kSnap = 0.02;
// The least noise that the control must remove, as a share of its own. With less, nearly all of the
// map is hidden, and the control takes up to a tenth of the time to remove a few hundredths of the
// noise.
constexpr double kWorthwhile = 0.1;

// A surface that the pilot has met: what its light sample and its scattered ray have brought of the
// map, and what the control has subtracted for both, its integral included: 0 on average.
struct ControlledSurface {
  PlaceWord place = 0;
  float brought = 0, control = 0;  // luminance
};

// Collects the surfaces of a wave of the pilot.
class ControlledSurfaceList {
 public:
  ControlledSurfaceList(const FrameView& pilot, const PlaceBox& box,
                        std::vector<ControlledSurface>& surfaces)
      : pilot_(pilot),
        box_(box),
        misses_(PaddedRows(pilot.options.wave), kMissQueue),
        surfaces_(surfaces) {}

  void SeeLightSamples(const Worker& w, std::uint32_t n) {
    Finish();
    const SurfaceColumns& s = w.surfaces;
    const LightColumns& lights = w.lights;
    const ControlColumns& control = w.of<ControlTables>().subtracted;
    for (std::uint32_t i = 0; i < n; ++i) {
      // Only light from infinitely far away has this reach, unless it is occluded.
      const bool arrives = lights.t_far[i] == std::numeric_limits<float>::infinity();
      at_hand_.push_back(
          {.place = PackPlace(box_, {s.org_x[i], s.org_y[i], s.org_z[i]},
                              {s.ns_x[i], s.ns_y[i], s.ns_z[i]}),
           .brought = arrives ? float(Luminance(lights.r[i], lights.g[i], lights.b[i])) : 0,
           .control = float(Luminance(control.r[i], control.g[i], control.b[i]))});
    }
  }

  // Adds what rays [0, n) bring to the surfaces that they have left.
  void SeeRays(const Worker& w, const RayColumns& rays, std::uint32_t n) {
    if (!pilot_.options.mis) return;
    const EscapeColumns& seen = w.escaped;
    MoveEscaped(rays, misses_.data(), n, seen);
    pilot_.strategy->EvaluateEscaped(
        Points(pilot_, w), n, pilot_.light_shares().strategy_samples(pilot_.light_samples()), seen);
    const ControlColumns& control = w.of<ControlTables>().subtracted;
    for (std::uint32_t i = 0; i < n; ++i) {
      if (!(rays.pdf[i] > 0) || rays.from[i] >= at_hand_.size()) continue;
      const double ratio = double(seen.light_pdf[i]) / rays.pdf[i],
                   weight = 1 / (1 + ratio * ratio);
      const auto gain = [&](float r, float g, float b) {
        return float(weight * Luminance(r * seen.radiance_r[i], g * seen.radiance_g[i],
                                        b * seen.radiance_b[i]));
      };
      ControlledSurface& surface = at_hand_[rays.from[i]];
      surface.control += gain(control.r[i], control.g[i], control.b[i]);
      if (w.hits->geom[i] != kNoHit) continue;
      surface.brought += gain(rays.throughput_r[i], rays.throughput_g[i], rays.throughput_b[i]);
    }
  }
  void SeeEscapes(const Worker&, std::uint32_t) {}

  // Adds the current surfaces to the list; all their rays have been seen.
  void Finish() {
    for (const ControlledSurface& surface : at_hand_) {
      if (surface.control != 0) surfaces_.push_back(surface);
    }
    at_hand_.clear();
  }

 private:
  const FrameView& pilot_;
  PlaceBox box_;
  std::vector<std::uint32_t> misses_;  // the queue of a wave of escaped rays
  std::vector<ControlledSurface> at_hand_;
  std::vector<ControlledSurface>& surfaces_;
};

// Sums over surfaces of a node.
struct ControlSums {
  double cross = 0;    // what was brought, less its mean, times control
  double control = 0;  // control squared
  std::size_t count = 0;
};

ControlSums SumsOf(std::span<const ControlledSurface> surfaces) {
  ControlSums sums;
  sums.count = surfaces.size();
  double brought = 0, mean_zero = 0;
  for (const ControlledSurface& surface : surfaces) {
    brought += surface.brought, mean_zero += surface.control;
    sums.cross += double(surface.brought) * surface.control;
    sums.control += double(surface.control) * surface.control;
  }
  sums.cross -= brought * mean_zero / double(std::max<std::size_t>(sums.count, 1));
  return sums;
}

double Weight(const ControlSums& sums, double above, double prior) {
  if (!(sums.control > 0)) return above;
  const double weight = (sums.cross + prior * above) / (sums.control + prior);
  return weight < kSnap ? 0 : weight > 1 - kSnap ? 1 : weight;
}

// Sets the weights of all places from the surfaces, which are sorted by place. Returns how much
// noise they remove, as a share of the control's own.
double SetWeights(std::span<const ControlledSurface> surfaces, ControlWeights& weights) {
  const ControlSums all = SumsOf(surfaces);
  const std::vector<PlaceTree::Node>& nodes = weights.tree.nodes;
  std::vector<double> of_nodes(nodes.size()), gain(nodes.size());
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const bool is_root = nodes[i].parent == i;
    const ControlSums sums =
        SumsOf(surfaces.subspan(nodes[i].begin, nodes[i].end - nodes[i].begin));
    const double mean = sums.control / double(std::max<std::size_t>(sums.count, 1));
    of_nodes[i] = Weight(sums, is_root ? Weight(all, 0, 0) : of_nodes[nodes[i].parent],
                         kPriorSurfaces * mean);
    gain[i] = of_nodes[i] * (2 * sums.cross - of_nodes[i] * sums.control);
    if (!is_root) gain[nodes[i].parent] = 0;  // its children stand for it
  }
  for (const std::uint32_t node : weights.tree.places) {
    weights.of_places.push_back(float(of_nodes[node]));
  }
  return std::accumulate(gain.begin(), gain.end(), 0.0) / std::max(all.control, 1e-300);
}

}  // namespace

std::unique_ptr<ControlWeights> LearnControl(WorkerPool& pool, FrameView& frame,
                                             PilotCounts& counts) {
  const PlaceBox box = PlaceBoxOf(frame.sphere);
  if (!(box.side > 0)) return nullptr;
  auto learnt = std::make_unique<ControlWeights>();
  ControlWeights& weights = *learnt;
  const ControlView unweighted = {.irradiance = frame.find<ControlView>()->irradiance};
  const auto start = Clock::now();
  FrameView pilot = PilotView(frame, *frame.strategy, PilotShare(frame));
  pilot.Show(&unweighted);
  pilot.options.mis = frame.options.mis;
  if (Describe(frame.options.integrator).direct_light_only) pilot.options.max_depth = 1;
  std::vector<ControlledSurface> surfaces = TracePilot<ControlledSurface>(
      pilot, pool,
      [&](const WaveRange& range, Worker& worker, std::vector<ControlledSurface>& some) {
        ControlledSurfaceList list(pilot, box, some);
        FollowPilotPaths(pilot, range, worker, list);
        list.Finish();
      });
  // Sums run in an order that does not depend on waves.
  const auto key = [](const ControlledSurface& s) {
    return std::tie(s.place, s.control, s.brought);
  };
  tbb::parallel_sort(surfaces.begin(), surfaces.end(),
                     [&](const auto& a, const auto& b) { return key(a) < key(b); });
  std::vector<PlaceWord> words(surfaces.size());
  std::transform(surfaces.begin(), surfaces.end(), words.begin(),
                 [](const ControlledSurface& surface) { return surface.place; });
  weights.tree = BuildPlaceTree(words, box, kSplitSurfaces, kMostPlaces);

  const double gain = SetWeights(surfaces, weights);
  const auto are_all = [&](float weight) {
    return std::all_of(weights.of_places.begin(), weights.of_places.end(),
                       [&](float of_place) { return of_place == weight; });
  };
  counts.paths += PilotPaths(pilot);
  counts.samples += surfaces.size();
  counts.bytes += weights.tree.bytes() + weights.of_places.size() * sizeof(float);
  counts.seconds += SecondsSince(start);
  if (gain < kWorthwhile) {
    frame.Show<ControlView>(nullptr);
  } else if (!are_all(1)) {
    weights.shown = {
        .irradiance = unweighted.irradiance,
        .weights = {.places = weights.tree.view(), .weight = weights.of_places.data()}};
    frame.Show(&weights.shown);
  }
  return learnt;
}

namespace {

bool Controls(Integrator integrator) { return Describe(integrator).controls; }

std::span<const RenderOption> Options() {
  // clang-format off
  static const RenderOption table[] = {
      Refused("is for light samples of paths from the camera alone", MakeRenderOption({.name = "control", .group = "Light", .help = "control variate: sample only what is hidden of the map's known irradiance on diffuse surfaces", .scope = OptionScope::kPixels, .example = "--control irradiance", .applies = Controls},
                       SKYWAVE_FIELD_OF(ControlOptions, control), NamesOfEnum<ControlVariate>())),
  };
  // clang-format on
  return table;
}

void AddTables(const RenderOptions& options, Worker& worker) {
  if (options.of<ControlOptions>().control == ControlVariate::kNone) return;
  worker.tables.Add<ControlTables>(options.wave);
}

std::shared_ptr<const void> Teach(FrameView& frame, const Pilots& pilots) {
  if (frame.find<ControlView>() == nullptr) return nullptr;
  PilotCounts counts = {.policy = "control", .found = "surfaces"};
  std::unique_ptr<ControlWeights> learnt = LearnControl(pilots.pool, frame, counts);
  if (learnt) pilots.reports.counts.push_back(counts);
  return std::shared_ptr<const ControlWeights>(std::move(learnt));
}

}  // namespace

PolicyDescriptor ControlPolicy() {
  return {.options = Options, .add_tables = AddTables, .teach = Teach};
}

}  // namespace skywave
