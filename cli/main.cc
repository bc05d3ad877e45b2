// skywave: renders scenes lit by illumination maps on multicore CPUs.
#include "cli/commands.h"
#include "cli/parse.h"

int main(int argc, char** argv) {
  return skywave::RunCommandLine(argc, argv, skywave::AllCommands());
}
