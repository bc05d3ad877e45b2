// Tests the queues: every ray is in the right one, once, in order, with all its data.

#include "kernels/partition.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>

#include "kernels/lights/irradiance.h"
#include "scene/materials/texture_tables.h"
#include "scene/scene.h"
#include "tests/support/random_rows.h"
#include "tests/support/targets.h"

namespace skywave {
namespace {

constexpr BsdfSet kAll = (BsdfSet{1} << kBsdfKinds) - 1;

class Partition : public testing::Test {
 protected:
  Partition() : rays_(kFullWave), hits_(kFullWave), triangles_(100) {
    Random random(91);
    for (std::uint32_t i = 0; i < triangles_.size(); ++i) {
      // The other bits of the tag must not affect the kind.
      triangles_[i].tag = (random.Word() & (kMaterialMask | kFlatTriangle)) | i % kBsdfKinds
                                                                                  << kKindShift;
    }
    // All columns hold distinct values.
    std::uint32_t next = 1;
    RayColumns rays = rays_;
    RayColumns::ForEachColumn(rays, [&](auto*& column) { Number(column, next); });
    HitColumns hits = hits_;
    HitColumns::ForEachColumn(hits, [&](auto*& column) { Number(column, next); });
    for (std::uint32_t i = 0; i < kFullWave; ++i) {
      const bool hit = i < 40 ? i % 2 == 0 : random.Float() < 0.7f;
      hits.geom[i] = hit ? 0 : kNoHit;
      // A miss leaves stale data, far outside the table.
      hits.triangle[i] = hit ? random.Word() % std::uint32_t(triangles_.size()) : 0x3FFFFFFFu;
      rays.pdf[i] = random.Float() < 0.5f ? 0.0f : 1.5f;
    }
  }
  template <class T>
  static void Number(T* column, std::uint32_t& next) {
    for (std::uint32_t i = 0; i < kFullWave; ++i) column[i] = T(next++);
  }
  std::uint32_t QueueOf(std::uint32_t row) const {
    if (hits_->geom[row] == kNoHit) return kMissQueue;
    return triangles_[hits_->triangle[row]].tag >> kKindShift;
  }
  // Returns the rows of a queue that are below n, in order.
  std::vector<std::uint32_t> RowsOf(std::uint32_t queue, std::uint32_t n, bool only_sparse) const {
    std::vector<std::uint32_t> rows;
    for (std::uint32_t i = 0; i < n; ++i) {
      const bool dropped = only_sparse && queue != kMissQueue && rays_->pdf[i] > 0;
      if (QueueOf(i) == queue && !dropped) rows.push_back(i);
    }
    return rows;
  }
  template <class T>
  static void ExpectMoved(const T* from, const T* to, const std::vector<std::uint32_t>& rows,
                          const char* column, T factor = T(1)) {
    for (std::size_t k = 0; k < rows.size(); ++k) {
      ASSERT_EQ(to[k], factor * from[rows[k]]) << column << " of row " << rows[k];
    }
  }

  void ExpectQueues(BsdfSet present);

