#pragma once
#include <functional>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

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
  std::shared_ptr<const nlohmann::ordered_json> document;  ///< content of result.json
  Page page;                                               ///< the result for people
  /// Computes the focus as numbers. Empty for commands without a surface or theory to show. Throws
  /// ComputationError if the arrays cannot be made. It keeps the pupil of the fit in memory.
  std::function<FocusArrays()> arrays = {};
  /// Writes the files that the command writes to a folder, pictures included. Throws InputError like the
  /// commands do if something is in the way. Empty if the command failed, and for a sweep.
  std::function<void(const RunOptions& options)> save = {};
  std::shared_ptr<const nlohmann::ordered_json> asked = {};  ///< the study as typed, with its units
};

enum class StudyCommand { kFit, kCheck, kVerify, kTrace, kPsd, kSolve, kChart };
/// Returns "fit", "check" and so on, in the order of StudyCommand.
const std::vector<std::string>& study_command_names();

/// Runs a command on a study. Files are written only if options.output_directory names a folder. Throws as
/// the functions of commands/run.h do.
Answer answer(StudyCommand command, const Study& study, const RunOptions& options);
/// The same for a measurement. study: as for run_psd.
Answer answer_psd(const MeasuredPsd& measured, const std::string& title, const RunOptions& options,
                  const Study* study = nullptr);
/// The same for a sweep; nothing for ranks of MPI except the first.
std::optional<Answer> answer_sweep(const StudyCases& cases, const RunOptions& options,
                                   const SweepOptions& sweep);

}  // namespace aberfit
