// Implements skywave options: every option of every subcommand, for people and for programs.
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "base/error.h"
#include "base/json.h"
#include "base/version.h"
#include "cli/commands.h"
#include "cli/parse.h"

namespace skywave {
namespace {

struct OptionsFlags {
  std::string of, format = "text";
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

// Returns the subcommands that do something: "probe info", but not "probe".
std::vector<NamedCommand> RunnableCommands() {
  std::vector<NamedCommand> all;
  Collect(AllCommands(), "", all);
  std::erase_if(all, [](const NamedCommand& c) { return !c.command.run; });
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
  return JsonText(json, 2) + "\n";
}

std::string Text(const std::vector<NamedCommand>& commands) {
  std::string text;
  for (const auto& [name, command] : commands) {
    if (command.options.empty()) continue;
    text += fmt::format("skywave {}\n", name);
    for (const BoundOption& option : command.options) {
      text += fmt::format("  {:<34} {:<7} {}\n", Usage(option.info), ToString(option.info.scope),
                          Explanation(option.info));
    }
    text += "\n";
  }
  return text;
}

std::string FlagWord(const OptionInfo& info) {
  const bool on = info.is_switch && info.printed_default == "true";
  return fmt::format("--{}{}", on ? "no-" : "", info.name);
}

// Lists "`a`, `b` and `c`" in lines of at most 100 columns after `start`.
std::string Listed(std::string text, const std::vector<std::string>& names) {
  std::size_t column = text.size();
  for (std::size_t i = 0; i < names.size(); ++i) {
    const std::string word = fmt::format("`{}`{}", names[i], i + 1 < names.size() ? "," : ".");
    const bool fits = column + 1 + word.size() <= 100;
    text += (fits ? " " : "\n") + word;
    column = (fits ? column + 1 : 0) + word.size();
  }
  return text + "\n";
}

// Each option stands in the table of the first subcommand that has it; later ones that mean the
// same by it only name it.
std::string Markdown(const std::vector<NamedCommand>& commands) {
  std::string text =
      "# Options\n\nMade by `skywave options --format markdown`; a test keeps it current. *Scope* "
      "is what an\noption changes: the input, the pixels, the speed or the output. An option of "
      "several subcommands is\nin the table of the first one, to which the others refer.\n";
  const auto cell = [](std::string words) {
    for (std::size_t at = 0; (at = words.find('|', at)) != std::string::npos; at += 2) {
      words.insert(at, 1, '\\');
    }
    return words;
  };
  std::map<std::string, std::string> first;  // by row: the subcommand that has printed it
  for (const auto& [name, command] : commands) {
    if (command.options.empty()) continue;
    text += fmt::format("\n## skywave {}\n\n{}.\n", name, command.summary);
    std::vector<std::pair<std::string, std::vector<std::string>>> shared;
    std::string rows;
    for (const BoundOption& option : command.options) {
      const std::string row =
          fmt::format("| `{}` | {} | {} |\n", cell(Usage(option.info)), ToString(option.info.scope),
                      cell(Explanation(option.info)));
      const auto [at, is_new] = first.try_emplace(row, name);
      const std::string& printed = at->second;
      if (is_new) {
        rows += row;
        continue;
      }
      auto group = std::find_if(shared.begin(), shared.end(),
                                [&](const auto& pair) { return pair.first == printed; });
      if (group == shared.end()) group = shared.insert(group, {printed, {}});
      group->second.push_back(option.info.positional ? option.info.value_name
                                                     : FlagWord(option.info));
    }
    if (!rows.empty()) text += "\n| option | scope | meaning |\n| --- | --- | --- |\n" + rows;
    for (const auto& [owner, names] : shared) {
      std::string anchor = "skywave-" + owner;
      std::replace(anchor.begin(), anchor.end(), ' ', '-');
      text += "\n" + Listed(fmt::format("As [skywave {}](#{}):", owner, anchor), names);
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

// Returns text as roff prints it: dashes as they are typed, no escapes and no requests.
std::string Roff(std::string_view text) {
  std::string escaped;
  for (const char c : text) {
    const bool at_line_start = escaped.empty() || escaped.back() == '\n';
    if (at_line_start && (c == '.' || c == '\'')) escaped += "\\&";
    if (c == '\\') {
      escaped += "\\e";
    } else if (c == '-') {
      escaped += "\\-";
    } else {
      escaped += c;
      if (c == '|') escaped += "\\:";  // a line may end here
    }
  }
  return escaped;
}

// Returns the name of a page: "skywave-probe-info" of "probe info", "skywave" of "".
std::string PageName(std::string_view command) {
  std::string name = command.empty() ? "skywave" : "skywave-" + std::string(command);
  std::replace(name.begin(), name.end(), ' ', '-');
  return name;
}

std::string PageHead(std::string_view command, std::string_view summary) {
  std::string title = PageName(command);
  std::transform(title.begin(), title.end(), title.begin(),
                 [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  return fmt::format(
      ".\\\" Made by: skywave options --format man\n"
      ".TH {} 1 \"\" \"skywave {}\" \"User Commands\"\n.SH NAME\n{} \\- {}\n.SH SYNOPSIS\n",
      title, Version(), Roff(PageName(command)), Roff(summary));
}

constexpr std::string_view kHelpEntry =
    ".TP\n.B \\-h\\fR, \\fB\\-\\-help\nprint a summary and exit\n";

std::string ManEntry(const OptionInfo& info) {
  const std::string usage = Usage(info);
  const std::size_t space = info.positional ? 0 : usage.find(' ', usage.find("--"));
  const std::string flag = usage.substr(0, space);
  std::string tag = flag.empty() ? "" : "\\fB" + Roff(flag) + "\\fR";
  if (flag.size() < usage.size()) tag += "\\fI" + Roff(usage.substr(flag.size())) + "\\fR";
  return ".TP\n" + tag + "\n" + Roff(Explanation(info)) + "\n";
}

// The manual page of a subcommand, for man(1).
std::string ManPage(const NamedCommand& named) {
  const auto& [name, command] = named;
  std::string text = PageHead(name, command.summary) + fmt::format(".B skywave {}\n", name);
  std::string groups;
  std::set<std::string_view> seen;
  for (const BoundOption& option : command.options) {
    if (option.info.positional) {
      text += fmt::format(fmt::runtime(option.info.required ? "\\fI{}\\fR\n" : "[\\fI{}\\fR]\n"),
                          Roff(option.info.value_name));
    }
    if (!seen.insert(option.info.group).second) continue;
    groups += fmt::format(".SS {}\n", Roff(option.info.group));
    for (const BoundOption& other : command.options) {
      if (other.info.group == option.info.group) groups += ManEntry(other.info);
    }
  }
  text += fmt::format("[\\fIOPTION\\fR ...]\n.SH OPTIONS\n{}{}", kHelpEntry, groups);
  const std::size_t examples = std::min(command.footer.find("Example"), command.footer.size());
  const auto literal = [&text](std::string_view heading, std::string_view lines) {
    while (lines.ends_with('\n')) lines.remove_suffix(1);
    if (!lines.empty()) text += fmt::format(".SH {}\n.nf\n{}\n.fi\n", heading, Roff(lines));
  };
  literal("NOTES", std::string_view(command.footer).substr(0, examples));
  const std::size_t line_end = command.footer.find('\n', examples);
  if (line_end != std::string::npos) {
    literal("EXAMPLES", std::string_view(command.footer).substr(line_end + 1));
  }
  return text + ".SH SEE ALSO\n.BR skywave (1)\n";
}

// The page skywave(1).
std::string ManOverview(const std::vector<NamedCommand>& commands) {
  std::string text = PageHead("", "render scenes lit by illumination maps");
  text += ".B skywave\n\\fICOMMAND\\fR [\\fIOPTION\\fR ...]\n.SH DESCRIPTION\n" +
          Roff(kProgramDescription) + "\n.SH COMMANDS\n";
  for (const auto& [name, command] : commands) {
    text += fmt::format(".TP\n.B {}\n{}; see\n.BR {} (1)\n", name, Roff(command.summary),
                        Roff(PageName(name)));
  }
  return text +
         fmt::format(
             ".SH OPTIONS\n{}.TP\n.B \\-\\-version\nprint the version and exit\n"
             ".SH EXIT STATUS\n.TP\n.B 0\nsuccess\n.TP\n.B {}\nan option that makes no sense\n"
             ".TP\n.B {}\na file that cannot be used\n"
             ".TP\n.B {}\na file that cannot be read or written\n",
             kHelpEntry, kExitUsage, kExitBadInput, kExitIo);
}

int OptionsMain(const OptionsFlags& flags) {
  std::vector<NamedCommand> commands = RunnableCommands();
  const std::string format = flags.json ? "json" : flags.format;
  if (!flags.of.empty()) {
    std::erase_if(commands, [&](const NamedCommand& c) { return c.name != flags.of; });
    if (commands.empty()) throw OptionError("of", flags.of, "there is no such subcommand");
  }
  std::fputs((format == "json"       ? Json(commands)
              : format == "markdown" ? Markdown(commands)
              : format == "man"  ? flags.of.empty() ? ManOverview(commands) : ManPage(commands[0])
               : format == "bash" ? BashCompletion(commands)
              : format == "zsh"  ? ZshCompletion(commands)
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
      MakeOption<OptionsFlags>(
          {.name = "format", .help = "form of the list, a manual page or a completion"},
          SKYWAVE_FIELD(format), OneOf("text|json|markdown|man|bash|zsh")),
      MakeOption<OptionsFlags>(
          {.name = "of", .help = "this subcommand alone, as in 'probe info'", .metavar = "COMMAND"},
          SKYWAVE_FIELD(of), Texts("the name of a subcommand"))};
  Command command = {.name = "options",
                     .summary = "List every option with its scope and default",
                     .footer =
                         "Examples:\n"
                         "  skywave options --json\n"
                         "  skywave options --format man --of render | man -l -\n"
                         "  skywave options --format bash > skywave.bash",
                     .run = [flags](const GivenOptions&) { return OptionsMain(*flags); }};
  AddOptions(command, options, flags);
  return command;
}

}  // namespace skywave
