#include "cli/parse.h"

#include <fmt/format.h>
#include <tbb/task_arena.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>

#include "base/error.h"
#include "base/granted.h"
#include "base/version.h"
#include "bench/measure/revision.h"
#include "cli/print.h"
#include "kernels/targets.h"
#include "scene/embree.h"
#include "skywave/skywave.h"

namespace skywave {
namespace {

std::string FlagsOf(const OptionInfo& info) {
  if (info.positional) return std::string(info.name);
  const std::string name =
      (info.is_switch && info.printed_default == "true" ? "--no-" : "--") + std::string(info.name);
  return info.letter == 0 ? name : fmt::format("-{},{}", info.letter, name);
}

// Returns the hidden flag that a switch and a word are turned into, since switches have no values.
std::string FlagOfWord(const OptionInfo& info, std::string_view word) {
  return fmt::format("--{}-{}", info.name, word);
}

// Joins switches of the command to words that follow them, after a blank or an equals sign.
std::vector<std::string> JoinWords(std::vector<std::string> arguments,
                                   const std::vector<BoundOption>& options) {
  for (const BoundOption& option : options) {
    const OptionInfo& info = option.info;
    const std::string flag = "--" + std::string(info.name);
    for (std::size_t i = 0; i < arguments.size() && !info.words.empty(); ++i) {
      if (arguments[i].starts_with(flag + "=")) {
        const std::string word = arguments[i].substr(flag.size() + 1);
        if (IsOneOf(word, info.words)) arguments[i] = FlagOfWord(info, word);
      }
      if (arguments[i] != flag || i + 1 == arguments.size()) continue;
      if (!IsOneOf(arguments[i + 1], info.words)) continue;
      arguments[i] = FlagOfWord(info, arguments[i + 1]);
      arguments.erase(arguments.begin() + std::ptrdiff_t(i) + 1);
    }
  }
  return arguments;
}

void AddOption(CLI::App& app, const BoundOption& option, GivenOptions& given) {
  const OptionInfo& info = option.info;
  const std::string flags = FlagsOf(info), group(info.group);
  const auto take = [&option, &given, flags](const std::vector<std::string>& texts) {
    given.emplace(option.info.name);
    const std::string problem = option.set(texts);
    if (!problem.empty()) {
      throw CLI::ValidationError(flags.substr(flags.find(',') + 1), problem);
    }
  };
  if (info.is_switch) {
    const bool on = info.printed_default == "true";
    const auto put = [take](bool value) {
      return [take, value](std::int64_t) { take({value ? "true" : "false"}); };
    };
    app.add_flag_function(flags, put(!on), Explanation(info))->group(group);
    // The default value can be given explicitly too, for scripts; it is not worth a line of help.
    app.add_flag_function((on ? "--" : "--no-") + std::string(info.name), put(on))->group("");
    for (const std::string& word : SplitWords(info.words)) {
      app.add_flag_function(FlagOfWord(info, word), [take, word](std::int64_t) { take({word}); })
          ->group("");
    }
    return;
  }
  CLI::Option* added;
  if (info.most_values > 1 && info.delimiter != 0) {
    // The list is one word; if the option is given several times, their lists are joined.
    added = app.add_option_function<std::vector<std::string>>(flags, take, Explanation(info))
                ->expected(1)
                ->allow_extra_args(false)
                ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll)
                ->delimiter(info.delimiter);
  } else if (info.most_values > 1) {
    added = app.add_option_function<std::vector<std::string>>(flags, take, Explanation(info))
                ->expected(1, info.most_values);
  } else if (info.positional) {
    added = app.add_option_function<std::string>(
        flags, [take](const std::string& text) { take({text}); }, Explanation(info));
  } else {
    // If an option is given several times, the last one counts, but all have to be valid.
    added = app.add_option_function<std::vector<std::string>>(
                   flags,
                   [take](const std::vector<std::string>& texts) {
                     for (const std::string& text : texts) take({text});
                   },
                   Explanation(info))
                ->expected(1)
                ->allow_extra_args(false)
                ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  }
  added->type_name(info.positional ? "" : info.value_name)->group(group)->required(info.required);
}

void AddCommand(CLI::App& parent, const Command& command, GivenOptions& given,
                const Command*& chosen) {
  CLI::App* const app = parent.add_subcommand(command.name, command.summary);
  if (!command.options.empty()) app->get_help_ptr()->group("Common");
  for (const BoundOption& option : command.options) AddOption(*app, option, given);
  for (const BoundOption& option : command.options) {
    const auto called = [app](std::string_view name) {
      return app->get_option("--" + std::string(name));
    };
    if (!option.info.needs.empty()) {
      called(option.info.name)->needs(called(option.info.needs));
    }
    if (!option.info.excludes.empty()) {
      called(option.info.name)->excludes(called(option.info.excludes));
    }
  }
  app->footer(command.footer);
  for (const Command& child : command.children) AddCommand(*app, child, given, chosen);
  if (!command.children.empty()) app->require_subcommand(1);
  if (command.run) app->callback([&command, &chosen] { chosen = &command; });
}

// Returns `code`, or that of an error, which it prints, if standard output has not taken all that
// was printed.
int AfterOutput(int code) {
  const bool lost = std::ferror(stdout) != 0;
  const bool flushed = std::fflush(stdout) == 0;
  if (flushed && !lost) return code;
  const std::string reason = flushed ? "" : std::string(": ") + std::strerror(errno);
  Print(stderr, "skywave: standard output: cannot be written{}\n", reason);
  return code == 0 ? kExitIo : code;
}

// Prints the error and returns its exit code.
int Report(const std::exception_ptr& thrown) {
  const ErrorDescription error = DescribeError(thrown);
  Print(stderr, "skywave: {}\n", error.text);
  return error.exit_code;
}

// Returns the exit code of `run`; prints what it throws.
int Run(const std::function<int()>& run) {
  try {
    return run();
  } catch (...) {
    return Report(std::current_exception());
  }
}

std::string VersionText() {
  std::string text = fmt::format("skywave {} (revision {}, Embree {})", Version(), GitRevision(),
                                 RTC_VERSION_STRING);
  const Granted& granted = GrantedHere();
  if (granted.limits_threads()) {
    text += fmt::format("\nthreads: {} ({})", granted.threads, granted.threads_from);
  }
  return text;
}

}  // namespace

