#pragma once
#include <CLI/CLI.hpp>
#include <map>
#include <string>

#include "aberfit/commands/program.h"

namespace aberfit::internal {

/// The command line, and the typed options that it does not hold yet.
struct TypedCommand {
  CommandLine line;
  std::map<std::string, std::string> psd_texts;  ///< options of `psd FILE` by their key of the study format
  std::string manual_form;                       ///< `manual`: man, bash or fish
};

/// Gives the app every command and option of the program; parsing fills `typed`, which must outlive it.
void describe_commands(CLI::App* app, TypedCommand* typed);
/// Moves the options of `psd` into the command line, after parsing.
void take_psd_options(TypedCommand* typed);

}  // namespace aberfit::internal
