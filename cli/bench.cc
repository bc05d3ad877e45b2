#include "cli/commands.h"
namespace skywave {
void AddBenchCommand(CLI::App&, Run&) {}
}  // namespace skywave
