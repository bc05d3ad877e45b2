// Keeps the files beside the pictures up to date: what became of them in JSON, and the page.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "job/batch/plan.h"
#include "job/batch/run.h"
#include "job/batch/thumbnail.h"

namespace skywave {

class BatchFiles {
 public:
  // Reads what an earlier run has left. The plan must outlive the object.
  BatchFiles(const BatchPlan& plan, const BatchShare& share);
  // Returns the summary with what an earlier run has measured: in skipped pictures, if that run has
  // made the same bytes, and in those that are not begun, so that it is not lost.
  BatchSummary WithEarlier(BatchSummary summary) const;
  // Replaces both files (WriteFileAtomically). Pictures that are there are looked at once.
  void Save(const BatchSummary& run);

 private:
  const BatchPlan& plan_;
  BatchShare share_;
  std::map<std::string, PictureResult> earlier_;  // by output
  std::vector<Thumbnail> thumbnails_;
};

}  // namespace skywave
