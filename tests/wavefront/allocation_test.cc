// Once a worker is built, rendering allocates nothing.
//
// The C library's allocation functions are replaced by counting ones; operator new calls them. The
// address sanitizer replaces them itself, so its hooks count instead.
#include <gtest/gtest.h>

#include <cerrno>
#include <cstddef>
#include <memory>

#include "lights/strategies/strategy.h"
#include "scene/builtin/builtin.h"
#include "tests/support/painted_scene.h"
#include "tests/support/photon_maps.h"
#include "tests/support/screens_scene.h"
#include "tests/support/shade_points.h"
#include "wavefront/records/irradiance_cache.h"
#include "wavefront/records/photon_map.h"
#include "wavefront/records/virtual_lights.h"
#include "wavefront/render.h"

namespace {
// These are volatile because the compiler knows malloc and would move accesses that malloc cannot
// affect.
thread_local volatile bool counting = false;
thread_local volatile std::size_t allocations = 0;
void Count() { allocations = allocations + counting; }
}  // namespace

#if defined(__SANITIZE_ADDRESS__)
// sanitizer/allocator_interface.h declares it, but g++ does not ship that header.
extern "C" int __sanitizer_install_malloc_and_free_hooks(void (*malloc_hook)(const volatile void*,
                                                                             std::size_t),
                                                         void (*free_hook)(const volatile void*));
namespace {
const int hooks = __sanitizer_install_malloc_and_free_hooks(
    [](const volatile void*, std::size_t) { Count(); }, [](const volatile void*) {});
}
#else
// Libraries have to see these: operator new of libstdc++ 14 calls posix_memalign, that of 12
// aligned_alloc.
#pragma GCC visibility push(default)
extern "C" {
void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
void* __libc_memalign(std::size_t, std::size_t);

void* malloc(std::size_t bytes) { return Count(), __libc_malloc(bytes); }
void* calloc(std::size_t n, std::size_t bytes) { return Count(), __libc_calloc(n, bytes); }
void* realloc(void* old, std::size_t bytes) { return Count(), __libc_realloc(old, bytes); }
void* memalign(std::size_t alignment, std::size_t bytes) {
  return Count(), __libc_memalign(alignment, bytes);
}
void* aligned_alloc(std::size_t alignment, std::size_t bytes) { return memalign(alignment, bytes); }
int posix_memalign(void** out, std::size_t alignment, std::size_t bytes) {
  *out = memalign(alignment, bytes);
  return *out == nullptr ? ENOMEM : 0;
}
}
#pragma GCC visibility pop
#endif

