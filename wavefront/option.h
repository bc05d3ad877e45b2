// What an option is: a name, what it does, which values it takes, and how text becomes the value of
// one field and text again. Flags, help, job files, the command that a picture records, completions
// and the reference are all made from such descriptions, so an option is one line of a table and
// one field.
#pragma once

#include <fmt/format.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "base/names.h"
#include "base/nearest_name.h"
#include "wavefront/integrator.h"

namespace skywave {

// What an option changes.
enum class OptionScope {
  kInput,   // which files are read, and what they may be
  kPixels,  // the picture
  kSpeed,   // the time that the same picture takes
  kOutput   // what is written or printed
};
template <>
inline constexpr auto kEnumNames<OptionScope> =
    std::to_array<Named<OptionScope>>({{OptionScope::kInput, "input"},
                                       {OptionScope::kPixels, "pixels"},
                                       {OptionScope::kSpeed, "speed"},
                                       {OptionScope::kOutput, "output"}});

// What jobs keep for each other (job/job_parts.h) and an option may change, as a set of bits. The
// scene as it is read is changed by the options of reading.
struct Tables {
  static constexpr std::uint32_t kPrepared = 1;      // a scene as the request changes it
  static constexpr std::uint32_t kTriangles = 2;     // which triangles it has then
  static constexpr std::uint32_t kBvh = 4;           // how rays find them
  static constexpr std::uint32_t kMap = 8;           // a map that the request gives
  static constexpr std::uint32_t kSceneLights = 16;  // the sum of a scene's own lights at infinity
};

// The text of an option for people and for programs.
struct OptionInfo {
  std::string_view name;              // without dashes, e.g. "max-depth"
  std::string_view group = "Common";  // heading of the help text under which it stands
  std::string_view help;              // half a sentence
  OptionScope scope = OptionScope::kOutput;
  std::uint32_t changes = 0;  // Tables that depend on its value
  // Arguments that try the option on a scene of the tests, together with what it needs, e.g.
  // "--split 2 --continuation-strategy uniform", after the name of a scene where it needs another
  // one. Every option of a job has one.
  std::string_view example = {};
  std::string_view default_text = {};  // where no field has a default value to print
  std::string_view metavar = {};       // what stands for a value in help texts, e.g. "DEGREES"
  char letter = 0;                     // one-letter form, 0: none
  bool positional = false, required = false;
  bool scene_may_set = false;   // a scene file may give it; the option comes first
  bool of_reading = false;      // it says how a scene is read; `skywave info` takes it as well
  bool in_suite = false;        // `skywave bench` takes it for its suite of scenes
  bool of_file = false;         // its value is the name of a file to read
  int most_values = 1;          // more than 1: a list, separated by spaces
  std::string_view words = {};  // values that may follow a switch, "a|b": "--ground catcher"
  char delimiter = 0;           // of a list in one word, 0: none
  std::string_view needs = {}, excludes = {};    // another option
  std::function<bool(Integrator)> applies = {};  // null: to all integrators

