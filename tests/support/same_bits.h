// Tests that pictures do not depend on the division of their work.
#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <utility>
#include <vector>

#include "job/job.h"
#include "wavefront/render.h"

namespace skywave {

// Expects the film of `job` to be bit-identical for other numbers of threads and other waves.
inline void ExpectSameBits(const RenderJob& job) {
  const auto sums = [&](int threads, std::uint32_t wave) {
    FrameView frame = job.frame();
    frame.options.threads = threads, frame.options.wave = wave;
    Film film = job.MakeFilm();
    RenderFrame(frame, film);
    return std::vector<std::uint64_t>(film.sums().begin(), film.sums().end());
  };
  const std::vector<std::uint64_t> expected = sums(1, 2048);
  for (const auto& [threads, wave] : {std::pair{1, 17u}, {2, 256u}, {8, 4096u}}) {
    EXPECT_EQ(sums(threads, wave), expected) << threads << " threads, wave " << wave;
  }
}

}  // namespace skywave
