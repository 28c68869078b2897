#include "aberfit/chart/chart.h"

#include "aberfit/commands/run.h"
#include "aberfit/core/errors.h"
#include "aberfit/fit/calibrate.h"
#include "aberfit/report/chart.h"
#include "aberfit/report/documents.h"
#include "aberfit/report/result_folder.h"
#include "aberfit/study/field_errors.h"
#include "aberfit/study/read_study.h"
#include "interrupt.h"
#include "output_directory.h"
#include "result_files.h"
#include "terminal.h"

namespace aberfit {
using namespace internal;

Chart run_chart(const Study& given, const RunOptions& options) {
  const Study study = completed(given);
  if (study.map)
    throw InputError(study.path, "/target/map", "a study of a map",
                     "statistics as targets (a map is fitted by linear least squares, which is exact)");
  ResultFolder folder(options.output_directory, claim_of("chart", options, {"chart.csv"},
                                                         wanted_pictures(options, &study), {"chart_"}));
  Chart chart =
      with_fields_of(study, [&] { return make_chart(study, options.chart_seconds, context_of(options)); });
  chart.title = study.title;
  if (folder.wanted()) {
    if (options.progress) options.progress("chart: files");
    const std::string to = folder.path();
    auto drawn = draw_pictures(chart, to, wanted_pictures(options, &study), &chart.warnings);
    write_file(to + "/chart.csv", chart_csv(chart));
    write_result(to, options,
                 {page_of(chart), to_json(chart, resolved_study(study), provenance_of(study, options)),
                  typed_study(study), std::move(drawn)});
    folder.show();
  }
  return chart;
}

ExitCode chart_command(CommandLine line) {
  const HardLimit limit(line.time_limit);
  const Study study = read_study(line.study_file, line.changes);
  choose_output_directory(&line, "chart");
  ProgressLine progress(!line.quiet);
  const RunOptions options = run_options(line, &progress);
  const Chart chart = run_chart(study, options);
  progress.clear();
  print(
      line, [&] { return to_json(chart, resolved_study(study), provenance_of(study, options)); },
      page_of(chart));
  say_where(line);
  return ExitCode::kDone;
}

}  // namespace aberfit
