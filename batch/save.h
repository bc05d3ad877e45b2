// Keeps the files beside the pictures up to date: what became of them in JSON, and the page.
#pragma once

#include <vector>

#include "batch/plan.h"
#include "batch/run.h"
#include "batch/thumbnail.h"

namespace skywave {

class BatchFiles {
 public:
  // The plan must outlive the object.
  BatchFiles(const BatchPlan& plan, const BatchShare& share) : plan_(plan), share_(share) {}
  // Replaces both files (WriteFileAtomically). Pictures that are there are looked at once.
  void Save(const BatchSummary& summary);

 private:
  const BatchPlan& plan_;
  BatchShare share_;
  std::vector<Thumbnail> thumbnails_;
};

}  // namespace skywave