namespace skywave {
namespace {

// Returns the number of allocations of this thread within `run`.
template <class Run>
std::size_t AllocationsOf(Run run) {
  allocations = 0;
  counting = true;
  run();
  counting = false;
  return allocations;
}

TEST(Allocations, OfEveryKindAreCounted) {
  void* volatile kept[6] = {};
  EXPECT_EQ(AllocationsOf([&] { kept[0] = std::malloc(10); }), 1u);
  EXPECT_EQ(AllocationsOf([&] { kept[1] = std::calloc(10, 2); }), 1u);
  EXPECT_EQ(AllocationsOf([&] { kept[2] = std::aligned_alloc(64, 128); }), 1u);
  EXPECT_EQ(AllocationsOf([&] { kept[3] = ::operator new(10); }), 1u);
  EXPECT_EQ(AllocationsOf([&] { kept[4] = ::operator new (128, std::align_val_t{64}); }), 1u);
  EXPECT_GE(AllocationsOf([&] { kept[0] = std::realloc(kept[0], 100000); }), 1u);
  std::free(kept[0]), std::free(kept[1]), std::free(kept[2]);
  ::operator delete(kept[3]);
  ::operator delete (kept[4], std::align_val_t{64});
  EXPECT_EQ(AllocationsOf([] {}), 0u);
  // This is the owner of the memory of tables.
  EXPECT_EQ(AllocationsOf([] { const soa::Table<RayColumns> table(100); }), 1u);
}

void ExpectNoAllocations(const RenderJob& job, const RenderMethod& method, Backend backend,
                         std::uint32_t split) {
  SCOPED_TRACE(ToString(backend));
  FrameView frame = job.frame(method);
  frame.options.backend = backend;
  frame.options.bsdf_samples = split;
  frame.options.wave = 600;  // the last wave is smaller
  frame.options.of<PhotonOptions>().passes = 1;
  Film film = job.MakeFilm(method.integrator);
  const std::unique_ptr<Worker> worker = MakeWorker(frame.options);
  const Tile tile = {0, 0, 32, 24};
  EachPassOf(frame, [&](const FrameView& pass) {
    const auto waves = [&] {
      const std::uint64_t rows = 32 * 24 * pass.options.samples_per_pixel;
      for (std::uint64_t first = 0; first < rows; first += 600) {
        const auto left = std::uint32_t(rows - first);
        RenderWave(pass, {tile, first, std::min(600u, left)}, *worker, film);
      }
    };
    // Nothing needs warming up, so this holds from the first wave on.
    EXPECT_EQ(AllocationsOf(waves), 0u);
  });
  EXPECT_EQ(worker->stats.rays[std::uint32_t(RayKind::kCamera)], 32u * 24 * 4);
}

// The tables of a strategy, which take longer than the waves, serve all backends.
void ExpectNoAllocations(const RenderJob& job, Integrator integrator, std::uint32_t split = 0) {
  SCOPED_TRACE(ToString(integrator));
  const RenderMethod method = job.MakeMethod(job.request().strategy, integrator);
  for (const Backend backend : kBackends) ExpectNoAllocations(job, method, backend, split);
}

void ExpectNoAllocations(Scene scene) {
  SetLight(scene, SkyWithSun(64, 32, 100, 0.2));  // the tables are temporary
  scene.portals = PortalsAroundTheOrigin();
  for (const StrategyFactory& factory : Strategies()) {
    // Tables of portals would take longer than all waves.
    const std::string strategy =
        std::string(factory.name) + (factory.needs_portals ? ":texels=64" : "");
    SCOPED_TRACE(strategy);
    JobRequest request = SmallRequest(32, 24, 4);
    request.strategy = strategy;
    request.max_depth = 12;
    request.options.light_samples = 3;
    request.options.of<PhotonOptions>().indirect = request.options.of<PhotonOptions>().caustic =
        1000;
    request.options.of<VirtualLightOptions>().count = 3;
    request.options.of<IrradianceCacheOptions>() = {.accuracy = 0.8f, .rays = 4};
    const RenderJob job(scene, request);
    ExpectNoAllocations(job, Integrator::kPath);
    ExpectNoAllocations(job, Integrator::kPath, /*split=*/2);
    ExpectNoAllocations(job, Integrator::kDirect);
    ExpectNoAllocations(job, Integrator::kIrradianceCache);
    if (!CanEmit(job.strategy())) continue;
    ExpectNoAllocations(job, Integrator::kPhoton);
    ExpectNoAllocations(job, Integrator::kLight);
    ExpectNoAllocations(job, Integrator::kBdpt);
    ExpectNoAllocations(job, Integrator::kVcm);
    ExpectNoAllocations(job, Integrator::kVpl);
  }
}

TEST(WaveAllocations, AreNone) { ExpectNoAllocations(BuiltinScene("spheres")); }
TEST(WaveAllocations, AreNoneWithTextures) { ExpectNoAllocations(PaintedScene()); }
TEST(WaveAllocations, AreNoneWithAlpha) { ExpectNoAllocations(ScreensScene()); }
TEST(WaveAllocations, AreNoneWithLocalLights) { ExpectNoAllocations(BuiltinScene("lamps")); }

}  // namespace
}  // namespace skywave
