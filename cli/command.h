// A subcommand as data: its options, bound to the fields that they set, and what it does. The
// parser, the help texts and `skywave options` are made from it; only cli/parse.cc knows CLI11.
#pragma once

#include <functional>
#include <memory>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "job/option.h"

namespace skywave {

// An option and the field that it sets.
struct BoundOption {
  OptionInfo info;
  std::function<std::string(const std::vector<std::string>& texts)> set;  // see OptionOf
};

// The names of the options that a user gave, without dashes.
using GivenOptions = std::set<std::string, std::less<>>;

struct Command {
  std::string name, summary;
  std::string footer = {};  // of the help text: lists and examples
  std::vector<BoundOption> options = {};
  std::function<int(const GivenOptions& given)> run = {};  // returns the exit code
  std::vector<Command> children = {};                      // one of which has to be named
};

// Adds `options`, but for those named in `without`, to `command`. They set fields of `*target`.
template <class Options, class Request>
void AddOptions(Command& command, const Options& options, const std::shared_ptr<Request>& target,
                const std::set<std::string_view>& without = {}) {
  for (const auto& option : options) {
    if (without.contains(option.name)) continue;
    command.options.push_back(
        {option, [target, set = option.set](const std::vector<std::string>& texts) {
           return set(*target, texts);
         }});
  }
}

// The option `name` of a command that has it, to change what its help says.
OptionInfo& OptionCalled(Command& command, std::string_view name);

}  // namespace skywave
