// The program: reads the command line, calls the command and turns failures into exit codes.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <exception>
#include <map>
#include <memory>
#include <new>
#include <string>
#include <string_view>
#include <vector>

#include "aberfit/commands/program.h"
#include "aberfit/commands/terminal_text.h"
#include "aberfit/core/errors.h"
#include "aberfit/core/memory.h"
#include "aberfit/core/text.h"
#include "command_line.h"
#include "manual.h"

namespace {

using aberfit::ExitCode;

// Reports an unknown word in place of a command; the parser would only say that a command is missing.
void require_known_command(const CLI::App& app, int argc, char** argv) {
  if (argc < 2 || argv[1][0] == '-') return;
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; })) {
    if (command->get_name() == argv[1]) return;
    if (!command->get_group().empty()) names.push_back(command->get_name());
  }
  const std::vector<std::string> near = aberfit::near_words(argv[1], names);
  const std::vector<std::string> kinds = aberfit::starter_kinds();
  const bool is_kind = std::find(kinds.begin(), kinds.end(), argv[1]) != kinds.end();
  const std::string meant = is_kind                               ? fmt::format("new {}", argv[1])
                            : std::string_view(argv[1]) == "help" ? "--help"
                                                                  : aberfit::command_for(argv[1]);
  const std::string guess = !meant.empty()  ? fmt::format("`aberfit {}`, or another of ", meant)
                            : !near.empty() ? fmt::format("did you mean \"{}\"? one of ", near.front())
                                            : "";
  throw aberfit::InputError("command line", "", fmt::format("the command \"{}\"", argv[1]),
                            guess + fmt::format("{}", fmt::join(names, ", ")));
}

// Quotes the text for a shell if necessary.
std::string in_shell(const std::string& text) {
  const bool plain = !text.empty() && text.find_first_of(" \t\n\"'\\$`*?[]{}()<>|&;!#~") == text.npos;
  return plain ? text : aberfit::internal::shell_text(text);
}

// Suggests options for a misspelt one, which CLI11 only calls unexpected.
void guess_options(const CLI::App& app, int argc, char** argv) {
  std::vector<std::string> names;
  for (const CLI::App* of : app.get_subcommands())
    for (const CLI::Option* option : of->get_options())
      for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  for (const CLI::Option* option : app.get_options())
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  for (int i = 1; i < argc; ++i) {
    const std::string typed = std::string(argv[i]).substr(0, std::string_view(argv[i]).find('='));
    if (!typed.starts_with("--") || std::find(names.begin(), names.end(), typed) != names.end()) continue;
    if (const std::vector<std::string> near = aberfit::near_words(typed, names); !near.empty())
      fmt::print(stderr, "{}: did you mean {}?\n", typed, near.front());
  }
}

int print_manual(const CLI::App& app, const std::string& form) {
  using namespace aberfit::internal;
  fmt::print("{}", form == "man"    ? man_page(app)
                   : form == "bash" ? bash_completion(app)
                                    : fish_completion(app));
  return int(ExitCode::kDone);
}

int run(int argc, char** argv) {
  CLI::App app(
      "Equivalent aberration terms of rough mirrors: finds a surface of Zernike, Fourier and spherical terms "
      "whose focus is statistically equivalent to the Harvey-Shack scatter of a roughness specification.",
      "aberfit");
  app.formatter(std::make_shared<aberfit::internal::HelpFormatter>());
  aberfit::internal::TypedCommand typed;
  describe_commands(&app, &typed);
  typed.line.typed = "aberfit";
  for (int k = 1; k < argc; ++k) typed.line.typed += " " + in_shell(argv[k]);
  require_known_command(app, argc, argv);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (app.exit(error) == 0) return int(ExitCode::kDone);  // --help and --version come here, too
    guess_options(app, argc, argv);
    return int(ExitCode::kBadInput);
  }
  take_psd_options(&typed);
  const aberfit::CommandLine& line = typed.line;
  const std::string command = app.get_subcommands().front()->get_name();
  if (command == "manual") return print_manual(app, typed.manual_form);
  if (!line.study_file.empty()) aberfit::require_right_file(line.study_file, command);
  for (const std::string& file : line.measured_files) aberfit::require_right_file(file, "psd");
  static const std::map<std::string, ExitCode (*)(aberfit::CommandLine)> kCommands = {
      {"fit", aberfit::fit_command},       {"verify", aberfit::verify_command},
      {"trace", aberfit::trace_command},   {"psd", aberfit::psd_command},
      {"chart", aberfit::chart_command},   {"check", aberfit::check_command},
      {"solve", aberfit::solve_command},   {"sweep", aberfit::sweep_command},
      {"report", aberfit::report_command}, {"new", aberfit::new_command},
      {"schema", aberfit::schema_command}, {"serve", aberfit::serve_command}};
  return int(kCommands.at(command)(line));
}

int fail(ExitCode code, const std::string& message) {
  fmt::print(stderr, "{} {}\n", aberfit::toned("aberfit:", aberfit::Tone::kBad, stderr), message);
  return int(code);
}

}  // namespace

int main(int argc, char** argv) {
  aberfit::keep_freed_memory();
  try {
    return run(argc, argv);
  } catch (const aberfit::InputError& error) {
    return fail(ExitCode::kBadInput, error.what());
  } catch (const aberfit::FieldError& error) {  // commands add the file; the field alone still helps
    return fail(ExitCode::kBadInput, error.what());
  } catch (const aberfit::Interrupted& error) {
    return fail(ExitCode::kInterrupted, fmt::format("{}; nothing is written", error.what()));
  } catch (const std::bad_alloc&) {
    return fail(
        ExitCode::kComputationFailed,
        "the computation failed: not enough memory; fewer terms or rays, or a larger margin, need less");
  } catch (const std::exception& error) {
    return fail(ExitCode::kComputationFailed, fmt::format("the computation failed: {}", error.what()));
  }
}
