// Relaxation by table of Penrose samples (T 6.3.2): one step that stands for Lloyd's iterations.
#pragma once

#include <array>

#include "lights/light_sets/penrose_tiling.h"

namespace skywave {

inline constexpr int kPenroseRows = 8;      // importances within one level, evenly in its logarithm
inline constexpr int kPenroseClasses = 21;  // see StructuralClass

// Displacements in units of the tile at the level of the importance, in its basis.
using PenroseCorrections = std::array<std::array<Complex, kPenroseClasses>, kPenroseRows>;
const PenroseCorrections& DefaultPenroseCorrections();

// A sample when it is born: level and axis of the tile then.
struct BornSample {
  Complex position, axis;
  std::uint64_t value;
  int level;
};

// How far a sample is displaced where the importance is `importance` (samples per rhombus): the
// table's vectors of the two nearest rows, interpolated; across the ends of a level also over
// levels.
Complex PenroseCorrection(const PenroseCorrections& table, const BornSample& sample,
                          double importance);

}  // namespace skywave
