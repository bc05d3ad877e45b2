// What [random] of a job file says: options whose values are drawn anew for each picture.
//
// A value is a function of the seed, of the number of its draw and of the name of its option. So it
// does not matter who renders a picture, and when: shares of a batch, and a batch that goes on
// after a kill, have the pictures of the whole.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "job/batch/job_file.h"

namespace skywave {

// The random numbers of one value.
class DrawNumbers {
 public:
  DrawNumbers(std::uint64_t seed, std::uint64_t draw, const std::string& name);
  double Next();  // in [0, 1)

 private:
  std::string name_;
  std::uint64_t count_ = 0;
};

// Returns the text of a value, as an option takes it.
using Distribution = std::function<std::string(DrawNumbers& numbers)>;

// Returns the values for which a text of an option stands: itself, or the files of a pattern.
using ValuesOfText = std::function<std::vector<std::string>(const JobValue& text)>;

// Reads what an option of [random.draw] is drawn from (docs/batch.md). Throws InputError with the
// line.
Distribution ReadDistribution(const std::string& path, const JobEntry& entry,
                              const ValuesOfText& values);

}  // namespace skywave
