// Shows the progress of long work as `--progress` asks for it.
#pragma once

#include <cstdint>
#include <cstdio>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "base/clock.h"
#include "bench/measure/progress_text.h"
#include "job/watch.h"
#include "wavefront/option.h"

namespace skywave {

// What a command shows of its progress.
struct ProgressFlags {
  std::optional<ProgressForm> form;  // none: a bar on a terminal, plain lines elsewhere
  bool quiet = false;                // nothing, whatever the form
};

// The option of a command whose flags have `progress`, ProgressFlags.
template <class Flags>
OptionOf<Flags> ProgressOption() {
  return MakeOption<Flags>(
      {.name = "progress",
       .group = "Output",
       .help = "form of the progress: a line of the terminal, lines of a log, JSON (keys: "
               "docs/farm.md), or lines for Open Job Description on standard output",
       .default_text = "bar on a terminal, else plain"},
      SKYWAVE_FIELD(progress.form), NamesOfEnum<ProgressForm>());
}

// Prints to standard error; Open Job Description reads standard output.
class ProgressDisplay {
 public:
  // `pictures`: how many there will be.
  explicit ProgressDisplay(const ProgressFlags& flags, std::size_t pictures = 1);
  ProgressDisplay(const ProgressDisplay&) = delete;
  ProgressDisplay& operator=(const ProgressDisplay&) = delete;
  // Clears the bar.
  ~ProgressDisplay();

  // Begins the next picture, of which there are `samples`; 0: unknown.
  void Begin(const std::string& what, std::uint64_t samples);
  // Takes the share of the current picture that is done, in [0, 1]. Prints nothing if it has
  // printed a moment ago.
  void Show(double done);
  // Ends the current picture.
  void End();
  // Counts a picture that need not be rendered and so does not affect the estimated time of the
  // others.
  void Skip();
  // Clears the bar, so that other lines can be printed; the next Show draws it again.
  void Clear();

 private:
  void Print(bool now);

  ProgressForm form_;
  bool quiet_;
  bool drawn_ = false;  // there is a bar to clear
  ProgressState state_;
  Clock::time_point start_, picture_start_;
  std::optional<Clock::time_point> last_;
};

// Runs `work` (see Watch) as the next picture and meanwhile shows its progress to `total` samples.
void ShowProgress(ProgressDisplay& display, const std::string& what, std::uint64_t total,
                  const WatchedWork& work);

// Returns what `work` returns. Where the form is that of Open Job Description, an error that `work`
// throws is reported there too.
int TellFailures(const ProgressFlags& flags, const std::function<int()>& work);

}  // namespace skywave
