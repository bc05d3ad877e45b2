// skywave: renders scenes lit by illumination maps on multicore CPUs.
#include "cli/commands.h"
#include "cli/parse.h"
#include "cli/signals.h"

int main(int argc, char** argv) {
  skywave::KeepStandardStreams();
  skywave::TakeFileLimitsAsErrors();
  skywave::EndWithoutUnfinishedFiles();
  return skywave::RunCommandLine(argc, argv, skywave::AllCommands());
}
