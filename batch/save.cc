#include "batch/save.h"

#include "base/files.h"
#include "batch/page.h"
#include "batch/report.h"
#include "job/picture.h"

namespace skywave {

void BatchFiles::Save(const BatchSummary& summary) {
  thumbnails_.resize(plan_.pictures.size());
  for (std::size_t i = 0; i < plan_.pictures.size(); ++i) {
    const PictureStatus status = summary.results[i].status;
    const bool there = status == PictureStatus::kRendered || status == PictureStatus::kSkipped;
    if (there && i < kMostThumbnails && thumbnails_[i].width == 0) {
      thumbnails_[i] = MakeThumbnail(PngBeside(plan_.pictures[i].output));
    }
  }
  WriteFileAtomically(ReportName(plan_, share_, ".json"),
                      SummaryJson(plan_, share_, summary).dump(1) + "\n");
  WriteFileAtomically(ReportName(plan_, share_, ".html"), BatchPage(plan_, summary, thumbnails_));
}

}  // namespace skywave
