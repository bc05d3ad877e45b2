// Draws uniformly what other strategies draw by the map.
#include "lights/strategies/baselines.h"
#include "wavefront/paths/pilot.h"
#include "wavefront/policy.h"
#include "wavefront/render_option.h"

namespace skywave {
namespace {

struct TwinPolicyOptions {
  bool evenly = false;
};

std::span<const RenderOption> Options() {
  static const RenderOption table[] = {MakeRenderOption({.name = "evenly",
                                                         .help = "draw light uniformly",
                                                         .scope = OptionScope::kPixels,
                                                         .example = "--evenly"},
                                                        SKYWAVE_FIELD_OF(TwinPolicyOptions, evenly),
                                                        Switches())};
  return table;
}

std::shared_ptr<const void> Teach(FrameView& frame, const Pilots& pilots) {
  if (!frame.options.of<TwinPolicyOptions>().evenly) return nullptr;
  const FrameView pilot = PilotView(frame, *frame.strategy, PilotShare(frame));
  const std::vector<float> met = TracePilot<float>(
      pilot, pilots.pool, [&](const WaveRange& range, Worker& w, std::vector<float>& found) {
        FollowToSurfaces(pilot, range, kFirstDeltaBsdf, 1, w, [&](const std::vector<float>&) {
          found.resize(found.size() + w.ranges.total());
        });
      });
  pilots.reports.counts.push_back(
      {.policy = "evenly", .found = "surfaces", .paths = PilotPaths(pilot), .samples = met.size()});
  auto even = std::make_shared<UniformStrategy>(*frame.map);
  frame.strategy = even.get();
  return even;
}

}  // namespace

PolicyDescriptor TwinPolicy() { return {.options = Options, .teach = Teach}; }

}  // namespace skywave
