#include "aberfit/chart/chart.h"

#include "aberfit/commands/run.h"
#include "aberfit/core/errors.h"
#include "aberfit/fit/calibrate.h"
#include "aberfit/report/chart.h"
#include "aberfit/report/result_folder.h"
#include "aberfit/study/field_errors.h"
#include "aberfit/study/read_study.h"
#include "output_directory.h"
#include "terminal.h"

namespace aberfit {
using namespace internal;

namespace {

nlohmann::ordered_json chart_json(const Chart& chart, const Study& study) {
  Provenance provenance = make_provenance(study.fit.seed, chart.threads);
  provenance.libraries["ceres"] = solver_version();
  return to_json(chart, resolved_study(study), provenance);
}

}  // namespace

Chart run_chart(const Study& given, const RunOptions& options) {
  const Study study = completed(given);
  if (study.map)
    throw InputError(study.path, "/target/map", "a study of a map",
                     "statistics as targets: a map is fitted by linear least squares, which is exact");
  ResultFolder folder(options.output_directory,
                      claim_of("chart", options, {"chart.csv", "summary.txt", "chart.json"},
                               options.plots && study.output.plots, {"chart_"}));
  Chart chart =
      with_fields_of(study, [&] { return make_chart(study, options.chart_seconds, context_of(options)); });
  chart.title = study.title;
  if (folder.wanted()) {
    if (options.progress) options.progress("chart: files");
    const std::string to = folder.path();
    if (options.plots && study.output.plots) write_chart_plots(chart, to, &chart.warnings);
    write_file(to + "/chart.csv", chart_csv(chart));
    write_file(to + "/summary.txt", summary_table(chart));
    write_file(to + "/chart.json", chart_json(chart, study).dump(2) + "\n");
    folder.show();
  }
  return chart;
}

ExitCode chart_command(CommandLine line) {
  const Study study = read_study(line.study_file, line.changes);
  choose_output_directory(&line, "chart");
  ProgressLine progress(!line.quiet);
  const Chart chart = run_chart(study, run_options(line, &progress));
  progress.clear();
  print(line, chart_json(chart, study), summary_table(chart));
  say_where(line);
  return ExitCode::kDone;
}

}  // namespace aberfit
