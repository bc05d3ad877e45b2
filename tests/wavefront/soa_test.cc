// Tests tables of columns: alignment, separation, padding and clearing.
#include "wavefront/soa.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <set>
#include <vector>

#include "kernels/bsdf/bsdf.h"
#include "wavefront/worker.h"

namespace skywave {
namespace {

struct MixedColumns {
  std::uint8_t* byte;
  double* wide;
  std::uint16_t* half;
  float* number;

  template <class Self, class F>
  static constexpr void ForEachColumn(Self& self, F f) {
    f(self.byte), f(self.wide), f(self.half), f(self.number);
  }
};

template <class Columns>
class Soa : public testing::Test {};
using Records =
    testing::Types<PathColumns, RayColumns, HitColumns, EscapeColumns, SurfaceColumns, LightColumns,
                   UniformColumns, QueueColumns, BsdfValueColumns, MixedColumns>;
TYPED_TEST_SUITE(Soa, Records);

constexpr std::uint32_t kRows[] = {0, 1, 2, 15, 16, 17, 100, 2048};

TYPED_TEST(Soa, ColumnsAreAlignedAndCleared) {
  for (const std::uint32_t rows : kRows) {
    const soa::Table<TypeParam> table(rows);
    EXPECT_EQ(table.rows(), rows);
    TypeParam columns = table;
    TypeParam::ForEachColumn(columns, [&](auto*& column) {
      EXPECT_EQ(reinterpret_cast<std::uintptr_t>(column) % kColumnAlignment, 0u);
      EXPECT_TRUE(std::all_of(column, column + PaddedRows(rows), [](auto v) { return v == 0; }));
    });
  }
}

// Every value of every column, padding included, can be written without affecting another.
TYPED_TEST(Soa, ColumnsDoNotOverlap) {
  for (const std::uint32_t rows : kRows) {
    const soa::Table<TypeParam> table(rows);
    TypeParam columns = table;
    std::vector<std::pair<std::uintptr_t, std::uintptr_t>> ranges;
    TypeParam::ForEachColumn(columns, [&](auto*& column) {
      const auto begin = reinterpret_cast<std::uintptr_t>(column);
      ranges.emplace_back(begin, begin + PaddedRows(rows) * sizeof *column);
      // Under the address sanitizer this also shows that the block is long enough.
      std::fill_n(column, PaddedRows(rows), std::remove_reference_t<decltype(*column)>(7));
    });
    EXPECT_EQ(ranges.size(), soa::CountColumns<TypeParam>());
    std::sort(ranges.begin(), ranges.end());
    for (std::size_t i = 1; i < ranges.size(); ++i) {
      EXPECT_LE(ranges[i - 1].second, ranges[i].first);
    }
  }
}

TEST(SoaCounts, CountColumnsAndBytes) {
  static_assert(soa::CountColumns<MixedColumns>() == 4);
  static_assert(soa::BytesPerRow<MixedColumns>() == 1 + 8 + 2 + 4);
  static_assert(soa::CountColumns<RayColumns>() * sizeof(void*) == sizeof(RayColumns));
  static_assert(soa::BytesPerRow<RayColumns>() == 4 * soa::CountColumns<RayColumns>());
  static_assert(soa::CountColumns<UniformColumns>() == 2);
}

TEST(SoaCounts, PaddingHoldsAVectorAfterAnyRow) {
  for (std::uint32_t rows = 0; rows < 200; ++rows) {
    EXPECT_GE(PaddedRows(rows), rows + kPadRows);
    EXPECT_EQ(PaddedRows(rows) % kPadRows, 0u);
    EXPECT_LT(PaddedRows(rows), rows + 2 * kPadRows);
  }
}

TEST(SoaSlices, BeginAtTheirRow) {
  const soa::Table<RayColumns> table(40);
  for (std::uint32_t i = 0; i < 40; ++i) table->pdf[i] = float(i), table->path[i] = 2 * i;
  const RayColumns slice = Slice(table.columns(), 13);
  EXPECT_EQ(slice.pdf[0], 13);
  EXPECT_EQ(slice.path[5], 36u);
}

TEST(SoaTables, MoveWithoutMovingTheirMemory) {
  soa::Table<RayColumns> a(20);
  const float* const column = a->t_far;
  const soa::Table<RayColumns> b = std::move(a);
  EXPECT_EQ(b->t_far, column);
  EXPECT_EQ(b.rows(), 20u);
}

}  // namespace
}  // namespace skywave
