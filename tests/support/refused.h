// Checks that jobs which cannot be rendered are refused.
#pragma once

#include <gtest/gtest.h>

#include <string>

#include "base/error.h"
#include "job/job.h"

namespace skywave {

// The message has to contain `word`.
inline void ExpectRefused(const Scene& scene, const JobRequest& request, const std::string& word) {
  try {
    const RenderJob job(scene, request);
    ADD_FAILURE() << "not refused: " << word;
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find(word), std::string::npos) << error.what();
  }
}

}  // namespace skywave
