#pragma once
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "aberfit/commands/program.h"
#include "aberfit/commands/run.h"
#include "aberfit/report/arrays.h"
#include "aberfit/report/page.h"

// The commands for callers that pass results on: the program, the Python module and `serve`. They all get the
// same document.
namespace aberfit {

/// A result in the forms in which it is handed on.
struct Answer {
  ExitCode code = ExitCode::kDone;
  Page page;  ///< the result for people
  /// Makes the content of result.json. Its provenance reads every input file.
  std::function<nlohmann::ordered_json()> document = {};
  /// Makes the light of theory and surface and gives it to `see`. Empty for commands without a surface or
  /// theory to show. Throws ComputationError if there is none. It keeps the pupil of the fit in memory.
  std::function<void(const std::function<void(const ArrayInput& focus)>& see)> focus = {};
  /// Writes the files that the command writes to a folder, pictures included. Throws InputError like the
  /// commands do if something is in the way. Empty if the command failed.
  std::function<void(const RunOptions& options)> save = {};
  std::function<nlohmann::ordered_json()> asked = {};  ///< makes the study as typed, with its units
};

enum class StudyCommand { kFit, kCheck, kVerify, kTrace, kPsd, kSolve, kChart };
/// Returns "fit", "check" and so on, in the order of StudyCommand.
const std::vector<std::string>& study_command_names();

/// Runs a command on a study. Files are written if, and only if, options.output_directory names a folder. A
/// check makes one iteration. Throws as the functions of commands/run.h do.
Answer answer(StudyCommand command, const Study& study, const RunOptions& options);
/// The same for a measurement. study: as for run_psd.
Answer answer_psd(const MeasuredPsd& measured, const std::string& title, const RunOptions& options,
                  const Study* study = nullptr);

}  // namespace aberfit
