#pragma once
#include <string>
#include <vector>

#include "aberfit/commands/program.h"
#include "aberfit/commands/run_options.h"
#include "aberfit/report/drawn_picture.h"
#include "aberfit/report/result_folder.h"
#include "aberfit/study/study.h"

namespace aberfit::internal {

/// Returns out/<study>/<command>, a folder for each command. <study> is the name of the study's folder if the
/// file has the usual name study.json, otherwise the file's name without its ending; "study" for standard
/// input.
std::string default_output_directory(const std::string& study_file, const std::string& command);

/// Sets the folder if the command line names none.
void choose_output_directory(CommandLine* line, const std::string& command);

/// The files that a command claims in its folder: summary.txt, result.json, report.html and `files`. With
/// pictures it also claims all files below plots whose names begin with one of `names`.
ResultClaim claim_of(const std::string& command, const RunOptions& options, std::vector<std::string> files,
                     const PictureOptions& pictures = {PictureFormat::kNone},
                     const std::vector<std::string>& names = {});

/// The picture options of the command line, otherwise those of the study, if there is one.
PictureOptions wanted_pictures(const RunOptions& options, const Study* study = nullptr);
/// The format of this name. Precondition: the name is one of picture_format_names.
PictureFormat picture_format(const std::string& word);

}  // namespace aberfit::internal
