// A table relaxes Penrose samples (T 6.3.2): one step stands for Lloyd's iterations.
#pragma once

#include <array>

#include "lights/light_sets/penrose_tiling.h"

namespace skywave {

inline constexpr int kPenroseRows = 8;  // importances within one level, equally spaced in logarithm
inline constexpr int kPenroseClasses = 21;  // see StructuralClass

// Displacements are in units of the tile at the level of the importance, in its basis.
using PenroseCorrections = std::array<std::array<Complex, kPenroseClasses>, kPenroseRows>;
const PenroseCorrections& DefaultPenroseCorrections();

// A sample is born with the level and the axis of its tile at that time.
struct BornSample {
  Complex position, axis;
  std::uint64_t value;
  int level;
};

// Returns the displacement of a sample where the importance is `importance` (samples per rhombus):
// the table's vectors of the two nearest rows, interpolated; across the ends of a level also
// between levels.
Complex PenroseCorrection(const PenroseCorrections& table, const BornSample& sample,
                          double importance);

}  // namespace skywave
