// Turns the description of the command line (command_line.cpp) into help, manual page and completions of
// shells.
#include "manual.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <vector>

#include "aberfit/commands/terminal_text.h"
#include "aberfit/core/text.h"

namespace aberfit::internal {
namespace {

// An option or argument as the texts show it.
struct Shown {
  std::vector<std::string> names;  // "-o", "--output"; "STUDY" for an argument
  std::string value;               // "DIR"; empty: a flag
  std::vector<std::string> words;  // allowed values, if there is a list
  std::string meaning;
  bool is_argument, is_required, is_repeated;

  std::string head() const {
    return fmt::format("{}{}{}", fmt::join(names, ", "), is_argument || value.empty() ? "" : " ",
                       is_argument ? "" : value);
  }
};

// CLI11 writes the allowed values behind the name of the value: "FORMAT:{npz,csv,none}".
Shown shown(const CLI::Option& option) {
  Shown result;
  for (const std::string& name : option.get_snames()) result.names.push_back("-" + name);
  for (const std::string& name : option.get_lnames()) result.names.push_back("--" + name);
  result.is_argument = result.names.empty();
  if (result.is_argument) result.names.push_back(option.get_name(true));
  const std::string type = option.get_type_size_max() > 0 ? option.get_type_name() : "";
  result.value = type.substr(0, type.find(':'));
  const std::size_t open = type.find('{');
  const std::string list = open == std::string::npos ? "" : type.substr(open + 1, type.find('}') - open - 1);
  for (const std::string_view word : words(list, ", ")) result.words.emplace_back(word);
  result.meaning = option.get_description();
  result.is_required = option.get_required();
  result.is_repeated = option.get_items_expected_max() > 1;
  return result;
}

std::vector<Shown> options_of(const CLI::App& app) {
  std::vector<Shown> all;
  for (const CLI::Option* option : app.get_options()) all.push_back(shown(*option));
  return all;
}

std::vector<const CLI::App*> commands_of(const CLI::App& app) {
  return app.get_subcommands([](const CLI::App* command) { return !command->get_group().empty(); });
}

std::string usage_of(const CLI::App& app) {
  std::string text = app.get_parent() ? "aberfit " + app.get_name() : "aberfit";
  if (!app.get_parent()) return text + " COMMAND [OPTIONS]";
  text += " [OPTIONS]";
  for (const Shown& one : options_of(app))
    if (one.is_argument)
      text += fmt::format(fmt::runtime(one.is_required ? " {}{}" : " [{}{}]"), one.names.front(),
                          one.is_repeated ? "..." : "");
  return text;
}

// A footer has paragraphs, whose lines are joined, and lines that begin with blanks, which stay as they are.
std::vector<std::string> lines_of(const std::string& footer) {
  std::vector<std::string> lines;
  std::size_t begin = 0;
  while (begin <= footer.size()) {
    const std::size_t end = std::min(footer.find('\n', begin), footer.size());
    lines.push_back(footer.substr(begin, end - begin));
    begin = end + 1;
  }
  return lines;
}

std::string heading(const std::string& text) { return "\n" + toned(text, Tone::kStrong, stdout) + "\n"; }

// Puts heads in one column and meanings in the other. A head that is too long has its own line.
std::string two_columns(const std::vector<std::pair<std::string, std::string>>& rows, int width) {
  constexpr std::size_t kWidest = 22;
  std::string text;
  for (const auto& [head, meaning] : rows) {
    text += "  " + head;
    text += head.size() > kWidest ? "\n" + std::string(kWidest + 4, ' ')
                                  : std::string(kWidest + 2 - head.size(), ' ');
    text +=
        wrapped(std::string(kWidest + 4, '.') + " " + meaning, width, int(kWidest) + 4).substr(kWidest + 5) +
        "\n";
  }
  return text;
}

std::string options_text(const CLI::App& app, bool arguments, int width) {
  std::vector<std::pair<std::string, std::string>> rows;
  for (const Shown& one : options_of(app))
    if (one.is_argument == arguments) rows.emplace_back(one.head(), one.meaning);
  return rows.empty() ? "" : heading(arguments ? "Arguments" : "Options") + two_columns(rows, width);
}

// roff gives a meaning to a backslash, and to a dot or an apostrophe at the start of a line.
std::string roff(const std::string& text) {
  std::string result;
  bool quoted = false;
  for (const char c : text) {
    if (c == '`')
      result += (quoted = !quoted) ? "\\fB" : "\\fR";
    else if (c == '\\' || c == '-')
      result += c == '-' ? "\\-" : "\\e";
    else
      result += c;
  }
  return result.starts_with('.') || result.starts_with('\'') ? "\\&" + result : result;
}

std::string roff_options(const CLI::App& app) {
  std::string text;
  for (const Shown& one : options_of(app))
    text += fmt::format(".TP\n.B {}\n{}\n", roff(one.head()), roff(one.meaning));
  return text;
}

std::string roff_footer(const CLI::App& app) {
  std::string text;
  bool verbatim = false;
  for (const std::string& line : lines_of(app.get_footer())) {
    const bool kept = line.starts_with("  ");
    if (kept != verbatim) text += kept ? ".RS\n.nf\n" : ".fi\n.RE\n";
    verbatim = kept;
    text += line.empty() ? ".PP\n" : roff(kept ? line.substr(2) : line) + "\n";
  }
  return text + (verbatim ? ".fi\n.RE\n" : "");
}

std::vector<std::string> names_in(const CLI::App& app) {
  std::vector<std::string> names;
  for (const Shown& one : options_of(app))
    if (!one.is_argument) names.insert(names.end(), one.names.begin(), one.names.end());
  return names;
}

}  // namespace

std::string shell_text(const std::string& text) {
  std::string result = "'";
  for (const char c : text) result += c == '\'' ? "'\\''" : std::string(1, c);
  return result + "'";
}

std::string help_text(const CLI::App& app, int width) {
  std::string text =
      wrapped(app.get_description(), width) + "\n" + heading("Usage") + "  " + usage_of(app) + "\n";
  std::vector<std::pair<std::string, std::string>> rows;
  for (const CLI::App* command : commands_of(app))
    rows.emplace_back(command->get_name(), command->get_description());
  if (!rows.empty())
    text += heading("Commands") + two_columns(rows, width) +
            wrapped("`aberfit COMMAND --help` explains a command with examples.", width) + "\n";
  text += options_text(app, true, width) + options_text(app, false, width);
  if (app.get_parent())
    text += "  " +
            wrapped("Options of every command: --threads N, --json, --quiet; see `aberfit --help`.",
                    width - 2, 2) +
            "\n";
  text += "\n";
  for (const std::string& line : lines_of(app.get_footer()))
    text += (line.starts_with("  ") ? line : wrapped(line, width)) + "\n";
  return text;
}

std::string HelpFormatter::make_help(const CLI::App* app, std::string, CLI::AppFormatMode) const {
  return help_text(*app, text_width());
}

std::string man_page(const CLI::App& app) {
  std::string text = fmt::format(
      ".TH ABERFIT 1 \"\" \"aberfit {}\" \"User Commands\"\n.SH NAME\naberfit \\- equivalent aberration "
      "terms of "
      "rough mirrors\n.SH SYNOPSIS\n",
      ABERFIT_VERSION);
  for (const CLI::App* command : commands_of(app))
    text += fmt::format(".B {}\n.br\n", roff(usage_of(*command)));
  text += fmt::format(".SH DESCRIPTION\n{}\n.SH OPTIONS OF EVERY COMMAND\n{}.SH COMMANDS\n",
                      roff(app.get_description()), roff_options(app));
  for (const CLI::App* command : commands_of(app))
    text += fmt::format(".SS {}\n{}.\n{}.PP\n{}", roff("aberfit " + command->get_name()),
                        roff(command->get_description()), roff_options(*command), roff_footer(*command));
  return text + ".SH EXIT STATUS AND ENVIRONMENT\n" + roff_footer(app);
}

std::string bash_completion(const CLI::App& app) {
  std::string options, arguments, values, names;
  for (const CLI::App* command : commands_of(app)) {
    names += (names.empty() ? "" : " ") + command->get_name();
    options +=
        fmt::format("    {}) options='{}' ;;\n", command->get_name(), fmt::join(names_in(*command), " "));
    for (const Shown& one : options_of(*command)) {
      if (one.words.empty()) continue;
      const std::string list = fmt::format("words='{}'", fmt::join(one.words, " "));
      if (one.is_argument)
        arguments +=
            fmt::format("    {}) [ \"$previous\" = \"$command\" ] && {} ;;\n", command->get_name(), list);
      else
        values += fmt::format("    {}) {} ;;\n", fmt::join(one.names, "|"), list);
    }
  }
  return fmt::format(
      "# Completion of aberfit for bash, made from the description of its command line.\n"
      "_aberfit() {{\n"
      "  local current=${{COMP_WORDS[COMP_CWORD]}} previous=${{COMP_WORDS[COMP_CWORD-1]}} word command=\n"
      "  local options= words= common='{}'\n"
      "  for word in \"${{COMP_WORDS[@]:1:COMP_CWORD-1}}\"; do\n"
      "    case $word in {}) command=$word; break ;; esac\n"
      "  done\n"
      "  case $command in\n"
      "    '') words='{}' ;;\n{}  esac\n"
      "  case $previous in\n{}  esac\n"
      "  case $command in\n{}  esac\n"
      "  [[ $current == -* ]] && words=\"$options $common\"\n"
      "  if [ -n \"$words\" ]; then COMPREPLY=($(compgen -W \"$words\" -- \"$current\"))\n"
      "  else compopt -o filenames; mapfile -t COMPREPLY < <(compgen -f -- \"$current\"); fi\n"
      "}}\n"
      "complete -F _aberfit aberfit\n",
      fmt::join(names_in(app), " "), fmt::join(words(names), "|"), names, options, values, arguments);
}

std::string fish_completion(const CLI::App& app) {
  std::string text = "# Completion of aberfit for fish, made from the description of its command line.\n";
  const auto add = [&](const std::string& condition, const CLI::App& of) {
    for (const Shown& one : options_of(of)) {
      std::string line = fmt::format("complete -c aberfit{}", condition);
      if (one.is_argument && one.words.empty()) continue;
      if (!one.is_argument)
        for (const std::string& name : one.names)
          line += name.starts_with("--") ? " -l " + name.substr(2) : " -s " + name.substr(1);
      if (!one.words.empty())
        line += fmt::format(" -x -a {}", shell_text(fmt::format("{}", fmt::join(one.words, " "))));
      else if (!one.value.empty())
        line += " -r";
      text += line + " -d " + shell_text(one.meaning) + "\n";
    }
  };
  add("", app);
  for (const CLI::App* command : commands_of(app)) {
    text += fmt::format("complete -c aberfit -n __fish_use_subcommand -a {} -d {}\n", command->get_name(),
                        shell_text(command->get_description()));
    add(" -n '__fish_seen_subcommand_from " + command->get_name() + "'", *command);
  }
  return text;
}

}  // namespace aberfit::internal
