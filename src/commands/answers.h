#pragma once
#include <nlohmann/json.hpp>

#include "aberfit/commands/answer.h"

namespace aberfit::internal {

// The commands of a study, one in each file. See `answer`.
Answer answer_fit(const Study& study, const RunOptions& options);
Answer answer_map_fit(const Study& study, const RunOptions& options);
Answer answer_check(const Study& study, const RunOptions& options);
Answer answer_verify(const Study& study, const RunOptions& options);
Answer answer_trace(const Study& study, const RunOptions& options);
Answer answer_solve(const Study& study, const RunOptions& options);
Answer answer_chart(const Study& study, const RunOptions& options);

/// An answer of these parts.
Answer make_answer(ExitCode code, nlohmann::ordered_json document, Page page,
                   std::function<FocusArrays()> arrays = {},
                   std::function<void(const RunOptions&)> save = {});
/// The exit code of a fit of statistics or of a map.
ExitCode code_of_fit(const ResultDocument& result);
/// Prints the answer as the command line wants it, says where its files are, and returns its exit code.
ExitCode show(const CommandLine& line, const Answer& answer, bool has_files);
/// The program's command of a study that answers all at once or not at all.
ExitCode study_command(CommandLine line, StudyCommand command);

}  // namespace aberfit::internal
