#include "wavefront/photon_pass.h"

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>

#include "wavefront/flush_denormals.h"
#include "wavefront/integrator.h"
#include "wavefront/photon_stages.h"
#include "wavefront/render.h"

namespace skywave {
namespace {

// Light paths that are traced before anybody looks how full the maps are.
constexpr std::uint64_t kLeastRound = 1 << 14, kMostRound = 1 << 18;

// A map before it is built: photons in the order of light paths, and how many of these they are of.
struct Harvest {
  std::uint64_t wanted;
  std::vector<Photon> photons;
  std::uint64_t light_paths = 0;

  bool full() const { return photons.size() >= wanted; }
  std::uint64_t missing() const { return full() ? 0 : wanted - photons.size(); }

  // Takes the photons of waves of `wave` light paths each, paths [first, end) in all, up to the
  // path that fills the map.
  void Take(const std::vector<PhotonLists>& waves, PhotonList PhotonLists::*kind,
            std::uint64_t first, std::uint64_t end, std::uint64_t wave) {
    struct Part {
      const PhotonList* list;
      std::size_t count, at;
    };
    std::vector<Part> parts;
    std::size_t size = photons.size();
    for (std::size_t i = 0; i < waves.size() && size < wanted; ++i, first += wave) {
      const PhotonList& list = waves[i].*kind;
      const std::size_t all = list.path.size();
      std::size_t count = std::min<std::size_t>(all, wanted - size);
      while (count > 0 && count < all && list.path[count] == list.path[count - 1]) ++count;
      parts.push_back({.list = &list, .count = count, .at = size});
      size += count;
      light_paths = size < wanted ? std::min(first + wave, end) : first + list.path[count - 1] + 1;
    }
    photons.resize(size);
    tbb::parallel_for(std::size_t{0}, parts.size(), [&](std::size_t i) {
      std::copy_n(parts[i].list->photons.begin(), parts[i].count,
                  photons.begin() + std::ptrdiff_t(parts[i].at));
    });
  }
};

// The strategy of camera paths may want many light samples or surfaces to draw them for.
FrameView LightPathView(const FrameView& frame) {
  FrameView view = frame;
  view.strategy = frame.emitter;
  view.options.light_samples = 1;
  return view;
}

// The largest distance of a lookup where the user gives none. A search for the nearest ends by
// itself where there are photons, so it is for the places where there are few.
float ChooseRadius(const PhotonMap& map, const PhotonOptions& options) {
  constexpr float kSearch = 3;
  if (options.distance > 0) return options.distance;
  return map.TypicalDistance(options.neighbors) * (options.progressive() ? 1 : kSearch);
}

}  // namespace

bool HasCaustics(const Geometry& geometry) { return (geometry.bsdfs() >> kFirstDeltaBsdf) != 0; }

std::vector<PhotonPass> PhotonPasses(const RenderOptions& options) {
  const std::uint32_t samples = options.samples_per_pixel, wanted = options.photons.passes;
  const bool each_sample = options.integrator == Integrator::kVcm && wanted == 0;
  const std::uint32_t passes = each_sample ? samples : std::clamp(wanted, 1u, samples);
  const auto first_of = [&](std::uint32_t pass) {
    return std::uint32_t(std::uint64_t(samples) * pass / passes);
  };
  std::vector<PhotonPass> list;
  double shrink2 = 1;
  const auto shrink = [&](std::uint32_t pass) {
    shrink2 *= (pass + 1 + double(options.photons.alpha)) / (pass + 2);
  };
  // Where a pass is a sample, the passes of a range of samples are those of the whole.
  if (each_sample) {
    for (std::uint32_t i = 0; i < options.first_sample; ++i) shrink(i);
  }
  const std::uint32_t before = each_sample ? options.first_sample : 0;
  for (std::uint32_t i = 0; i < passes; ++i) {
    list.push_back({.first_sample = options.first_sample + first_of(i),
                    .samples = first_of(i + 1) - first_of(i),
                    .shrink = float(std::sqrt(shrink2))});
    shrink(before + i);
  }
  return list;
}

PhotonMaps TracePhotons(const FrameView& frame, const PhotonPass& pass,
                        std::vector<std::unique_ptr<Worker>>& workers,
                        std::vector<RayRecorder>* recorders) {
  const FrameView lit = LightPathView(frame);
  const PhotonOptions& wish = frame.options.photons;
  const std::uint32_t wave = frame.options.wave;
  // One set of photons for all samples, whichever of them are rendered, or one for each pass.
  const std::uint64_t first_number =
      wish.progressive() ? std::uint64_t(pass.first_sample) << 32 : 0;
  Harvest caustic = {.wanted = HasCaustics(*frame.geometry) ? wish.caustic : 0, .photons = {}};
  Harvest indirect = {.wanted = wish.indirect, .photons = {}};
  // A photon that is no direct light at the surface that is seen has met one before.
  if (frame.options.max_depth < 2) caustic.wanted = indirect.wanted = 0;
  // The path that fills a map may bring more. Memory is known beforehand: growth would double it.
  for (Harvest* const harvest : {&caustic, &indirect}) {
    if (harvest->wanted > 0) harvest->photons.reserve(harvest->wanted + frame.options.max_depth);
  }
  const std::uint64_t most = kMostPathsAPhoton * std::max(caustic.wanted, indirect.wanted);
  std::vector<PhotonLists> waves;
  for (std::uint64_t traced = 0; traced < most && !(caustic.full() && indirect.full());) {
    const std::uint64_t missing = std::max(caustic.missing(), indirect.missing());
    const std::uint64_t round =
        std::min(std::clamp(missing, kLeastRound, kMostRound), most - traced);
    const PhotonWishes wishes = {
        .caustic = !caustic.full(), .indirect = !indirect.full(), .all_light = wish.gather > 0};
    waves.assign((round + wave - 1) / wave, {});
    tbb::parallel_for(std::size_t{0}, waves.size(), [&](std::size_t i) {
      const FlushDenormals flush;
      const std::size_t slot = OwnWorker(frame.options, workers);
      FrameView view = lit;
      view.tracer.recorder = recorders != nullptr ? &(*recorders)[slot] : nullptr;
      const std::uint64_t first = traced + i * wave;
      TracePhotonWave(view, first_number + first,
                      std::uint32_t(std::min<std::uint64_t>(wave, traced + round - first)), wishes,
                      *workers[slot], waves[i]);
    });
    caustic.Take(waves, &PhotonLists::caustic, traced, traced + round, wave);
    indirect.Take(waves, &PhotonLists::indirect, traced, traced + round, wave);
    traced += round;
  }
  PhotonMaps maps;
  maps.caustic = PhotonMap(caustic.photons, caustic.light_paths);
  caustic = {};
  maps.indirect = PhotonMap(indirect.photons, indirect.light_paths);
  for (PhotonMap* const map : {&maps.caustic, &maps.indirect}) {
    map->radius = ChooseRadius(*map, wish);
  }
  return maps;
}

}  // namespace skywave
