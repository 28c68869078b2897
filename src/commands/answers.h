#pragma once
#include <memory>
#include <nlohmann/json.hpp>

#include "aberfit/commands/answer.h"
#include "aberfit/report/documents.h"
#include "aberfit/report/result_folder.h"
#include "aberfit/study/read_study.h"
#include "result_files.h"

namespace aberfit::internal {

using SharedStudy = std::shared_ptr<const Study>;

// The commands of a completed study, one in each file. See `answer`.
Answer answer_fit(const SharedStudy& study, const RunOptions& options);
Answer answer_map_fit(const SharedStudy& study, const RunOptions& options);
Answer answer_check(const SharedStudy& study, const RunOptions& options);
Answer answer_verify(const SharedStudy& study, const RunOptions& options);
Answer answer_trace(const SharedStudy& study, const RunOptions& options);
Answer answer_solve(const SharedStudy& study, const RunOptions& options);
Answer answer_chart(const SharedStudy& study, const RunOptions& options);

/// An answer whose document and files are made from the report when they are asked for. claim: the files;
/// write: puts them into a folder.
template <typename Report>
Answer answer_of(const Report& report, ExitCode code, const SharedStudy& study, const RunOptions& options,
                 ResultClaim (*claim)(const Study&, const RunOptions&),
                 void (*write)(const Study&, const RunOptions&, ResultFolder*, Report*)) {
  Answer answer{code, page_of(report)};
  RunOptions how;
  how.threads = options.threads;
  answer.document = [=] { return to_json(report, resolved_study(*study), provenance_of(*study, how)); };
  answer.save = [=](const RunOptions& there) {
    ResultFolder folder(there.output_directory, claim(*study, there));
    Report written = report;
    write(*study, there, &folder, &written);
  };
  return answer;
}

/// The exit code of a fit of statistics or of a map.
ExitCode code_of_fit(const ResultDocument& result);
/// Prints the answer as the command line wants it, says where its files are, and returns its exit code.
ExitCode show(const CommandLine& line, const Answer& answer, bool has_files);
/// The program's command of a study that answers all at once or not at all.
ExitCode study_command(CommandLine line, StudyCommand command);

}  // namespace aberfit::internal
