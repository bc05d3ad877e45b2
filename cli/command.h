// A subcommand as data: its options, bound to the fields that they set, and its action. The parser,
// the help texts and `skywave options` are made from it; only cli/parse.cc knows CLI11.
#pragma once

#include <functional>
#include <memory>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "wavefront/option.h"

namespace skywave {

// The names of the options that a user gave, without dashes.
using GivenOptions = std::set<std::string, std::less<>>;

struct Command {
  std::string name, summary;
  std::string footer = {};  // end of the help text: lists and examples
  std::vector<BoundOption> options = {};
  std::function<int(const GivenOptions& given)> run = {};  // returns the exit code
  std::vector<Command> children = {};                      // if there are any, one has to be named
};

// Adds `options`, except for those named in `without`, to `command`. They set fields of `*target`.
template <class Options, class Request>
void AddOptions(Command& command, const Options& options, const std::shared_ptr<Request>& target,
                const std::set<std::string_view>& without = {}) {
  for (const auto& option : options) {
    if (!without.contains(option.name)) command.options.push_back(Bind(option, target));
  }
}

// Returns `command` with `options`, which set the fields that `main` gets.
template <class Flags>
Command CommandOf(Command command, const std::vector<OptionOf<Flags>>& options,
                  int (*main)(const Flags& flags)) {
  const auto flags = std::make_shared<Flags>();
  command.run = [flags, main](const GivenOptions&) { return main(*flags); };
  AddOptions(command, options, flags);
  return command;
}

// Returns the option `name`, which the command must have, so that its help text can be changed.
OptionInfo& OptionCalled(Command& command, std::string_view name);

}  // namespace skywave
