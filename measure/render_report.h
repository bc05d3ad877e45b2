// Reports the statistics of a render for people (a table) and for programs (JSON).
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "job/job.h"
#include "wavefront/render.h"

namespace skywave {

struct RenderReport {
  const RenderJob* job;
  FrameResult frame;
  double write_seconds = 0;
};

std::string Table(const RenderReport& report);
nlohmann::ordered_json Json(const RenderReport& report);

}  // namespace skywave
