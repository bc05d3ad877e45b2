// Runs copies of a measurement as processes of their own, all at once: what a machine gets done
// when it renders many pictures, one thread each (the "rate" of SPEC CPU).
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace skywave {

// Returns the processors that this process may run on, one of each core before the second ones of
// any: the order in which copies are pinned.
std::vector<int> ProcessorsByCore();

struct CopyCounts;

// How a copy waits for the others. If one fails, all end.
class CopyBarrier {
 public:
  CopyBarrier(CopyCounts& counts, int copies, int copy)
      : counts_(counts), copies_(copies), copy_(copy) {}
  // Returns which of the copies this is, from 0.
  int copy() const { return copy_; }
  // Waits until all copies have called this.
  void Meet();
  // Reports that this copy has measured enough since it last met the others, and returns whether
  // all copies have; if not, the copy goes on working and asks again.
  bool Finish();

 private:
  CopyCounts& counts_;
  int copies_, copy_, meetings_ = 0, parts_ = 0;
  bool waits_ = false;  // has finished the current part before others
};

// What a copy does, and returns as text. It meets the others before each part that it measures, and
// after it goes on working until Finish returns true: the slowest copy never has the machine for
// itself.
using CopyWork = std::function<std::string(CopyBarrier& barrier)>;

// Returns the order in which copy `copy` goes through `parts` parts: from the first to the last,
// or, if copies rotate, each from another one on, so that different ones run at once.
std::vector<std::size_t> PartsOfCopy(int copy, std::size_t parts, bool rotate);

struct CopyResult {
  std::optional<int> processor;  // pinned to it; none where the system did not allow that
  std::string text;              // what its work returned
};

// Starts `copies` processes by fork, so the caller must have no other threads. Copy i is pinned to
// the i-th of `processors`, from the front again where there are more copies. Throws InputError
// with the reason, and the exit code where it is that of an InputError, if a copy throws or dies;
// the others are ended then.
std::vector<CopyResult> RunCopies(int copies, std::span<const int> processors,
                                  const CopyWork& work);

}  // namespace skywave