OptionInfo& OptionCalled(Command& command, std::string_view name) {
  for (BoundOption& option : command.options) {
    if (option.info.name == name) return option.info;
  }
  throw std::logic_error("no option " + std::string(name));
}

std::string SpellFlags(std::string_view text) {
  std::string spelled;
  bool mention = false;
  for (const char c : text) {
    if (c != '`') {
      spelled += c;
    } else if (mention = !mention; mention) {
      spelled += "--";
    }
  }
  return spelled;
}

std::string Message(const OptionError& error) {
  std::string flags;
  for (const OptionValue& option : error.options()) {
    if (!flags.empty()) flags += ' ';
    flags += "--" + option.name;
    if (!option.value.empty()) flags += ' ' + option.value;
  }
  return flags + ": " + SpellFlags(error.why());
}

ErrorDescription DescribeError(const std::exception_ptr& thrown) {
  try {
    std::rethrow_exception(thrown);
  } catch (const api::Error& error) {
    // The library has translated an error of ours, which knows its exit code and its options.
    try {
      std::rethrow_if_nested(error);
    } catch (...) {
      return DescribeError(std::current_exception());
    }
    return {error.what(), kExitUsage};
  } catch (const OptionError& error) {
    return {Message(error), error.exit_code()};
  } catch (const InputError& error) {
    return {error.what(), error.exit_code()};
  } catch (const std::bad_alloc&) {
    return {"out of memory", kExitIo};
  } catch (const std::exception& error) {
    return {error.what(), 1};
  }
}

namespace {

int ParseAndRun(int argc, char** argv, const std::vector<Command>& commands) {
  CLI::App program{std::string(kProgramDescription) +
                   "\nStart with:  skywave render gallery -o gallery.exr"};
  program.set_version_flag("--version", VersionText());
  program.require_subcommand(1);
  GivenOptions given;
  const Command* chosen = nullptr;
  for (const Command& command : commands) AddCommand(program, command, given, chosen);
  std::vector<std::string> arguments(argv + 1, argv + argc);
  for (const Command& command : commands) {
    if (!arguments.empty() && arguments.front() == command.name) {
      arguments = JoinWords(std::move(arguments), command.options);
    }
  }
  std::reverse(arguments.begin(), arguments.end());  // as CLI11 wants them
  try {
    program.parse(std::move(arguments));
  } catch (const CLI::ParseError& error) {
    return program.exit(error) == 0 ? 0 : kExitUsage;
  }
  // The arena is for what runs in parallel without an option for the number of threads.
  tbb::task_arena arena(GrantedHere().threads);
  return arena.execute([&] {
    return Run([&] {
      RequireKernelTarget();
      return chosen->run(given);
    });
  });
}

}  // namespace

int RunCommandLine(int argc, char** argv, const std::vector<Command>& commands) {
  return AfterOutput(ParseAndRun(argc, argv, commands));
}

}  // namespace skywave
