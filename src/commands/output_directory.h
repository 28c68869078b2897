#pragma once
#include <string>

#include "aberfit/commands/program.h"

namespace aberfit::internal {

/// out/<folder of the study> when the file has the usual name study.json, else out/<name of the file>;
/// out/study for standard input.
std::string default_output_directory(const std::string& study_file);
/// Beside out/<study>, where the fit's result is.
std::string default_chart_directory(const std::string& study_file);

/// Sets the folder where none is named; suffix: of what stands beside the fit's result.
void choose_output_directory(CommandLine* line, const std::string& suffix = "");

}  // namespace aberfit::internal
