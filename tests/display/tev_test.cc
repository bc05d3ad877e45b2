// Tests the client of tev with viewers that read, do not read, leave or are not there.
#include "api/display/tev.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "base/clock.h"
#include "tests/support/viewer.h"

namespace skywave {
namespace {

TEST(ViewerAddress, HasTevsPortByDefault) {
  const auto expect = [](const std::string& text, const std::string& host,
                         const std::string& port) {
    const auto address = ParseViewerAddress(text);
    ASSERT_TRUE(address) << text;
    EXPECT_EQ(address->host, host);
    EXPECT_EQ(address->port, port);
  };
  expect("localhost", "localhost", "14158");
  expect("10.0.0.7:80", "10.0.0.7", "80");
  expect("[::1]", "::1", "14158");
  expect("[::1]:9", "::1", "9");
  for (const std::string bad : {"", ":80", "a:", "a:x", "a:0", "a:65536", "a:123456", "[::1", "[]",
                                "[::1]9", "a:1:2", "a:-1"}) {
    EXPECT_FALSE(ParseViewerAddress(bad)) << bad;
  }
}

const std::vector<std::string> kChannels = {"R", "G", "B", "depth.Z"};

// Sends a picture of several blocks, tile by tile in an order of its own, and some tiles again.
struct Sender {
  Sender(int w, int h) : width(w), height(h), planes(kChannels.size() * std::size_t(w * h)) {
    for (float& value : planes) value = std::normal_distribution<float>()(random);
  }
  std::vector<float> Values(const DisplayWindow& window) const {
    std::vector<float> values;
    for (std::size_t c = 0; c < kChannels.size(); ++c) {
      for (int y = window.y; y < window.y + window.height; ++y) {
        for (int x = window.x; x < window.x + window.width; ++x) values.push_back(At(c, x, y));
      }
    }
    return values;
  }
  float At(std::size_t c, int x, int y) const {
    return planes[(c * std::size_t(height) + std::size_t(y)) * std::size_t(width) + std::size_t(x)];
  }
  void Send(TevDisplay& display) {
    constexpr int kSide = 24;
    std::vector<DisplayWindow> tiles;
    for (int y = 0; y < height; y += kSide) {
      for (int x = 0; x < width; x += kSide) {
        tiles.push_back({x, y, std::min(kSide, width - x), std::min(kSide, height - y)});
      }
    }
    std::shuffle(tiles.begin(), tiles.end(), random);
    for (const DisplayWindow& tile : tiles) {
      // Values of before, which the true ones have to replace.
      display.Update(tile, std::vector<float>(Values(tile).size(), -1.0f));
      display.Update(tile, Values(tile));
    }
  }
  void ExpectIn(const ViewedPicture& picture) const {
    ASSERT_EQ(picture.width, width);
    ASSERT_EQ(picture.height, height);
    ASSERT_EQ(picture.channels.size(), kChannels.size());
    const auto pixels = std::ptrdiff_t(width) * height;
    for (std::size_t c = 0; c < kChannels.size(); ++c) {
      const auto first = planes.begin() + std::ptrdiff_t(c) * pixels;
      EXPECT_EQ(picture.channels.at(kChannels[c]), std::vector<float>(first, first + pixels));
    }
  }
  int width, height;
  std::mt19937 random{5};
  std::vector<float> planes;
};

TEST(Tev, AViewerHasEveryValueAtTheEnd) {
  Viewer viewer;
  Sender sender(150, 70);
  TevDisplay display(*ParseViewerAddress(viewer.address()), "a picture", 150, 70, kChannels);
  sender.Send(display);
  EXPECT_EQ(display.Finish(), "");
  EXPECT_FALSE(display.watched());
  const auto pictures = viewer.Close();
  ASSERT_EQ(pictures.size(), 1u);
  EXPECT_EQ(pictures.begin()->first, "a picture");
  sender.ExpectIn(pictures.begin()->second);
}

TEST(Tev, UpdatesOfABlockBecomeOne) {
  Viewer viewer;
  Sender sender(64, 64);
  TevDisplay display(*ParseViewerAddress(viewer.address()), "p", 64, 64, kChannels);
  const Clock::time_point start = Clock::now();
  while (SecondsSince(start) < 0.7) sender.Send(display);
  EXPECT_EQ(display.Finish(), "");
  const auto pictures = viewer.Close();
  sender.ExpectIn(pictures.at("p"));
  EXPECT_GE(pictures.at("p").updates, 2);
  EXPECT_LE(pictures.at("p").updates, 8);
}

// The kernel's buffers take megabytes before a viewer is seen not to read.
TEST(Tev, AViewerThatDoesNotReadIsAWarning) {
  Viewer viewer(Viewer::Habit::kIgnores);
  Sender sender(1024, 1024);
  const ViewerPatience patience = {.no_read = 0.3};
  TevDisplay display(*ParseViewerAddress(viewer.address()), "p", 1024, 1024, kChannels, patience);
  const Clock::time_point start = Clock::now();
  sender.Send(display);
  EXPECT_EQ(display.Finish(),
            "the viewer at 127.0.0.1:" + std::to_string(viewer.port()) + " does not read");
  EXPECT_LT(SecondsSince(start), 5);
}

TEST(Tev, AViewerThatLeavesIsAWarning) {
  Viewer viewer(Viewer::Habit::kLeaves);
  Sender sender(512, 512);
  TevDisplay display(*ParseViewerAddress(viewer.address()), "p", 512, 512, kChannels);
  while (display.watched()) sender.Send(display);
  EXPECT_NE(display.Finish().find(" has left ("), std::string::npos);
}

TEST(Tev, NoViewerIsAWarning) {
  std::string address;
  { address = Viewer(Viewer::Habit::kIgnores).address(); }
  Sender sender(64, 64);
  TevDisplay display(*ParseViewerAddress(address), "p", 64, 64, kChannels);
  sender.Send(display);
  EXPECT_NE(display.Finish().find(address + " cannot be reached ("), std::string::npos);
}

TEST(Tev, ADisplayThatIsNotFinishedLeaves) {
  Viewer viewer;
  {
    Sender sender(64, 64);
    TevDisplay display(*ParseViewerAddress(viewer.address()), "p", 64, 64, kChannels);
    sender.Send(display);
  }
  EXPECT_LE(viewer.Close().size(), 1u);
}

}  // namespace
}  // namespace skywave
