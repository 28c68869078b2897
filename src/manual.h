#pragma once
#include <CLI/CLI.hpp>
#include <string>

namespace aberfit::internal {

/// The text that --help prints for the app or one of its commands, in lines of `width` characters.
std::string help_text(const CLI::App& app, int width);
/// All commands as a manual page (man), and as completions for the shells bash and fish.
std::string man_page(const CLI::App& app);
std::string bash_completion(const CLI::App& app);
std::string fish_completion(const CLI::App& app);

/// The text in single quotes for a shell.
std::string shell_text(const std::string& text);

/// Makes CLI11 print help_text.
class HelpFormatter : public CLI::FormatterBase {
 public:
  std::string make_help(const CLI::App* app, std::string name, CLI::AppFormatMode mode) const override;
};

}  // namespace aberfit::internal
