// Tests the order of a batch with pictures that take no time: failures, changes and what is
// reported.
#include "job/batch/run.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <thread>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "base/error.h"
#include "base/files.h"
#include "image/image.h"
#include "job/batch/report.h"
#include "job/batch/save.h"
#include "job/batch/thumbnail.h"
#include "tests/support/temporary_folder.h"
#include "wavefront/worker_pool.h"

namespace skywave {
namespace {

class Run : public testing::Test {
 protected:
  Run()
      : plan_(ReadBatchPlan(folder_.Write("job.toml",
                                          "[base]\nscene = \"spheres\"\n[axes]\nseed = \"1-5\"\n"
                                          "[output]\npath = \"o/{seed}.exr\"\n"))) {}

  TemporaryFolder folder_;
  BatchPlan plan_;
  std::vector<std::size_t> rendered_;
};

TEST_F(Run, GoesOnAfterAFailureAndEndsWithTheFirstOnesCode) {
  const RenderPicture render = [&](const BatchPicture& picture, const BatchPicture* next) {
    rendered_.push_back(picture.index);
    EXPECT_EQ(next, picture.index == 4 ? nullptr : &plan_.pictures[picture.index + 1]);
    if (picture.index == 1) throw InputError(InputPosition::File("a.exr"), "is torn", kExitIo);
    if (picture.index == 3) throw std::runtime_error("surprise");
    return Known({.status = PictureStatus::kRendered, .render_seconds = 2, .samples = 10});
  };
  std::vector<std::size_t> pending;
  BatchReporter reporter;
  reporter.save = [&](const BatchSummary& summary) {
    pending.push_back(summary.Count(PictureStatus::kPending));
  };
  const BatchSummary summary = RunBatch(plan_, render, reporter);
  EXPECT_EQ(rendered_, (std::vector<std::size_t>{0, 1, 2, 3, 4}));
  EXPECT_EQ(summary.exit_code, kExitIo);
  EXPECT_EQ(summary.Count(PictureStatus::kRendered), 3u);
  EXPECT_EQ(summary.results[1].error, "a.exr: is torn");
  EXPECT_EQ(summary.results[3].error, "surprise");
  EXPECT_EQ(summary.samples(), 30u);
  EXPECT_EQ(pending.front(), 5u);
  EXPECT_EQ(pending.back(), 0u);

  const nlohmann::ordered_json json = SummaryJson(plan_, {}, summary);
  EXPECT_EQ(json["failed"], 2);
  EXPECT_EQ(json["pictures"][1]["status"], "failed");
  EXPECT_EQ(json["pictures"][4]["output"], "5.exr");
  EXPECT_EQ(json["pictures"][4]["axes"]["seed"], "5");
}

// A picture of this run is written when the second one after it has been rendered.
TEST_F(Run, RendersWhilePicturesAreWrittenAndReportsInOrder) {
  std::atomic<std::size_t> begun = 0;
  const RenderPicture render = [&](const BatchPicture& picture, const BatchPicture*) {
    ++begun;
    return std::async(std::launch::async, [&begun, &picture] {
      const std::size_t wanted = std::min<std::size_t>(picture.index + 3, 5);
      for (int i = 0; i < 500 && begun < wanted; ++i) {
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
      }
      if (begun < wanted) throw std::runtime_error("nobody went on");
      return PictureResult{.status = PictureStatus::kRendered, .samples = picture.index};
    });
  };
  std::vector<std::size_t> told;
  BatchReporter reporter;
  reporter.end = [&](const BatchPicture& picture, const PictureResult& result) {
    EXPECT_EQ(result.samples, picture.index) << result.error;
    told.push_back(picture.index);
  };
  EXPECT_EQ(RunBatch(plan_, render, reporter).exit_code, 0);
  EXPECT_EQ(told, (std::vector<std::size_t>{0, 1, 2, 3, 4}));
}

TEST_F(Run, EndsBeforeTheNextPictureWhenTheJobFileChanges) {
  const RenderPicture render = [&](const BatchPicture& picture, const BatchPicture*) {
    rendered_.push_back(picture.index);
    if (picture.index == 2) folder_.Write("job.toml", plan_.bytes + "\n");
    return Known({.status = PictureStatus::kRendered});
  };
  const BatchSummary summary = RunBatch(plan_, render, {});
  EXPECT_EQ(rendered_, (std::vector<std::size_t>{0, 1, 2}));
  EXPECT_EQ(summary.Count(PictureStatus::kPending), 2u);
  EXPECT_EQ(summary.exit_code, kExitBadInput);
  EXPECT_NE(summary.stopped.find("job.toml: has changed"), std::string::npos) << summary.stopped;
}

TEST_F(Run, SavesTheSummarySoFarWhenCanceled) {
  const RenderPicture render = [&](const BatchPicture& picture, const BatchPicture*) {
    if (picture.index == 1) throw RenderCanceled();
    return Known({.status = PictureStatus::kRendered});
  };
  std::size_t saved = 0;
  BatchReporter reporter;
  reporter.save = [&](const BatchSummary& summary) {
    saved = summary.Count(PictureStatus::kRendered);
  };
  EXPECT_THROW(RunBatch(plan_, render, reporter), RenderCanceled);
  EXPECT_EQ(saved, 1u);
}

TEST_F(Run, KeepsMeasurementsOfEarlierRunsOfTheSameBytes) {
  std::filesystem::create_directory(folder_.Path("o"));
  BatchSummary first;
  for (const std::string hash : {"a", "b", "c", "d", ""}) {
    first.results.push_back({.status = PictureStatus::kRendered,
                             .load_seconds = 1,
                             .render_seconds = 2,
                             .write_seconds = 3,
                             .samples = 10,
                             .noise = 0.5,
                             .hash = hash});
  }
  BatchFiles(plan_, {}).Save(first);

  BatchSummary second;
  second.results.resize(5);
  second.results[0] = {.status = PictureStatus::kSkipped, .hash = "a"};
  second.results[1] = {.status = PictureStatus::kSkipped, .hash = "other"};
  second.results[2] = {.status = PictureStatus::kRendered, .render_seconds = 7, .hash = "c"};
  const BatchFiles files(plan_, {});
  const BatchSummary told = files.WithEarlier(second);
  EXPECT_EQ(told.results[0].status, PictureStatus::kSkipped);
  EXPECT_EQ(told.results[0].load_seconds, 1);
  EXPECT_EQ(told.results[0].render_seconds, 2);
  EXPECT_EQ(told.results[0].write_seconds, 3);
  EXPECT_EQ(told.results[0].noise, 0.5);
  EXPECT_EQ(told.results[1].render_seconds, 0);
  EXPECT_EQ(told.results[2].render_seconds, 7);
  EXPECT_EQ(told.results[3].status, PictureStatus::kPending);
  EXPECT_EQ(told.results[3].hash, "d");
  EXPECT_EQ(told.samples(), 10u);

  folder_.Write("o/job.batch.json", "{\"schema\": \"skywave-batch-1\", \"pictures\": [7]}");
  EXPECT_EQ(BatchFiles(plan_, {}).WithEarlier(second).results[0].render_seconds, 0);
}

// The axis that goes fastest is that of the columns, and rates are those of the rendering alone.
TEST_F(Run, ThePageIsAGridOfWhatWasMeasured) {
  const BatchPlan plan =
      ReadBatchPlan(folder_.Write("grid.toml",
                                  "[base]\nscene = \"spheres\"\n[axes]\nspp = [16, 64]\n"
                                  "seed = \"7-9\"\n[output]\npath = \"o/{spp}_{seed}.exr\"\n"));
  std::filesystem::create_directory(folder_.Path("o"));
  BatchSummary summary;
  summary.results.resize(plan.pictures.size());
  summary.results[4] = {.status = PictureStatus::kRendered,
                        .load_seconds = 1250,
                        .render_seconds = 2500,
                        .write_seconds = 30,
                        .samples = 10'000'000'000};
  summary.seconds = 5000;
  BatchFiles(plan, {}).Save(summary);
  const std::string page = ReadFile(folder_.Path("o/grid.batch.html"));
  const auto has = [&](const std::string& part) { return page.find(part) != std::string::npos; };
  EXPECT_TRUE(
      has("<th>spp / seed</th><th scope=\"col\">7</th><th scope=\"col\">8</th>"
          "<th scope=\"col\">9</th></tr>"));
  // The picture is the second one of the second row.
  const std::size_t row = page.find("<tr><th scope=\"row\">64</th>");
  ASSERT_NE(row, std::string::npos);
  const std::size_t cell = page.find("<td>", page.find("<td>", row) + 1);
  EXPECT_EQ(page.find("figure class=\"rendered\""), page.find("figure class", cell));
  EXPECT_TRUE(has("<dt>wall clock</dt><dd>1:23 h</dd>"));
  EXPECT_TRUE(has("<dt>rendering</dt><dd>41:40 min</dd>"));
  EXPECT_TRUE(has("<dt>Msamples/s</dt><dd>4</dd>"));
  EXPECT_TRUE(has("<figcaption>1:03 h</figcaption>")) << "3780 s in all";
  EXPECT_TRUE(
      has("<td class=\"number\">1250.000</td><td class=\"number\">2500.000</td>"
          "<td class=\"number\">30.000</td><td class=\"number\">4</td>"));
}

// A picture that is smaller than a thumbnail is shown as it is.
TEST(Thumbnails, AreNoLargerThanTheirPictures) {
  const TemporaryFolder folder;
  WritePng(folder.Path("a.png"), 8, 6, std::vector<std::uint8_t>(8 * 6 * 3, 128));
  const Thumbnail thumbnail = MakeThumbnail(folder.Path("a.png"));
  EXPECT_EQ(thumbnail.width, 8);
  EXPECT_EQ(thumbnail.height, 6);
}

TEST(Thumbnails, AreMeansInLinearLight) {
  const TemporaryFolder folder;
  constexpr int kWidth = 320, kHeight = 240;
  std::vector<std::uint8_t> rgb;
  for (int i = 0; i < kWidth * kHeight; ++i) {
    const bool white = (i % kWidth + i / kWidth) % 2 == 0;
    for (int c = 0; c < 3; ++c) rgb.push_back(white ? 255 : 0);
  }
  WritePng(folder.Path("a.png"), kWidth, kHeight, rgb);
  const Thumbnail thumbnail = MakeThumbnail(folder.Path("a.png"));
  EXPECT_EQ(thumbnail.width, 160);
  EXPECT_EQ(thumbnail.height, 120);
  const Image image = DecodeTexture("a.jpg", thumbnail.jpeg, Encoding::kSrgb);
  ASSERT_EQ(image.width, 160);
  ASSERT_EQ(image.height, 120);
  for (const float value : image.rgb) ASSERT_NEAR(value, 0.5f, 0.02f);
  EXPECT_EQ(MakeThumbnail(folder.Path("missing.png")).width, 0);
}

}  // namespace
}  // namespace skywave
