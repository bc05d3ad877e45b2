// Implements skywave options: every option of every subcommand, for people and for programs.
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "base/version.h"
#include "cli/commands.h"

namespace skywave {
namespace {

struct OptionsFlags {
  std::string command, format = "text";
  bool json = false;
};

// A subcommand as users type it, for example "probe info".
struct NamedCommand {
  std::string name;
  Command command;
};

void Collect(const std::vector<Command>& commands, const std::string& prefix,
             std::vector<NamedCommand>& all) {
  for (const Command& command : commands) {
    all.push_back({prefix + command.name, command});
    Collect(command.children, prefix + command.name + " ", all);
  }
}

std::vector<NamedCommand> CommandsWithOptions() {
  std::vector<NamedCommand> all;
  Collect(AllCommands(), "", all);
  std::erase_if(all, [](const NamedCommand& c) { return c.command.options.empty(); });
  return all;
}

// Returns the usage as it is typed: "-o, --output EXR", "--no-mis", "SCENE".
std::string Usage(const OptionInfo& info) {
  if (info.positional) return info.value_name;
  const bool on = info.is_switch && info.printed_default == "true";
  std::string text = info.letter == 0 ? "" : fmt::format("-{}, ", info.letter);
  text += fmt::format("--{}{}", on ? "no-" : "", info.name);
  if (!info.is_switch) text += " " + info.value_name;
  return text;
}

std::string Json(const std::vector<NamedCommand>& commands) {
  nlohmann::ordered_json json;
  json["schema"] = "skywave-options-1";
  json["version"] = Version();
  for (const auto& [name, command] : commands) {
    auto& list = json["commands"][name];
    list = nlohmann::ordered_json::array();
    for (const BoundOption& option : command.options) {
      const OptionInfo& info = option.info;
      nlohmann::ordered_json entry = {{"name", info.name},
                                      {"usage", Usage(info)},
                                      {"group", info.group},
                                      {"help", info.help},
                                      {"values", info.values},
                                      {"default", DefaultText(info)},
                                      {"scope", ToString(info.scope)},
                                      {"example", info.example},
                                      {"positional", info.positional},
                                      {"required", info.required},
                                      {"switch", info.is_switch},
                                      {"scene_may_set", info.scene_may_set}};
      if (info.applies != nullptr) entry["integrators"] = IntegratorsOf(info);
      list.push_back(std::move(entry));
    }
  }
  return json.dump(2) + "\n";
}

std::string Text(const std::vector<NamedCommand>& commands) {
  std::string text;
  for (const auto& [name, command] : commands) {
    text += fmt::format("skywave {}\n", name);
    for (const BoundOption& option : command.options) {
      text += fmt::format("  {:<34} {:<7} {}\n", Usage(option.info), ToString(option.info.scope),
                          Explanation(option.info));
    }
    text += "\n";
  }
  return text;
}

std::string Markdown(const std::vector<NamedCommand>& commands) {
  std::string text =
      "# Options\n\nMade by `skywave options --format markdown`; a test keeps it current. *Scope* "
      "is what an\noption changes: the input, the pixels, the speed or the output.\n";
  const auto cell = [](std::string words) {
    for (std::size_t at = 0; (at = words.find('|', at)) != std::string::npos; at += 2) {
      words.insert(at, 1, '\\');
    }
    return words;
  };
  for (const auto& [name, command] : commands) {
    text += fmt::format(
        "\n## skywave {}\n\n{}.\n\n| option | scope | meaning |\n| --- | --- | --- "
        "|\n",
        name, command.summary);
    for (const BoundOption& option : command.options) {
      text += fmt::format("| `{}` | {} | {} |\n", cell(Usage(option.info)),
                          ToString(option.info.scope), cell(Explanation(option.info)));
    }
  }
  return text;
}

// Returns the words of "a|b|c" if the values of an option are such words, else none.
std::string WordsOf(const OptionInfo& info) {
  if (info.is_switch || info.values.find('|') == std::string::npos ||
      info.values.find_first_of(" ,:<>") != std::string::npos) {
    return "";
  }
  std::string words = info.values;
  std::replace(words.begin(), words.end(), '|', ' ');
  return words;
}

std::string FlagWord(const OptionInfo& info) {
  const bool on = info.is_switch && info.printed_default == "true";
  return fmt::format("--{}{}", on ? "no-" : "", info.name);
}

std::string BashCompletion(const std::vector<NamedCommand>& commands) {
  std::string text =
      "# bash completion for skywave, made by: skywave options --format bash\n"
      "_skywave() {\n"
      "  local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD-1]}\n"
      "  local command=${COMP_WORDS[1]} flags= values=\n"
      "  [[ $command == probe ]] && command+=\" ${COMP_WORDS[2]}\"\n"
      "  case \"$command $before\" in\n";
  for (const auto& [name, command] : commands) {
    for (const BoundOption& option : command.options) {
      if (const std::string words = WordsOf(option.info); !words.empty()) {
        text += fmt::format("    '{} --{}') values='{}' ;;\n", name, option.info.name, words);
      }
    }
  }
  text += "  esac\n  case \"$command\" in\n";
  std::string names, children;
  for (const Command& command : AllCommands()) {
    names += (names.empty() ? "" : " ") + command.name;
    for (const Command& child : command.children) {
      children += (children.empty() ? "" : " ") + child.name;
    }
  }
  for (const auto& [name, command] : commands) {
    text += fmt::format("    '{}') flags='", name);
    for (const BoundOption& option : command.options) {
      if (!option.info.positional) text += FlagWord(option.info) + " ";
    }
    text += "--help' ;;\n";
  }
  text += fmt::format(
      "  esac\n"
      "  if [[ $COMP_CWORD == 1 ]]; then\n"
      "    COMPREPLY=($(compgen -W '{} --help --version' -- \"$word\"))\n"
      "  elif [[ ${{COMP_WORDS[1]}} == probe && $COMP_CWORD == 2 ]]; then\n"
      "    COMPREPLY=($(compgen -W '{} --help' -- \"$word\"))\n"
      "  elif [[ -n $values ]]; then\n"
      "    COMPREPLY=($(compgen -W \"$values\" -- \"$word\"))\n"
      "  elif [[ $word == -* ]]; then\n"
      "    COMPREPLY=($(compgen -W \"$flags\" -- \"$word\"))\n"
      "  else\n"
      "    COMPREPLY=($(compgen -f -- \"$word\"))\n"
      "  fi\n"
      "}}\n"
      "complete -o filenames -F _skywave skywave\n",
      names, children);
  return text;
}

std::string ZshCompletion(const std::vector<NamedCommand>& commands) {
  const auto quoted = [](std::string_view help) {
    std::string text;
    for (const char c : help) {
      if (c == '\'') {
        text += "'\\''";
      } else if (c == '[' || c == ']' || c == ':') {
        text += std::string("\\") + c;
      } else {
        text += c;
      }
    }
    return text;
  };
  std::string text =
      "#compdef skywave\n# zsh completion for skywave, made by: skywave options --format zsh\n"
      "local -a commands probes\ncommands=(";
  std::string probes;
  for (const Command& command : AllCommands()) {
    text += fmt::format(" '{}:{}'", command.name, quoted(command.summary));
    for (const Command& child : command.children) {
      probes += fmt::format(" '{}:{}'", child.name, quoted(child.summary));
    }
  }
  text += fmt::format(
      " )\nprobes=({} )\n"
      "if (( CURRENT == 2 )); then _describe command commands; return; fi\n"
      "local command=$words[2]\n"
      "if [[ $command == probe ]]; then\n"
      "  if (( CURRENT == 3 )); then _describe command probes; return; fi\n"
      "  command=\"probe $words[3]\"\n"
      "fi\n"
      "case $command in\n",
      probes);
  for (const auto& [name, command] : commands) {
    text += fmt::format("  '{}') _arguments", name);
    for (const BoundOption& option : command.options) {
      const OptionInfo& info = option.info;
      if (info.positional) continue;
      const std::string words = WordsOf(info);
      const std::string value = info.is_switch  ? ""
                                : words.empty() ? ":value:_files"
                                                : fmt::format(":value:({})", words);
      text += fmt::format(" '{}[{}]{}'", FlagWord(info), quoted(info.help), value);
    }
    text += " '*:file:_files' ;;\n";
  }
  return text + "esac\n";
}

int OptionsMain(const OptionsFlags& flags) {
  const std::vector<NamedCommand> commands = CommandsWithOptions();
  const std::string format = flags.json ? "json" : flags.format;
  std::fputs((format == "json"       ? Json(commands)
              : format == "markdown" ? Markdown(commands)
              : format == "bash"     ? BashCompletion(commands)
              : format == "zsh"      ? ZshCompletion(commands)
                                     : Text(commands))
                 .c_str(),
             stdout);
  return 0;
}

}  // namespace

Command OptionsCommand() {
  const auto flags = std::make_shared<OptionsFlags>();
  const OptionOf<OptionsFlags> options[] = {
      MakeOption<OptionsFlags>({.name = "json", .help = "the same as --format json"},
                               SKYWAVE_FIELD(json), Switches()),
      MakeOption<OptionsFlags>({.name = "format", .help = "form of the list, or a completion"},
                               SKYWAVE_FIELD(format), OneOf("text|json|markdown|bash|zsh"))};
  Command command = {.name = "options",
                     .summary = "List every option with its scope and default",
                     .footer =
                         "Examples:\n"
                         "  skywave options --json\n"
                         "  skywave options --format bash > skywave.bash",
                     .run = [flags](const GivenOptions&) { return OptionsMain(*flags); }};
  AddOptions(command, options, flags);
  return command;
}

}  // namespace skywave
