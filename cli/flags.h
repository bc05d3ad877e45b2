// What the subcommands share in reading flags.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <string_view>

#include "base/error.h"

namespace skywave {

// A number in [low, high]. Unlike CLI::Range it does not let NaN pass.
CLI::Validator FiniteNumber(double low, double high);

// `text` as one word of a shell command.
std::string Quoted(const std::string& text);

// `text` with its mentions of options (OptionError) spelled as flags.
std::string SpellFlags(std::string_view text);

// "--photons 0 --caustic-photons 0: why"
std::string Message(const OptionError& error);

// A flag whose text is turned into a value by a parser that returns an optional.
template <class Value, class Parse>
void AddParsed(CLI::App& command, const std::string& names, const std::string& help,
               const std::string& choices, Value& target, Parse parse) {
  command
      .add_option_function<std::string>(
          names,
          [&target, parse, names, choices](const std::string& text) {
            const auto value = parse(text);
            if (!value) throw CLI::ValidationError(names, "'" + text + "' is not " + choices);
            target = *value;
          },
          help)
      ->type_name(choices);
}

}  // namespace skywave
