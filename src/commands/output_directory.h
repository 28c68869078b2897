#pragma once
#include <string>
#include <vector>

#include "aberfit/commands/program.h"
#include "aberfit/commands/run_options.h"
#include "aberfit/report/drawn_picture.h"
#include "aberfit/report/result_folder.h"
#include "aberfit/study/study.h"

namespace aberfit::internal {

/// out/<study>/<command>, a folder for each command. <study> is the folder of the study when the file has the
/// usual name study.json, else the name of the file without its ending; "study" for standard input.
std::string default_output_directory(const std::string& study_file, const std::string& command);

/// Sets the folder where none is named.
void choose_output_directory(CommandLine* line, const std::string& command);

/// What a command claims in its folder: summary.txt, result.json and report.html, `files`,
/// and where pictures are drawn all below plots whose names
/// begin as one of `names`.
ResultClaim claim_of(const std::string& command, const RunOptions& options, std::vector<std::string> files,
                     const PictureOptions& pictures = {PictureFormat::kNone},
                     const std::vector<std::string>& names = {});

/// What the command line says of pictures, else the study, where there is one.
PictureOptions wanted_pictures(const RunOptions& options, const Study* study = nullptr);
/// Of its word, which has to be one of picture_format_names.
PictureFormat picture_format(const std::string& word);

}  // namespace aberfit::internal
