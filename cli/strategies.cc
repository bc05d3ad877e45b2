// Implements skywave strategies: the values that --strategy takes.
#include "cli/commands.h"
#include "cli/print.h"
#include "lights/strategies/strategy.h"

namespace skywave {
namespace {

int StrategiesMain() {
  for (const StrategyFactory& strategy : Strategies()) {
    Print(stdout, "{:<16}{}\n", strategy.name, strategy.description);
    for (const StrategyParameter& parameter : strategy.parameters) {
      Print(stdout, "{:<16}  {}={}  {}\n", "", parameter.key, parameter.default_value,
            parameter.meaning);
    }
  }
  return 0;
}

}  // namespace

Command StrategiesCommand() {
  return {.name = "strategies",
          .summary = "List the light strategies and their parameters",
          .footer = "Example:\n  skywave render gallery --strategy importance:compensate=1",
          .run = [](const GivenOptions&) { return StrategiesMain(); }};
}

}  // namespace skywave
