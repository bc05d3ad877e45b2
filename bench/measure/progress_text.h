// The progress of long work as text: for people, for programs, and for render managers.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "base/names.h"

namespace skywave {

enum class ProgressForm {
  kBar,    // one line of a terminal, which is written over
  kPlain,  // lines for a log
  kJson,   // one object a line
  kOpenJd  // lines for Open Job Description
};
template <>
inline constexpr auto kEnumNames<ProgressForm> =
    std::to_array<Named<ProgressForm>>({{ProgressForm::kBar, "bar"},
                                        {ProgressForm::kPlain, "plain"},
                                        {ProgressForm::kJson, "json"},
                                        {ProgressForm::kOpenJd, "openjd"}});

// How far the work is. A picture is one unit of it: a frame of a batch, or a step of a measurement.
struct ProgressState {
  std::string what;  // the current picture's name, or none
  std::size_t pictures_done = 0, pictures = 1;
  double share = 0;                         // of the current picture, in [0, 1]
  std::uint64_t samples = 0;                // of the whole current picture; 0: unknown
  double seconds = 0, picture_seconds = 0;  // since the start of all and of the current picture
  std::size_t timed_pictures = 0;           // finished ones that took time, in `timed_seconds`
  double timed_seconds = 0;
};

// The estimates below are negative where nothing is known yet.
struct ProgressEstimate {
  double share = 0;                // of all pictures, in [0, 1]
  double picture_seconds = -1;     // left for the current picture
  double seconds = -1;             // left for all
  double samples_per_second = -1;  // of the current picture
};

// Pictures that are not begun are taken to be like the finished ones, else like the current one.
// The current picture's time goes from the mean of the finished ones to what its own share says as
// that share grows, so the first tiles of a picture do not make the estimate jump.
ProgressEstimate Estimate(const ProgressState& state);

// "12 s", "3:20" or "1:02:03".
std::string DurationText(double seconds);

// One line of at most 79 columns, without an end of line.
std::string BarText(const ProgressState& state);
// One line with its end.
std::string PlainText(const ProgressState& state);
// One line with its end: an object with the keys of docs/farm.md. It is ASCII and valid JSON
// whatever bytes the name has.
std::string JsonText(const ProgressState& state);
// Lines as Open Job Description reads them from standard output (docs/references.md).
std::string OpenJdText(const ProgressState& state);
std::string OpenJdFailure(const std::string& message);

}  // namespace skywave