  soa::Table<RayColumns> rays_;
  soa::Table<HitColumns> hits_;
  std::vector<TriangleRecord> triangles_;
  std::vector<std::uint32_t> queue_ = std::vector<std::uint32_t>(PaddedRows(kFullWave));
};

// Checks rows of all triangles, whose BSDFs are `present`.
void Partition::ExpectQueues(BsdfSet present) {
  ForEachTarget([&] {
    for (const std::uint32_t n : kRowCounts) {
      for (const bool only_sparse : {false, true}) {
        std::fill(queue_.begin(), queue_.end(), 0xDEADBEEFu);
        // Counts are added to the existing ones.
        std::array<std::uint32_t, kBsdfKinds + 1> count;
        for (std::uint32_t k = 0; k <= kMissQueue; ++k) count[k] = 10 * (k + 1);
        ClassifyHits(hits_, triangles_.data(), present, only_sparse ? rays_->pdf : nullptr, n,
                     queue_.data(), count.data());
        for (std::uint32_t k = 0; k <= kMissQueue; ++k) {
          const auto rows = RowsOf(k, n, only_sparse);
          EXPECT_EQ(count[k], 10 * (k + 1) + rows.size())
              << "queue " << k << " of " << n << " rows";
          for (const std::uint32_t row : rows) ASSERT_EQ(queue_[row], k) << "row " << row;
        }
        std::size_t queued = 0;
        for (std::uint32_t i = 0; i < n; ++i) queued += queue_[i] <= kMissQueue;
        std::size_t wanted = 0;
        for (std::uint32_t k = 0; k <= kMissQueue; ++k) wanted += count[k] - 10 * (k + 1);
        EXPECT_EQ(queued, wanted);
        // Whole vectors are written; rows from n to the end of the last one are in no queue.
        for (std::uint32_t i = n; i < (n + kPadRows - 1) / kPadRows * kPadRows; ++i) {
          ASSERT_GT(queue_[i], kMissQueue) << "padding row " << i;
        }
      }
    }
  });
}

TEST_F(Partition, ClassifiesAndCounts) { ExpectQueues(kAll); }

// With one BSDF, the triangle records are not read.
TEST_F(Partition, ClassifiesWhereThereIsOneBsdf) {
  constexpr std::uint32_t kKind = 5;
  for (TriangleRecord& triangle : triangles_) {
    triangle.tag = (triangle.tag & ((1u << kKindShift) - 1)) | kKind << kKindShift;
  }
  ExpectQueues(BsdfSet{1} << kKind);
}

// Queues of BSDFs that are not announced are not counted, which is the purpose of the argument.
TEST_F(Partition, CountsThoseThatArePresent) {
  std::array<std::uint32_t, kBsdfKinds + 1> all = {}, some = {};
  ClassifyHits(hits_, triangles_.data(), kAll, nullptr, kFullWave, queue_.data(), all.data());
  const BsdfSet present = 0b1010;
  ClassifyHits(hits_, triangles_.data(), present, nullptr, kFullWave, queue_.data(), some.data());
  for (std::uint32_t k = 0; k < kBsdfKinds; ++k) {
    EXPECT_EQ(some[k], (present >> k & 1) != 0 ? all[k] : 0) << k;
  }
  EXPECT_EQ(some[kMissQueue], all[kMissQueue]);
}

// The second material of the mixture is itself a mixture, so there are three shares.
TEST(Mixtures, AreChosenByTheirShares) {
  constexpr std::uint32_t kFar = 0x3FFFFFFFu;
  std::vector<TriangleRecord> triangles(7);
  const auto mixed = [](std::uint32_t first, float share) {
    return TriangleRecord{.normal = {first, std::bit_cast<std::uint32_t>(share), 0},
                          .tag = kMixedTriangle};
  };
  triangles[2] = mixed(3, 0.75f);
  triangles[4] = mixed(5, 0.25f);
  soa::Table<HitColumns> hits(kFullWave);
  std::vector<float> u(PaddedRows(kFullWave));
  ForEachTarget([&] {
    for (const std::uint32_t n : kRowCounts) {
      for (std::uint32_t i = 0; i < kFullWave; ++i) {
        u[i] = (float(i) + 0.5f) / kFullWave;
        hits->geom[i] = i % 8 == 0 ? kNoHit : 0;
        hits->triangle[i] = i % 8 == 0 ? kFar : i % 8 == 1 ? 1 : 2;
      }
      ChooseMaterials(triangles.data(), {}, u.data(), n, hits);
      for (std::uint32_t i = 0; i < kFullWave; ++i) {
        const double x = u[i];
        std::uint32_t expected = x >= 0.75 ? 3 : x >= 0.75 * 0.25 ? 5 : 6;
        if (i % 8 == 0) expected = kFar;
        if (i % 8 == 1) expected = 1;
        if (i >= n && i % 8 > 1) expected = 2;
        ASSERT_EQ(hits->triangle[i], expected) << "row " << i << " of " << n;
      }
    }
  });
}

// The left half of the texture is .25 and the right one .75, read at their middles.
TEST(Mixtures, MayHaveTheShareOfATexture) {
  Scene scene;
  Image image(2, 1);
  std::fill_n(image.Pixel(0, 0), 3, 0.25f), std::fill_n(image.Pixel(1, 0), 3, 0.75f);
  scene.images = {image};
  scene.textures.resize(2);
  TextureTables tables = MakeTextureTables(scene, "test");
  tables.uvs.resize(5);
  tables.uvs[2] = {.uv = {{0, 0}, {1, 0}, {0, 1}}, .density = 1, .unused = 0};
  std::vector<TriangleRecord> triangles(5);
  triangles[2] = {.normal = {3, kShareOfTexture | 1, 0}, .tag = kMixedTriangle};
  soa::Table<HitColumns> hits(kFullWave);
  std::vector<float> u(PaddedRows(kFullWave));
  ForEachTarget([&] {
    for (std::uint32_t i = 0; i < kFullWave; ++i) {
      u[i] = (float(i / 2) + 0.5f) / (kFullWave / 2);
      hits->geom[i] = 0, hits->triangle[i] = 2;
      hits->u[i] = i % 2 == 0 ? 0.25f : 0.75f, hits->v[i] = 0;
    }
    ChooseMaterials(triangles.data(), tables.view(), u.data(), kFullWave, hits);
    for (std::uint32_t i = 0; i < kFullWave; ++i) {
      const float share = i % 2 == 0 ? 0.25f : 0.75f;
      ASSERT_EQ(hits->triangle[i], u[i] < share ? 4u : 3u) << i;
    }
  });
}

TEST_F(Partition, MissesAloneAreClassified) {
  ForEachTarget([&] {
    for (const std::uint32_t n : kRowCounts) {
      const auto rows = RowsOf(kMissQueue, n, false);
      EXPECT_EQ(ClassifyEscapes(hits_, n, queue_.data()), rows.size());
      for (std::uint32_t i = 0; i < n; ++i) {
        ASSERT_EQ(queue_[i] == kMissQueue, QueueOf(i) == kMissQueue) << "row " << i;
        ASSERT_TRUE(queue_[i] >= kMissQueue);
      }
    }
  });
}

TEST_F(Partition, MovesEscapedRays) {
  ForEachTarget([&] {
    for (const std::uint32_t n : kRowCounts) {
      std::array<std::uint32_t, kBsdfKinds + 1> count = {};
      ClassifyHits(hits_, triangles_.data(), kAll, nullptr, n, queue_.data(), count.data());
      soa::Table<EscapeColumns> to(kFullWave);
      FillWithGarbage(to.columns(), kFullWave);
      MoveEscaped(rays_, queue_.data(), n, to);
      const auto rows = RowsOf(kMissQueue, n, false);
      ExpectMoved(rays_->dir_x, to->dir_x, rows, "dir_x");
      ExpectMoved(rays_->dir_y, to->dir_y, rows, "dir_y");
      ExpectMoved(rays_->dir_z, to->dir_z, rows, "dir_z");
      ExpectMoved(rays_->throughput_r, to->throughput_r, rows, "throughput_r");
      ExpectMoved(rays_->throughput_g, to->throughput_g, rows, "throughput_g");
      ExpectMoved(rays_->throughput_b, to->throughput_b, rows, "throughput_b");
      ExpectMoved(rays_->pdf, to->pdf, rows, "pdf");
      ExpectMoved(rays_->path, to->path, rows, "path");
      ExpectMoved(rays_->from, to->from, rows, "from");
    }
  });
}

TEST_F(Partition, MovesHits) {
  ForEachTarget([&] {
    for (const std::uint32_t n : kRowCounts) {
      std::array<std::uint32_t, kBsdfKinds + 1> count = {};
      ClassifyHits(hits_, triangles_.data(), kAll, nullptr, n, queue_.data(), count.data());
      for (std::uint32_t kind = 0; kind < kBsdfKinds; ++kind) {
        soa::Table<SurfaceColumns> to(kFullWave);
        FillWithGarbage(to.columns(), kFullWave);
        MoveHits(rays_, hits_, queue_.data(), kind, n, to);
        const auto rows = RowsOf(kind, n, false);
        ExpectMoved(rays_->dir_x, to->wo_x, rows, "wo_x", -1.0f);
        ExpectMoved(rays_->dir_y, to->wo_y, rows, "wo_y", -1.0f);
        ExpectMoved(rays_->dir_z, to->wo_z, rows, "wo_z", -1.0f);
        ExpectMoved(hits_->ng_x, to->ng_x, rows, "ng_x");
        ExpectMoved(hits_->ng_y, to->ng_y, rows, "ng_y");
        ExpectMoved(hits_->ng_z, to->ng_z, rows, "ng_z");
        ExpectMoved(rays_->throughput_r, to->throughput_r, rows, "throughput_r");
        ExpectMoved(rays_->throughput_g, to->throughput_g, rows, "throughput_g");
        ExpectMoved(rays_->throughput_b, to->throughput_b, rows, "throughput_b");
        ExpectMoved(rays_->t_far, to->t, rows, "t");
        ExpectMoved(hits_->u, to->u, rows, "u");
        ExpectMoved(hits_->v, to->v, rows, "v");
        ExpectMoved(hits_->triangle, to->triangle, rows, "triangle");
        ExpectMoved(rays_->path, to->path, rows, "path");
      }
    }
  });
}

// What is left of any channel alone keeps a row, whether the ray escaped or not.
TEST_F(Partition, MovesWhatAControlLeaves) {
  soa::Table<ControlColumns> control(kFullWave);
  const float* const throughput[] = {rays_->throughput_r, rays_->throughput_g, rays_->throughput_b};
  float* const known[] = {control->r, control->g, control->b};
  // Of row i, 2 is left in channel i % 4; of every fourth row nothing is.
  for (std::uint32_t i = 0; i < kFullWave; ++i) {
    for (std::uint32_t c = 0; c < 3; ++c) {
      const float all = QueueOf(i) == kMissQueue ? throughput[c][i] : 0;
      known[c][i] = all - (i % 4 == c ? 2.0f : 0.0f);
    }
  }
  ForEachTarget([&] {
    for (const std::uint32_t n : kRowCounts) {
      std::array<std::uint32_t, kBsdfKinds + 1> count = {};
      ClassifyHits(hits_, triangles_.data(), kAll, nullptr, n, queue_.data(), count.data());
      std::vector<std::uint32_t> rows;
      for (std::uint32_t i = 0; i < n; ++i) {
        if (i % 4 < 3) rows.push_back(i);
      }
      soa::Table<EscapeColumns> to(kFullWave);
      FillWithGarbage(to.columns(), kFullWave);
      ASSERT_EQ(MoveControlled(rays_, queue_.data(), n, control, to), rows.size());
      for (std::size_t k = 0; k < rows.size(); ++k) {
        ASSERT_EQ(to->throughput_r[k], rows[k] % 4 == 0 ? 2 : 0) << "row " << rows[k];
        ASSERT_EQ(to->throughput_g[k], rows[k] % 4 == 1 ? 2 : 0) << "row " << rows[k];
        ASSERT_EQ(to->throughput_b[k], rows[k] % 4 == 2 ? 2 : 0) << "row " << rows[k];
      }
      ExpectMoved(rays_->dir_x, to->dir_x, rows, "dir_x");
      ExpectMoved(rays_->dir_y, to->dir_y, rows, "dir_y");
      ExpectMoved(rays_->dir_z, to->dir_z, rows, "dir_z");
      ExpectMoved(rays_->pdf, to->pdf, rows, "pdf");
      ExpectMoved(rays_->path, to->path, rows, "path");
      ExpectMoved(rays_->from, to->from, rows, "from");
    }
  });
}

}  // namespace
}  // namespace skywave
