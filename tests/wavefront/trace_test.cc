// Tests tracing with Embree: all backends give the same bits, also for odd rays and odd counts.
#include "wavefront/rays/trace.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "kernels/camera.h"
#include "scene/geometry.h"
#include "tests/support/random_rows.h"
#include "tests/support/render_scenes.h"
#include "tests/support/targets.h"
#include "wavefront/rays/ray_recorder.h"

namespace skywave {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

// Returns balls, a plane with many edges, and triangles without area.
Scene Clutter() {
  Scene scene;
  AddLambert(scene, "grey", glm::vec3(0.5f));
  for (int i = 0; i < 5; ++i) {
    Place(scene, Sphere(0.5f, 6), 0, {1.1f * float(i) - 2, 0.5f, 0.3f * float(i)});
  }
  Place(scene, Quad(4), 0, glm::vec3(0));
  Mesh degenerate;
  degenerate.positions = {{0, 1, 0}, {1, 1, 0}, {2, 1, 0}, {0, 1, 0}};
  degenerate.triangles = {{0, 1, 2}, {0, 0, 1}, {0, 3, 0}};
  Place(scene, degenerate, 0, glm::vec3(0));
  return scene;
}

struct TestRay {
  Vec org, dir;
  float t_far = kInfinity;
};

enum class Kind { kRandom, kVertices, kDegenerate };

std::vector<TestRay> Rays(const Scene& scene, Kind kind, std::uint32_t n) {
  Random random(7);
  std::vector<glm::vec3> vertices;
  for (const Mesh& mesh : scene.meshes) {
    vertices.insert(vertices.end(), mesh.positions.begin(), mesh.positions.end());
  }
  std::vector<TestRay> rays(n);
  for (TestRay& ray : rays) {
    ray.org = {random.Between(-3, 3), random.Between(-0.5, 3), random.Between(-3, 3)};
    ray.dir = random.Direction();
    if (kind == Kind::kRandom) continue;
    const glm::vec3 a = vertices[random.Word() % vertices.size()];
    const glm::vec3 b = vertices[random.Word() % vertices.size()];
    if (kind == Kind::kVertices) {
      // The target is a vertex or the middle of two, often on an edge.
      const double share = random.Word() % 2 ? 0.0 : 0.5;
      const glm::dvec3 p = (1 - share) * glm::dvec3(a) + share * glm::dvec3(b);
      ray.dir = Unit(Vec{p.x, p.y, p.z} - ray.org);
      continue;
    }
    switch (random.Word() % 8) {
      case 0:
        ray.dir = {0, -1, 0};
        break;
      case 1:
        ray.dir = {1, 0, 0}, ray.org.y = 0;
        break;  // inside the plane
      case 2:
        ray.dir = {-0.0, 0, 1};
        break;
      case 3:
        ray.org = {a.x, a.y, a.z};
        break;  // from a vertex
      case 4:
        ray.dir = Unit(Vec{1e-30, -1, 1e-38});
        break;
      case 5:
        ray.org = {1e12, 1e12, -1e12}, ray.dir = Unit({-1, -1, 1});
        break;
      case 6:
        ray.t_far = 0;
        break;
      default:
        ray.t_far = float(random.Between(0, 2));
        break;
    }
  }
  return rays;
}

struct Wave {
  explicit Wave(const std::vector<TestRay>& test_rays)
      : rays(std::uint32_t(test_rays.size())), hits(std::uint32_t(test_rays.size())) {
    FillWithGarbage(rays.columns(), rays.rows());
    FillWithGarbage(hits.columns(), hits.rows());
    for (std::uint32_t i = 0; i < rays.rows(); ++i) {
      Put(test_rays[i].org, i, rays->org_x, rays->org_y, rays->org_z);
      Put(test_rays[i].dir, i, rays->dir_x, rays->dir_y, rays->dir_z);
      rays->t_far[i] = test_rays[i].t_far;
    }
  }
  // Returns the bits that describe where the rays ended; for a miss, only that it is one.
  std::vector<std::uint32_t> Bits() const {
    std::vector<std::uint32_t> bits;
    for (std::uint32_t i = 0; i < rays.rows(); ++i) {
      bits.push_back(hits->geom[i]);
      bits.push_back(std::bit_cast<std::uint32_t>(rays->t_far[i]));
      if (hits->geom[i] == kNoHit) continue;
      for (const float* column : {hits->ng_x, hits->ng_y, hits->ng_z, hits->u, hits->v}) {
        bits.push_back(std::bit_cast<std::uint32_t>(column[i]));
      }
      bits.push_back(hits->triangle[i]);
    }
    return bits;
  }
  soa::Table<RayColumns> rays;
  soa::Table<HitColumns> hits;
};

class Trace : public testing::TestWithParam<Kind> {
 protected:
  Tracer TracerOf(Backend backend) const {
    return {.scene = geometry.scene(), .closest = backend, .occlusion = backend};
  }
  Scene scene = Clutter();
  Geometry geometry{scene, "clutter", 2};
};

TEST_P(Trace, AllBackendsFindTheSameClosestHits) {
  for (const std::uint32_t n : {1u, 2u, 7u, 8u, 17u, kFullWave, 20000u}) {
    const std::vector<TestRay> rays = Rays(scene, GetParam(), n);
    std::vector<std::uint32_t> first;
    for (const Backend backend : kBackends) {
      SCOPED_TRACE(ToString(backend));
      Wave wave(rays);
      TraceClosest(TracerOf(backend), RayKind::kBounce, wave.rays, n, wave.hits);
      if (first.empty()) first = wave.Bits();
      EXPECT_EQ(wave.Bits(), first);
      if (n == 20000) {
        const auto hits = std::count(wave.hits->geom, wave.hits->geom + n, 0u);
        EXPECT_GT(hits, n / 20);
        if (GetParam() == Kind::kRandom) {
          EXPECT_LT(hits, n - n / 20);
        }
      }
    }
  }
}

TEST_P(Trace, OcclusionMatchesTheClosestHitForAllBackends) {
  const std::vector<TestRay> rays = Rays(scene, GetParam(), 20000);
  Wave closest(rays);
  TraceClosest(TracerOf(Backend::kSingle), RayKind::kBounce, closest.rays, closest.rays.rows(),
               closest.hits);
  for (const Backend backend : kBackends) {
    SCOPED_TRACE(ToString(backend));
    Wave wave(rays);
    TraceOcclusion(TracerOf(backend), wave.rays, wave.rays.rows());
    for (std::uint32_t i = 0; i < wave.rays.rows(); ++i) {
      ASSERT_EQ(wave.rays->t_far[i] < 0, closest.hits->geom[i] != kNoHit) << i;
      if (wave.rays->t_far[i] >= 0) {
        ASSERT_EQ(wave.rays->t_far[i], rays[i].t_far);
      }
    }
    Wave escapes(rays);
    TraceEscapes(TracerOf(backend), RayKind::kBounce, escapes.rays, escapes.rays.rows(),
                 escapes.hits);
    for (std::uint32_t i = 0; i < wave.rays.rows(); ++i) {
      ASSERT_EQ(escapes.hits->geom[i], closest.hits->geom[i]) << i;
    }
  }
}

// The hits of a beam depend on its own rays alone, not on the backend or on neighbouring beams.
// Here its rays are incoherent, so that hits at edges do depend on the other rays of the beam.
TEST_P(Trace, BeamsHaveTheSameBitsInAnyWave) {
  constexpr std::uint32_t n = 20000, some = 3 * kBeamRays;
  const std::vector<TestRay> rays = Rays(scene, GetParam(), n);
  Wave all(rays);
  TraceClosest(TracerOf(Backend::kBest), RayKind::kCamera, all.rays, n, all.hits);
  const std::vector<std::uint32_t> bits = all.Bits();
  for (const Backend backend : kBackends) {
    SCOPED_TRACE(ToString(backend));
    std::vector<std::uint32_t> found;
    for (std::uint32_t i = 0; i < n; i += some) {
      const std::uint32_t end = std::min(i + some, n);
      Wave wave(std::vector<TestRay>(rays.begin() + i, rays.begin() + end));
      TraceClosest(TracerOf(backend), RayKind::kCamera, wave.rays, end - i, wave.hits);
      const std::vector<std::uint32_t> part = wave.Bits();
      found.insert(found.end(), part.begin(), part.end());
    }
    EXPECT_EQ(found, bits);
  }
  // Conversely, beams that begin three rays later give different results.
  if (GetParam() == Kind::kVertices) {
    Wave shifted(std::vector<TestRay>(rays.begin() + 3, rays.end()));
    TraceClosest(TracerOf(Backend::kBest), RayKind::kCamera, shifted.rays, n - 3, shifted.hits);
    std::uint32_t others = 0;
    for (std::uint32_t i = 3; i < n; ++i)
      others += shifted.rays->t_far[i - 3] != all.rays->t_far[i];
    EXPECT_GT(others, 0u);
  }
}

// Rows after the last ray keep their values.
TEST_P(Trace, RowsAfterTheLastKeepTheirValues) {
  for (const std::uint32_t n : kRowCounts) {
    const std::vector<TestRay> rays = Rays(scene, GetParam(), kFullWave + 30);
    for (const Backend backend : kBackends) {
      SCOPED_TRACE(ToString(backend));
      Wave wave(rays);
      TraceClosest(TracerOf(backend), RayKind::kBounce, wave.rays, n, wave.hits);
      for (std::uint32_t i = n; i < wave.rays.rows(); ++i) {
        ASSERT_EQ(wave.rays->t_far[i], rays[i].t_far) << i;
        ASSERT_EQ(wave.hits->geom[i], 0x7FC5A5A5u) << i;
        ASSERT_EQ(wave.hits->triangle[i], 0x7FC5A5A5u) << i;
      }
      for (std::uint32_t i = 0; i < n; ++i) ASSERT_NE(wave.hits->geom[i], 0x7FC5A5A5u) << i;
    }
  }
}

#if RTC_VERSION_MAJOR < 4
// A stream without tnear, time, mask, id and flags behaves as if they were 0, 0, all bits, any, 0.
// Embree documents this for time only; the stream backend relies on it for all.
TEST_P(Trace, StreamColumnsThatAreNullHaveTheirDefaults) {
  const std::vector<TestRay> rays = Rays(scene, GetParam(), kFullWave);
  Wave wave(rays), full(rays);
  TraceClosest(TracerOf(Backend::kStream), RayKind::kBounce, wave.rays, kFullWave, wave.hits);

  const RayColumns r = full.rays;
  const HitColumns h = full.hits;
  std::vector<float> zeros(kFullWave, 0.0f);
  std::vector<unsigned> all(kFullWave, ~0u), ids(kFullWave, 5u), flags(kFullWave, 0u),
      instances(kFullWave, RTC_INVALID_GEOMETRY_ID);
  std::fill_n(h.geom, kFullWave, kNoHit);
  RTCRayHitNp batch = {.ray = {.org_x = r.org_x,
                               .org_y = r.org_y,
                               .org_z = r.org_z,
                               .tnear = zeros.data(),
                               .dir_x = r.dir_x,
                               .dir_y = r.dir_y,
                               .dir_z = r.dir_z,
                               .time = zeros.data(),
                               .tfar = r.t_far,
                               .mask = all.data(),
                               .id = ids.data(),
                               .flags = flags.data()},
                       .hit = {.Ng_x = h.ng_x,
                               .Ng_y = h.ng_y,
                               .Ng_z = h.ng_z,
                               .u = h.u,
                               .v = h.v,
                               .primID = h.triangle,
                               .geomID = h.geom,
                               .instID = {instances.data()}}};
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcIntersectNp(geometry.scene(), &context, &batch, kFullWave);
  EXPECT_EQ(full.Bits(), wave.Bits());
}
#endif

TEST_P(Trace, ClosedShadowRowsStayUntouched) {
  const std::vector<TestRay> rays = Rays(scene, GetParam(), kFullWave);
  for (const Backend backend : kBackends) {
    SCOPED_TRACE(ToString(backend));
    for (const std::uint32_t n : kRowCounts) {
      soa::Table<SurfaceColumns> surfaces(kFullWave);
      soa::Table<LightColumns> lights(kFullWave);
      for (std::uint32_t i = 0; i < kFullWave; ++i) {
        Put(rays[i].org, i, surfaces->org_x, surfaces->org_y, surfaces->org_z);
        Put(rays[i].dir, i, lights->dir_x, lights->dir_y, lights->dir_z);
        lights->t_far[i] = i % 3 == 0 ? -1.0f - float(i) : kInfinity;
      }
      TraceShadows(TracerOf(backend), surfaces, n, lights);
      std::uint32_t occluded = 0;
      for (std::uint32_t i = 0; i < kFullWave; ++i) {
        if (i % 3 == 0) {
          ASSERT_EQ(lights->t_far[i], -1.0f - float(i)) << i;
        } else if (i >= n) {
          ASSERT_EQ(lights->t_far[i], kInfinity) << i;
        } else {
          ASSERT_TRUE(lights->t_far[i] == kInfinity || lights->t_far[i] == -kInfinity) << i;
          occluded += lights->t_far[i] < 0;
        }
      }
      EXPECT_GE(occluded, n == kFullWave ? n / 20 : 0);
    }
  }
}

TEST_P(Trace, RecorderKeepsOpenRaysInOrder) {
  std::vector<TestRay> rays = Rays(scene, GetParam(), 50);
  for (std::size_t i = 0; i < rays.size(); ++i) rays[i].t_far = i % 4 == 1 ? -1 : kInfinity;
  RayRecorder recorder;
  Tracer tracer = TracerOf(Backend::kPacket);
  tracer.recorder = &recorder;
  Wave wave(rays);
  TraceEscapes(tracer, RayKind::kBounce, wave.rays, 20, wave.hits);
  TraceEscapes(tracer, RayKind::kBounce, wave.rays, 0, wave.hits);
  ASSERT_EQ(recorder.batches().size(), 1u);
  EXPECT_EQ(recorder.batches()[0].kind, RayKind::kBounce);
  EXPECT_TRUE(recorder.batches()[0].occlusion);
  EXPECT_EQ(recorder.batches()[0].begin, 0u);
  EXPECT_EQ(recorder.batches()[0].count, 15u);
  for (std::uint32_t i = 0, kept = 0; i < 20; ++i) {
    if (i % 4 == 1) continue;
    EXPECT_EQ(recorder.dir(1)[kept], float(rays[i].dir.y));
    EXPECT_EQ(recorder.org(2)[kept], float(rays[i].org.z));
    ++kept;
  }
}

INSTANTIATE_TEST_SUITE_P(Rays, Trace,
                         testing::Values(Kind::kRandom, Kind::kVertices, Kind::kDegenerate),
                         [](const auto& test) {
                           return test.param == Kind::kRandom     ? "Random"
                                  : test.param == Kind::kVertices ? "Vertices"
                                                                  : "Degenerate";
                         });

}  // namespace
}  // namespace skywave
