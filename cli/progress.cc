#include "cli/progress.h"

#include <unistd.h>

#include <cstdio>
#include <exception>
#include <string>

#include "cli/parse.h"
#include "cli/print.h"

namespace skywave {
namespace {

ProgressForm FormOf(const ProgressFlags& flags) {
  const bool terminal = isatty(STDERR_FILENO) != 0;
  return flags.form.value_or(terminal ? ProgressForm::kBar : ProgressForm::kPlain);
}

// Seconds between two lines, at least.
double Pause(ProgressForm form) {
  switch (form) {
    case ProgressForm::kBar:
      return 0.2;
    case ProgressForm::kPlain:
      return 10;
    case ProgressForm::kJson:
    case ProgressForm::kOpenJd:
      return 0.5;
  }
  return 0;
}

}  // namespace

ProgressDisplay::ProgressDisplay(const ProgressFlags& flags, std::size_t pictures)
    : form_(FormOf(flags)), quiet_(flags.quiet), start_(Clock::now()), picture_start_(start_) {
  state_.pictures = pictures;
  // A log gets its first line after a pause; a program learns at once what there will be.
  if (form_ == ProgressForm::kPlain) last_ = start_;
}

ProgressDisplay::~ProgressDisplay() { Clear(); }

void ProgressDisplay::Begin(const std::string& what, std::uint64_t samples) {
  state_.what = what;
  state_.samples = samples;
  state_.share = 0;
  picture_start_ = Clock::now();
  Print(false);
}

void ProgressDisplay::Show(double done) {
  state_.share = done;
  Print(false);
}

void ProgressDisplay::End() {
  state_.timed_seconds += SecondsSince(picture_start_);
  ++state_.timed_pictures;
  Skip();
}

void ProgressDisplay::Skip() {
  ++state_.pictures_done;
  state_.share = 0;
  picture_start_ = Clock::now();
  // Programs get a line about the end; people see it.
  const bool last = state_.pictures_done >= state_.pictures;
  Print(last && (form_ == ProgressForm::kJson || form_ == ProgressForm::kOpenJd));
}

void ProgressDisplay::Clear() {
  if (!drawn_) return;
  Put(stderr, "\r\033[K");
  drawn_ = false;
  last_.reset();
}

void ProgressDisplay::Print(bool now) {
  if (quiet_ || (!now && last_ && SecondsSince(*last_) < Pause(form_))) return;
  last_ = Clock::now();
  state_.seconds = SecondsSince(start_);
  state_.picture_seconds = SecondsSince(picture_start_);
  if (form_ == ProgressForm::kBar) {
    Put(stderr, "\r\033[K" + BarText(state_));
    drawn_ = true;
  } else if (form_ == ProgressForm::kPlain) {
    Put(stderr, PlainText(state_));
  } else if (form_ == ProgressForm::kJson) {
    Put(stderr, JsonText(state_));
  } else {
    Put(stdout, OpenJdText(state_));
  }
}

void ShowProgress(ProgressDisplay& display, const std::string& what, std::uint64_t total,
                  const WatchedWork& work) {
  display.Begin(what, total);
  Watch(total, work, [&](double done) {
    display.Show(done);
    return true;
  });
  display.End();
}

int TellFailures(const ProgressFlags& flags, const std::function<int()>& work) {
  if (flags.quiet || flags.form != ProgressForm::kOpenJd) return work();
  try {
    return work();
  } catch (...) {
    Put(stdout, OpenJdFailure(DescribeError(std::current_exception()).text));
    throw;
  }
}

}  // namespace skywave
