#include "aberfit/commands/answer.h"

#include "aberfit/study/read_study.h"
#include "answers.h"
#include "array_files.h"
#include "interrupt.h"
#include "output_directory.h"
#include "result_files.h"
#include "terminal.h"

namespace aberfit {
using namespace internal;

const std::vector<std::string>& study_command_names() {
  static const std::vector<std::string> kNames = {"fit", "check", "verify", "trace", "psd", "solve", "chart"};
  return kNames;
}

namespace {

Answer made_answer(StudyCommand command, const Study& study, const RunOptions& options) {
  switch (command) {
    case StudyCommand::kFit:
      return study.map ? answer_map_fit(study, options) : answer_fit(study, options);
    case StudyCommand::kCheck:
      return answer_check(study, options);
    case StudyCommand::kVerify:
      return answer_verify(study, options);
    case StudyCommand::kTrace:
      return answer_trace(study, options);
    case StudyCommand::kPsd:
      return answer_psd(measured_psd_of(study), study.title, options, &study);
    case StudyCommand::kSolve:
      return answer_solve(study, options);
    case StudyCommand::kChart:
      return answer_chart(study, options);
  }
  return {};
}

}  // namespace

Answer answer(StudyCommand command, const Study& study, const RunOptions& options) {
  Answer made = made_answer(command, study, options);
  made.asked = std::make_shared<const nlohmann::ordered_json>(typed_study(study));
  return made;
}

namespace internal {

Answer make_answer(ExitCode code, nlohmann::ordered_json document, Page page,
                   std::function<FocusArrays()> arrays, std::function<void(const RunOptions&)> save) {
  return {code, std::make_shared<const nlohmann::ordered_json>(std::move(document)), std::move(page),
          std::move(arrays), std::move(save)};
}

ExitCode show(const CommandLine& line, const Answer& answer, bool has_files) {
  print(line, *answer.document, answer.page);
  if (has_files) say_where(line);
  return answer.code;
}

ExitCode study_command(CommandLine line, StudyCommand command) {
  const std::string& name = study_command_names()[std::size_t(command)];
  const HardLimit limit(line.time_limit);
  const Study study = read_study(line.study_file, line.changes);
  ProgressLine progress(!line.quiet);
  RunOptions options = run_options(line, &progress);
  options.measure_iteration = command == StudyCommand::kCheck;
  bool has_files = true;
  if (command == StudyCommand::kCheck || command == StudyCommand::kTrace) {
    has_files = wanted_arrays(study, options) != ArrayFormat::kNone;
    choose_arrays_directory(study, options, name, &line);
  } else {
    choose_output_directory(&line, name);
  }
  options.output_directory = line.output_directory;
  const Answer found = answer(command, study, options);
  progress.clear();
  return show(line, found, has_files);
}

}  // namespace internal
}  // namespace aberfit
