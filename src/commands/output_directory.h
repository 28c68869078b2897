#pragma once
#include <string>
#include <vector>

#include "aberfit/commands/program.h"
#include "aberfit/commands/run_options.h"
#include "aberfit/report/result_folder.h"

namespace aberfit::internal {

/// out/<study>/<command>, a folder for each command. <study> is the folder of the study when the file has the
/// usual name study.json, else the name of the file without its ending; "study" for standard input.
std::string default_output_directory(const std::string& study_file, const std::string& command);

/// Sets the folder where none is named.
void choose_output_directory(CommandLine* line, const std::string& command);

/// What a command claims in its folder: `files`, and where pictures are drawn all below plots whose names
/// begin as one of `pictures`.
ResultClaim claim_of(const std::string& command, const RunOptions& options, std::vector<std::string> files,
                     bool plots = false, const std::vector<std::string>& pictures = {});

}  // namespace aberfit::internal
