#include "batch/run.h"

#include <algorithm>
#include <new>

#include "base/clock.h"
#include "base/error.h"
#include "wavefront/worker_pool.h"

namespace skywave {
namespace {

PictureResult Failure(const std::string& error, int exit_code) {
  return {.status = PictureStatus::kFailed, .error = error, .exit_code = exit_code};
}

PictureResult RenderOrFail(const RenderPicture& render, const BatchPicture& picture,
                           const BatchPicture* next) {
  try {
    return render(picture, next);
  } catch (const InputError& error) {
    return Failure(error.what(), error.exit_code());
  } catch (const std::bad_alloc&) {
    return Failure("out of memory", kExitIo);
  } catch (const std::exception& error) {
    return Failure(error.what(), 1);
  }
}

// Saves the summary where that takes little of the time.
class Saver {
 public:
  explicit Saver(const BatchReporter& reporter) : reporter_(reporter) {}
  void Save(BatchSummary& summary) {
    if (!reporter_.save) return;
    summary.seconds = SecondsSince(start_);
    const Clock::time_point begin = Clock::now();
    reporter_.save(summary);
    last_ = Clock::now();
    took_ = SecondsSince(begin);
  }
  void SaveSometimes(BatchSummary& summary) {
    constexpr double kShare = 0.02;
    if (SecondsSince(last_) * kShare >= took_) Save(summary);
  }

 private:
  const BatchReporter& reporter_;
  Clock::time_point start_ = Clock::now(), last_ = start_;
  double took_ = 0;
};

// Returns whether the job file is what it was; notes in the summary where it is not.
bool GoesOn(const BatchPlan& plan, BatchSummary& summary) {
  try {
    CheckUnchanged(plan);
    return true;
  } catch (const InputError& error) {
    summary.stopped = error.what();
    summary.exit_code = error.exit_code();
    return false;
  }
}

}  // namespace

std::size_t BatchSummary::Count(PictureStatus status) const {
  return std::size_t(
      std::count_if(results.begin(), results.end(),
                    [status](const PictureResult& result) { return result.status == status; }));
}

double BatchSummary::render_seconds() const {
  double sum = 0;
  for (const PictureResult& result : results) sum += result.render_seconds;
  return sum;
}

std::uint64_t BatchSummary::samples() const {
  std::uint64_t sum = 0;
  for (const PictureResult& result : results) sum += result.samples;
  return sum;
}

BatchSummary RunBatch(const BatchPlan& plan, const RenderPicture& render,
                      const BatchReporter& reporter) {
  BatchSummary summary;
  summary.results.resize(plan.pictures.size());
  Saver saver(reporter);
  saver.Save(summary);
  for (std::size_t i = 0; i < plan.pictures.size(); ++i) {
    if (i > 0 && !GoesOn(plan, summary)) break;
    const BatchPicture& picture = plan.pictures[i];
    if (reporter.begin) reporter.begin(picture, i, plan.pictures.size());
    const BatchPicture* const next = i + 1 < plan.pictures.size() ? &picture + 1 : nullptr;
    PictureResult& result = summary.results[i];
    try {
      result = RenderOrFail(render, picture, next);
    } catch (const RenderCanceled&) {
      summary.stopped = "it was canceled";
      saver.Save(summary);
      throw;
    }
    if (summary.exit_code == 0) summary.exit_code = result.exit_code;
    if (reporter.end) reporter.end(picture, result);
    saver.SaveSometimes(summary);
  }
  saver.Save(summary);
  return summary;
}

}  // namespace skywave
