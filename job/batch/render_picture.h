// Renders the pictures of a batch: what they have in common is made once, and while one picture is
// rendered the next one is read and the last one written.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <functional>
#include <future>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <vector>

#include "job/batch/run.h"
#include "job/job.h"
#include "job/job_cache.h"
#include "job/picture.h"
#include "job/watch.h"

namespace skywave {

// The callbacks of a picture; each may be empty.
struct PictureWatcher {
  std::function<void(std::uint64_t samples)> begin;  // rendering begins, of so many samples
  Teller tell;                                       // see SessionRequest
};

struct PictureSettings {
  std::uint64_t cache_bytes =
      0;  // of what is kept for later pictures; 0: a tenth of the memory, at most 2 GiB
  bool force = false;             // also render pictures that are there already
  double checkpoint_seconds = 0;  // between checkpoints; 0: only when the batch is stopped
};

class PictureRenderer {
 public:
  // The plan must outlive the renderer.
  PictureRenderer(const BatchPlan& plan, const PictureSettings& settings);
  ~PictureRenderer();  // waits for what is being read and written
  PictureRenderer(const PictureRenderer&) = delete;
  PictureRenderer& operator=(const PictureRenderer&) = delete;

  // Renders a picture unless it is there already: files are recognised by what they record. The
  // future has its result once the EXR and the PNG are written and the EXR has been read back.
  // `next` is the picture that is read meanwhile; null: none. A picture whose render is stopped
  // leaves a checkpoint, from which a later batch goes on. Throws InputError, and RenderCanceled.
  std::future<PictureResult> Render(const BatchPicture& picture, const BatchPicture* next,
                                    const PictureWatcher& watcher);

 private:
  // A picture that is ready to be rendered.
  struct Ready {
    PictureRequest request;
    std::unique_ptr<const RenderJob> job;
    PictureIdentity identity;
    std::vector<std::string> inputs;  // files that were read for it and had not been before
    double load_seconds = 0;
  };
  Ready Read(const BatchPicture& picture);

  // Blocks until `bytes` more may be queued for writing; the returned guard releases them.
  std::shared_ptr<void> TakeRoom(std::uint64_t bytes);

  const BatchPlan& plan_;
  const PictureSettings settings_;
  std::mutex room_mutex_;
  std::condition_variable room_made_;
  std::uint64_t writing_bytes_ = 0;  // of films that are being written
  JobCache cache_;
  const BatchPicture* next_ = nullptr;
  std::future<Ready> next_ready_;
  std::set<std::string> inputs_;  // of the pictures so far, which none may overwrite
};

}  // namespace skywave