  // Filled in by MakeOption.
  std::string values = {};           // see Codec
  std::string value_name = {};       // the metavar: that of the option or of its codec
  std::string printed_default = {};  // empty: none
  bool is_switch = false;            // needs no value: --name or --no-name
};

// An option of a struct of fields, a request.
template <class Request>
struct OptionOf : OptionInfo {
  // Puts the value that the words of `texts` stand for into the request. Returns what is wrong with
  // them as half a sentence, or nothing if they are good.
  std::function<std::string(Request&, const std::vector<std::string>& texts)> set;
  // The words that make `set` put the same value there; none where the field is unset.
  std::function<std::vector<std::string>(const Request&)> get;
};

// An option and the field that it sets.
struct BoundOption {
  OptionInfo info;
  std::function<std::string(const std::vector<std::string>& texts)> set;  // see OptionOf
};

// Returns `option` for the fields of `*target`.
template <class Request>
BoundOption Bind(const OptionOf<Request>& option, const std::shared_ptr<Request>& target) {
  return {option, [target, set = option.set](const std::vector<std::string>& texts) {
            return set(*target, texts);
          }};
}

// The same of all options of a table.
template <class Options, class Request>
std::vector<BoundOption> BindAll(const Options& options, const std::shared_ptr<Request>& target) {
  std::vector<BoundOption> bound;
  for (const auto& option : options) bound.push_back(Bind(option, target));
  return bound;
}

// Puts `text` into the field of the option called `name`, as a flag of the command line does; the
// values of a list are separated by its delimiter or by blanks. Throws OptionError for a bad value
// and for an unknown name, for which it suggests the nearest one.
void SetOption(std::span<const BoundOption> options, const std::string& name,
               const std::string& text);

// The same for each name and value; the last value of a name counts. Throws OptionError also where
// an option is given without another one that it needs, or with one that it excludes.
void SetOptions(std::span<const BoundOption> options,
                const std::vector<std::pair<std::string, std::string>>& values);

// How text becomes a value and back. `parse` returns nullopt for invalid text.
template <class Value>
struct Codec {
  std::string values;            // what a value is: "a|b|c", or half a sentence
  std::string metavar = values;  // what stands for it in help texts
  std::function<std::optional<Value>(const std::string&)> parse;
  std::function<std::string(const Value&)> print;
  bool is_switch = false;
};

// A whole number in [low, high].
Codec<std::uint64_t> WholeNumbers(std::uint64_t low, std::uint64_t high);
Codec<std::int64_t> SignedNumbers(std::int64_t low, std::int64_t high);
// A finite number in [low, high]; it is printed with as many digits as it takes to read it back.
Codec<float> Floats(double low, double high);
Codec<double> Doubles(double low, double high);
Codec<std::string> Texts(const std::string& values);
// One of the words of "a|b|c".
Codec<std::string> OneOf(const std::string& words);
Codec<bool> Switches();

// The same codec for another type of number.
template <class To, class From>
Codec<To> As(Codec<From> codec) {
  return {
      .values = codec.values,
      .metavar = codec.metavar,
      .parse = [parse = codec.parse](const std::string& text) -> std::optional<To> {
        const std::optional<From> value = parse(text);
        if (!value) return std::nullopt;
        return static_cast<To>(*value);
      },
      .print = [print = codec.print](const To& value) { return print(static_cast<From>(value)); }};
}
template <class Number>
Codec<Number> Numbers(Number low, Number high) {
  if constexpr (std::is_same_v<Number, float>) {
    return Floats(low, high);
  } else if constexpr (std::is_same_v<Number, double>) {
    return Doubles(low, high);
  } else if constexpr (std::is_signed_v<Number>) {
    return As<Number>(SignedNumbers(low, high));
  } else {
    return As<Number>(WholeNumbers(low, high));
  }
}

// One of the names of an enum (base/names.h).
template <HasNames Enum>
Codec<Enum> NamesOfEnum() {
  return {.values = Choices<Enum>(),
          .metavar = Choices<Enum>(),
          .parse = [](const std::string& text) { return Parse<Enum>(text); },
          .print = [](const Enum& value) { return std::string(ToString(value)); }};
}

// A value that stands for "unset" and is neither printed nor a value that users can give.
template <class Value>
Codec<Value> Unless(Value unset, Codec<Value> codec) {
  codec.print = [unset, print = codec.print](const Value& value) {
    return value == unset ? std::string() : print(value);
  };
  return codec;
}

template <class T>
struct IsOptional : std::false_type {};
template <class T>
struct IsOptional<std::optional<T>> : std::true_type {};
template <class T>
struct IsVector : std::false_type {};
template <class T>
struct IsVector<std::vector<T>> : std::true_type {};

// The text that SetOption takes for the values `texts`: a list joined by its delimiter or by
// blanks.
std::string Joined(const OptionInfo& option, const std::vector<std::string>& texts);

// "'text' is not VALUES", as half a sentence of an error message.
std::string NotAValue(const std::string& text, const std::string& values);

// A field of a request, to be read and to be changed.
template <class Request, class Target>
struct FieldOf {
  const Target& (*read)(const Request&);
  Target& (*change)(Request&);
};

// The option `info` of a field: a value, an optional, or a vector for a list.
template <class Request, class Target, class Value>
OptionOf<Request> OptionOfField(const OptionInfo& info, const FieldOf<Request, Target>& field,
                                const Codec<Value>& codec) {
  OptionOf<Request> option = {info, {}, {}};
  option.values = codec.values;
  option.value_name = info.metavar.empty() ? codec.metavar : std::string(info.metavar);
  option.is_switch = codec.is_switch;
  option.set = [field, codec](Request& request, const std::vector<std::string>& texts) {
    Target& target = field.change(request);
    if constexpr (IsVector<Target>::value) target.clear();
    for (const std::string& text : texts) {
      const std::optional<Value> value = codec.parse(text);
      if (!value) return NotAValue(text, codec.values);
      if constexpr (IsVector<Target>::value) {
        target.push_back(*value);
      } else {
        target = *value;
      }
    }
    return std::string();
  };
  option.get = [field, codec](const Request& request) {
    const Target& source = field.read(request);
    std::vector<std::string> texts;
    const auto add = [&](const Value& value) {
      if (std::string text = codec.print(value); !text.empty()) texts.push_back(std::move(text));
    };
    if constexpr (IsVector<Target>::value) {
      for (const auto& value : source) add(value);
    } else if constexpr (IsOptional<Target>::value) {
      if (source) add(*source);
    } else {
      add(source);
    }
    return texts;
  };
  if (!info.default_text.empty()) {
    option.printed_default = info.default_text;
  } else {
    for (const std::string& text : option.get(Request())) {
      option.printed_default += (option.printed_default.empty() ? "" : " ") + text;
    }
  }
  return option;
}

// The same of the field that `field`, a generic lambda, finds. Each lambda is a type of its own;
// called through a function pointer, options are compiled once per type of field and not once per
// field.
template <class Request, class Field, class Value>
OptionOf<Request> MakeOption(const OptionInfo& info, Field /*field*/, const Codec<Value>& codec) {
  using Target = std::remove_reference_t<decltype(std::declval<Field>()(std::declval<Request&>()))>;
  const FieldOf<Request, Target> both = {
      .read = [](const Request& request) -> const Target& { return Field()(request); },
      .change = [](Request& request) -> Target& { return Field()(request); }};
  return OptionOfField<Request, Target, Value>(info, both, codec);
}

// The same for the options of one request, whose type is named once.
template <class Request>
struct OptionMaker {
  template <class Field, class Value>
  OptionOf<Request> operator()(const OptionInfo& info, Field field,
                               const Codec<Value>& codec) const {
    return MakeOption<Request>(info, field, codec);
  }
};

// The field `path` of a request, for MakeOption.
#define SKYWAVE_FIELD(path) \
  [](auto& fields) -> auto& { return fields.path; }

// The words of "a|b|c", and whether `word` is one of them.
std::vector<std::string> SplitWords(std::string_view words);
bool IsOneOf(std::string_view word, std::string_view words);

// `text` as one word of a shell command, in UTF-8 without control codes: bash, ksh and zsh read
// $'\351', which stands for other bytes.
std::string Quoted(const std::string& text);

// The words of a command that set `option` to what `request` has, with a blank before each: empty
// where the field is unset or a switch has its default.
template <class Request>
std::string CommandWords(const OptionOf<Request>& option, const Request& request) {
  const std::vector<std::string> texts = option.get(request);
  if (texts.empty()) return "";
  const std::string name(option.name);
  if (option.positional) return " " + Quoted(texts.front());
  if (option.is_switch) {
    if (texts.front() == option.printed_default) return "";
    if (IsOneOf(texts.front(), option.words)) return fmt::format(" --{} {}", name, texts.front());
    return (texts.front() == "true" ? " --" : " --no-") + name;
  }
  if (option.delimiter != 0) {
    return " --" + name + " " + Quoted(Joined(option, texts));
  }
  // A value that begins with a dash would be taken for a flag.
  if (texts.size() == 1) {
    return " --" + name + (texts.front().starts_with('-') ? "=" : " ") + Quoted(texts.front());
  }
  std::string words = " --" + name;
  for (const std::string& text : texts) words += " " + Quoted(text);
  return words;
}

// The default as help texts say it, "the scene's, or 64"; empty where there is none to say.
std::string DefaultText(const OptionInfo& info);

// The help of an option with its default and, where not all integrators know it, their names.
std::string Explanation(const OptionInfo& info);

// The names of the integrators that an option applies to.
std::vector<std::string> IntegratorsOf(const OptionInfo& info);

}  // namespace skywave
