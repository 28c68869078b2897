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

Answer made_answer(StudyCommand command, const SharedStudy& study, const RunOptions& options) {
  switch (command) {
    case StudyCommand::kFit:
      return study->map ? answer_map_fit(study, options) : answer_fit(study, options);
    case StudyCommand::kCheck:
      return answer_check(study, options);
    case StudyCommand::kVerify:
      return answer_verify(study, options);
    case StudyCommand::kTrace:
      return answer_trace(study, options);
    case StudyCommand::kPsd:
      return answer_psd(measured_psd_of(*study), study->title, options, study.get());
    case StudyCommand::kSolve:
      return answer_solve(study, options);
    case StudyCommand::kChart:
      return answer_chart(study, options);
  }
  return {};
}

// These commands by themselves write arrays, and nothing without any.
bool writes_arrays_alone(StudyCommand command) {
  return command == StudyCommand::kCheck || command == StudyCommand::kTrace;
}

}  // namespace

Answer answer(StudyCommand command, const Study& given, const RunOptions& options) {
  const auto study = std::make_shared<const Study>(completed(given));
  RunOptions how = options;
  how.measure_iteration = command == StudyCommand::kCheck;
  Answer made = made_answer(command, study, how);
  made.asked = [study] { return typed_study(*study); };
  if (writes_arrays_alone(command) && !options.output_directory.empty() &&
      wanted_arrays(*study, options) == ArrayFormat::kNone)
    made.save(options);
  return made;
}

namespace internal {

ExitCode show(const CommandLine& line, const Answer& answer, bool has_files) {
  print(line, answer.document, answer.page);
  if (has_files) say_where(line);
  return answer.code;
}

ExitCode study_command(CommandLine line, StudyCommand command) {
  const std::string& name = study_command_names()[std::size_t(command)];
  const HardLimit limit(line.time_limit);
  const Study study = read_study(line.study_file, line.changes);
  ProgressLine progress(!line.quiet);
  RunOptions options = run_options(line, &progress);
  bool has_files = true;
  if (writes_arrays_alone(command)) {
    has_files = wanted_arrays(study, options) != ArrayFormat::kNone;
    choose_arrays_directory(study, options, name, &line);
  } else {
    choose_output_directory(&line, name);
  }
  if (has_files) options.output_directory = line.output_directory;
  const Answer found = answer(command, study, options);
  progress.clear();
  return show(line, found, has_files);
}

}  // namespace internal
}  // namespace aberfit
