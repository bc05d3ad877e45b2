// Reports the statistics of a render for people (a table) and for programs (JSON).
#pragma once

#include <optional>
#include <string>

#include "job/job.h"
#include "wavefront/render.h"

namespace skywave {

struct RenderReport {
  const RenderJob* job;
  FrameResult frame;
  double write_seconds = 0;
  std::optional<double> noise = {};  // of the picture (Film::Noise), where it is known
  bool adaptive = false;             // blocks may have ended apart
};

std::string Table(const RenderReport& report);
std::string JsonText(const RenderReport& report);

}  // namespace skywave
