#include "job/batch/save.h"

#include <nlohmann/json.hpp>

#include "base/error.h"
#include "base/files.h"
#include "base/json.h"
#include "job/batch/page.h"
#include "job/batch/report.h"
#include "job/picture.h"

namespace skywave {

BatchFiles::BatchFiles(const BatchPlan& plan, const BatchShare& share)
    : plan_(plan), share_(share) {
  std::string bytes;
  try {
    bytes = ReadFile(ReportName(plan, share, ".json"));
  } catch (const InputError&) {
    return;  // this is the first run
  }
  earlier_ = ResultsInJson(bytes);
}

BatchSummary BatchFiles::WithEarlier(BatchSummary summary) const {
  for (std::size_t i = 0; i < plan_.pictures.size(); ++i) {
    PictureResult& result = summary.results[i];
    const auto found = earlier_.find(RelativeName(plan_.folder, plan_.pictures[i].output));
    if (found == earlier_.end() || found->second.hash.empty()) continue;
    const PictureStatus status = result.status;
    const bool same = status == PictureStatus::kSkipped && found->second.hash == result.hash;
    if (!same && status != PictureStatus::kPending) continue;
    result = found->second;
    result.status = status;
  }
  return summary;
}

void BatchFiles::Save(const BatchSummary& run) {
  const BatchSummary summary = WithEarlier(run);
  thumbnails_.resize(plan_.pictures.size());
  for (std::size_t i = 0; i < plan_.pictures.size(); ++i) {
    const PictureStatus status = summary.results[i].status;
    const bool there = status == PictureStatus::kRendered || status == PictureStatus::kSkipped;
    if (there && i < kMostThumbnails && thumbnails_[i].width == 0) {
      thumbnails_[i] = MakeThumbnail(PngBeside(plan_.pictures[i].output));
    }
  }
  WriteFileAtomically(ReportName(plan_, share_, ".json"),
                      JsonText(SummaryJson(plan_, share_, summary), 1) + "\n");
  // A page of many pictures is long, so it is never held in memory as a whole.
  WriteFileInPieces(ReportName(plan_, share_, ".html"), [&](const PieceWriter& out) {
    WriteBatchPage(plan_, summary, thumbnails_, out);
  });
}

}  // namespace skywave
