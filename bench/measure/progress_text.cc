#include "bench/measure/progress_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "base/json.h"

namespace skywave {
namespace {

constexpr int kBarWidth = 20;
constexpr std::size_t kColumns = 79;
// A share below this says nothing about the time of a picture.
constexpr double kFirstShare = 0.01;
// From this share on, the current picture's own speed alone counts.
constexpr double kTrustedShare = 0.25;

// Returns the seconds that the current picture takes in all; negative: unknown.
double PictureSeconds(const ProgressState& state) {
  const double own = state.share >= kFirstShare ? state.picture_seconds / state.share : -1;
  if (state.timed_pictures == 0) return own;
  const double mean = state.timed_seconds / double(state.timed_pictures);
  if (own < 0) return mean;
  return std::lerp(mean, own, std::min(state.share / kTrustedShare, 1.0));
}

std::string LeftText(double seconds) {
  return seconds < 0 ? "estimating" : DurationText(seconds) + " left";
}

// "frame 3 of 20", or nothing where there is one picture.
std::string PositionText(const ProgressState& state) {
  if (state.pictures <= 1) return "";
  return fmt::format("{} of {}", std::min(state.pictures_done + 1, state.pictures), state.pictures);
}

std::string SpeedText(const ProgressEstimate& estimate) {
  return estimate.samples_per_second < 0
             ? ""
             : fmt::format(", {:.2f} Msamples/s", estimate.samples_per_second * 1e-6);
}

// Returns a number for JSON; null: unknown.
nlohmann::ordered_json Known(double value) {
  return value < 0 ? nlohmann::ordered_json() : nlohmann::ordered_json(value);
}

// Returns `text` as one line without control characters.
std::string OneLine(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](unsigned char c) { return c < 0x20 || c == 0x7F; }, ' ');
  return text;
}

}  // namespace

ProgressEstimate Estimate(const ProgressState& state) {
  const double pictures = double(std::max<std::size_t>(state.pictures, 1));
  const double done = double(std::min(state.pictures_done, state.pictures));
  const bool all = done >= pictures;
  const double share = std::clamp(state.share, 0.0, 1.0);
  ProgressEstimate estimate;
  estimate.share = all ? 1 : (done + share) / pictures;
  if (const double whole = PictureSeconds(state); all) {
    estimate.picture_seconds = estimate.seconds = 0;
  } else if (whole >= 0) {
    // Scale by the remaining share, so that slow pictures do not reach zero early.
    estimate.picture_seconds = whole * (1 - share);
    const double other =
        state.timed_pictures > 0 ? state.timed_seconds / double(state.timed_pictures) : whole;
    estimate.seconds = estimate.picture_seconds + (pictures - done - 1) * other;
  }
  if (state.samples > 0 && state.picture_seconds > 0 && share > 0) {
    estimate.samples_per_second = double(state.samples) * share / state.picture_seconds;
  }
  return estimate;
}

std::string DurationText(double seconds) {
  const auto total = std::uint64_t(std::max(seconds, 0.0) + 0.5);
  if (total < 60) return fmt::format("{} s", total);
  if (total < 3600) return fmt::format("{}:{:02}", total / 60, total % 60);
  return fmt::format("{}:{:02}:{:02}", total / 3600, total / 60 % 60, total % 60);
}

std::string BarText(const ProgressState& state) {
  const ProgressEstimate estimate = Estimate(state);
  const int filled = int(estimate.share * kBarWidth);
  std::string text =
      fmt::format("[{:#<{}}{:.<{}}] {:3.0f} %  {}", "", filled, "", kBarWidth - filled,
                  estimate.share * 100, LeftText(estimate.seconds));
  if (state.pictures > 1) {
    text += fmt::format("  {}: {:.0f} %", PositionText(state), state.share * 100);
    if (estimate.picture_seconds >= 0) text += ", " + DurationText(estimate.picture_seconds);
  }
  text += SpeedText(estimate);
  if (!state.what.empty()) text += "  " + OneLine(state.what);
  return text.substr(0, kColumns);
}

std::string PlainText(const ProgressState& state) {
  const ProgressEstimate estimate = Estimate(state);
  std::string text =
      fmt::format("{:.0f} % rendered, {}", estimate.share * 100, LeftText(estimate.seconds));
  if (state.pictures > 1) {
    text += fmt::format("; {}: {:.0f} %, {}", PositionText(state), state.share * 100,
                        LeftText(estimate.picture_seconds));
  }
  text += SpeedText(estimate);
  if (!state.what.empty()) text += ": " + OneLine(state.what);
  return text + "\n";
}

std::string JsonText(const ProgressState& state) {
  const ProgressEstimate estimate = Estimate(state);
  nlohmann::ordered_json json;
  json["share"] = estimate.share;
  json["pictures_done"] = state.pictures_done;
  json["pictures"] = state.pictures;
  json["picture"] = state.what;
  json["picture_share"] = state.share;
  json["seconds"] = state.seconds;
  json["seconds_left"] = Known(estimate.seconds);
  json["picture_seconds_left"] = Known(estimate.picture_seconds);
  json["samples_per_second"] = Known(estimate.samples_per_second);
  // A name of a file may have any bytes.
  return JsonText(json, -1, JsonCharacters::kAscii) + "\n";
}

std::string OpenJdText(const ProgressState& state) {
  const ProgressEstimate estimate = Estimate(state);
  std::string status = LeftText(estimate.seconds) + SpeedText(estimate);
  if (state.pictures > 1) status = PositionText(state) + ", " + status;
  if (!state.what.empty()) status += ": " + OneLine(state.what);
  return fmt::format("openjd_progress: {:.1f}\nopenjd_status: {}\n", estimate.share * 100, status);
}

std::string OpenJdFailure(const std::string& message) {
  return fmt::format("openjd_fail: {}\n", OneLine(message));
}

}  // namespace skywave
