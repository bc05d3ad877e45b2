// Runs a batch: one picture after the other; one that fails is noted, and the others go on.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <future>
#include <optional>
#include <string>
#include <vector>

#include "base/names.h"
#include "job/batch/plan.h"

namespace skywave {

enum class PictureStatus {
  kPending,  // not begun
  kRendered,
  kSkipped,  // it was there already
  kFailed
};
template <>
inline constexpr auto kEnumNames<PictureStatus> =
    std::to_array<Named<PictureStatus>>({{PictureStatus::kPending, "pending"},
                                         {PictureStatus::kRendered, "rendered"},
                                         {PictureStatus::kSkipped, "skipped"},
                                         {PictureStatus::kFailed, "failed"}});

struct PictureResult {
  PictureStatus status = PictureStatus::kPending;
  double load_seconds = 0;  // scene and map read, BVH and tables built
  double render_seconds = 0;
  double write_seconds = 0;
  std::uint64_t samples = 0;                 // of all pixels
  std::optional<double> noise;               // relative error of the picture
  std::vector<std::string> warnings, notes;  // those of the job, for the user
  std::string hash;                          // of the bytes of the EXR
  std::string error;
  int exit_code = 0;  // exit code that the error would give the program
};

// Renders a picture; the future has the result once it is written, which may be some pictures
// later. `next` comes after it, so that it can be read meanwhile; null: none does. Function and
// future may throw, which makes the picture a failed one, except for RenderCanceled.
using RenderPicture = std::function<std::future<PictureResult>(const BatchPicture& picture,
                                                               const BatchPicture* next)>;

// Returns a result that is there already.
std::future<PictureResult> Known(PictureResult result);

struct BatchSummary {
  std::vector<PictureResult> results;  // one for each picture of the plan
  double seconds = 0;                  // wall clock, of the run so far
  std::string stopped;  // why the batch ended before its last picture; empty: it did not
  int exit_code = 0;    // 0 if every picture is there
  std::size_t Count(PictureStatus status) const;
  double render_seconds() const;  // sum over the pictures that are begun
  std::uint64_t samples() const;  // sum over the pictures that are begun
};

// Callbacks that report how a batch goes; each may be empty.
struct BatchReporter {
  std::function<void(const BatchPicture& picture, std::size_t number, std::size_t count)> begin;
  std::function<void(const BatchPicture& picture, const PictureResult& result)> end;
  // Keeps the summary so far. Called before the first picture, after the last one, and in between
  // as often as at most 2 % of the time allows, then from another thread; one call at a time.
  std::function<void(const BatchSummary& summary)> save;
};

// Renders the pictures of the plan in their order. Ends early, with `stopped` set, when the job
// file changes, and passes RenderCanceled on.
BatchSummary RunBatch(const BatchPlan& plan, const RenderPicture& render,
                      const BatchReporter& reporter);

}  // namespace skywave
