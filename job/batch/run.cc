#include "job/batch/run.h"

#include <algorithm>
#include <chrono>
#include <deque>
#include <new>
#include <utility>

#include "base/clock.h"
#include "base/error.h"
#include "base/large_memory.h"
#include "base/spare_threads.h"
#include "wavefront/worker_pool.h"

namespace skywave {
namespace {

// Pictures that are being written while others are rendered. Disks take their time to sync: with
// only one, a render would sometimes wait for the file of the picture before.
constexpr std::size_t kMostWrites = 3;

bool IsReady(const std::future<PictureResult>& result) {
  return result.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
}

PictureResult Failure(const std::string& error, int exit_code) {
  return {.status = PictureStatus::kFailed, .error = error, .exit_code = exit_code};
}

// Returns what `work` returns, or the failure that it throws.
template <class Work>
PictureResult ResultOf(const Work& work) {
  try {
    return work();
  } catch (const InputError& error) {
    return Failure(error.what(), error.exit_code());
  } catch (const std::bad_alloc&) {
    return Failure("out of memory", kExitIo);
  } catch (const std::exception& error) {
    return Failure(error.what(), 1);
  }
}

std::future<PictureResult> RenderOrFail(const RenderPicture& render, const BatchPicture& picture,
                                        const BatchPicture* next) {
  std::future<PictureResult> written;
  PictureResult failure = ResultOf([&] {
    written = render(picture, next);
    return PictureResult();
  });
  return written.valid() ? std::move(written) : Known(std::move(failure));
}

// Saves the summary where that takes little of the time, while pictures are rendered.
class Saver {
 public:
  explicit Saver(const BatchReporter& reporter) : reporter_(reporter) {}
  ~Saver() {
    if (saving_.valid()) saving_.wait();
  }
  void Save(BatchSummary& summary) {
    if (!reporter_.save) return;
    if (saving_.valid()) saving_.get();
    summary.seconds = SecondsSince(start_);
    SaveNow(summary);
  }
  void SaveSometimes(BatchSummary& summary) {
    if (!reporter_.save) return;
    if (saving_.valid()) {
      if (saving_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return;
      saving_.get();
    }
    constexpr double kShare = 0.02;
    if (SecondsSince(last_) * kShare < took_) return;
    summary.seconds = SecondsSince(start_);
    saving_ = OnSpareThread([this, summary] { SaveNow(summary); });
  }

 private:
  void SaveNow(const BatchSummary& summary) {
    const Clock::time_point begin = Clock::now();
    reporter_.save(summary);
    last_ = Clock::now();
    took_ = SecondsSince(begin);
  }

  const BatchReporter& reporter_;
  Clock::time_point start_ = Clock::now();
  Clock::time_point last_ = start_;  // of the last save, which took so long; written while it runs
  double took_ = 0;
  std::future<void> saving_;
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
  for (const PictureResult& result : results) {
    if (result.status != PictureStatus::kPending) sum += result.render_seconds;
  }
  return sum;
}

std::uint64_t BatchSummary::samples() const {
  std::uint64_t sum = 0;
  for (const PictureResult& result : results) {
    if (result.status != PictureStatus::kPending) sum += result.samples;
  }
  return sum;
}

std::future<PictureResult> Known(PictureResult result) {
  std::promise<PictureResult> promise;
  promise.set_value(std::move(result));
  return promise.get_future();
}

BatchSummary RunBatch(const BatchPlan& plan, const RenderPicture& render,
                      const BatchReporter& reporter) {
  // Results of pictures stay between the buffers of others, whose pages glibc keeps.
  constexpr double kSecondsBetweenTrims = 1;
  Clock::time_point trimmed = Clock::now();
  BatchSummary summary;
  summary.results.resize(plan.pictures.size());
  Saver saver(reporter);
  saver.Save(summary);
  std::deque<std::future<PictureResult>> writing;  // of the pictures from number `told` on
  std::size_t told = 0;
  const auto tell_oldest = [&] {
    PictureResult& result = summary.results[told];
    result = ResultOf([&] { return writing.front().get(); });
    writing.pop_front();
    if (summary.exit_code == 0) summary.exit_code = result.exit_code;
    if (reporter.end) reporter.end(plan.pictures[told], result);
    ++told;
  };
  const auto tell_all_but = [&](std::size_t most) {
    while (!writing.empty() && (writing.size() > most || IsReady(writing.front()))) tell_oldest();
  };
  for (std::size_t number = 0; number < plan.pictures.size(); ++number) {
    if (number > 0 && !GoesOn(plan, summary)) break;
    const BatchPicture& picture = plan.pictures[number];
    if (reporter.begin) reporter.begin(picture, number, plan.pictures.size());
    const bool is_last = number + 1 == plan.pictures.size();
    try {
      writing.push_back(RenderOrFail(render, picture, is_last ? nullptr : &picture + 1));
    } catch (const RenderCanceled&) {
      tell_all_but(0);
      summary.stopped = "it was canceled";
      saver.Save(summary);
      throw;
    }
    tell_all_but(kMostWrites);
    saver.SaveSometimes(summary);
    if (SecondsSince(trimmed) > kSecondsBetweenTrims) {
      ReturnFreeMemory();
      trimmed = Clock::now();
    }
  }
  tell_all_but(0);
  saver.Save(summary);
  return summary;
}

}  // namespace skywave
