#pragma once
#include <CLI/CLI.hpp>
#include <map>
#include <string>

#include "aberfit/commands/program.h"

namespace aberfit::internal {

/// What was typed, as far as it is not in CommandLine yet.
struct TypedCommand {
  CommandLine line;
  std::map<std::string, std::string> psd_texts;  ///< options of `psd FILE` by their key of the study format
  std::string manual_form;                       ///< `manual`: man, bash or fish
};

/// Gives the app every command and option of the program; parsing fills `typed`, which must outlive it.
void describe_commands(CLI::App* app, TypedCommand* typed);
/// After parsing: the options of `psd` into the command line.
void take_psd_options(TypedCommand* typed);

}  // namespace aberfit::internal
