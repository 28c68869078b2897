#pragma once
#include <optional>
#include <string>

#include "aberfit/chart/chart.h"
#include "aberfit/chart/check.h"
#include "aberfit/commands/run_options.h"
#include "aberfit/method/run_context.h"
#include "aberfit/method/trace_surface.h"
#include "aberfit/method/verify.h"
#include "aberfit/report/psd_report.h"
#include "aberfit/report/result.h"
#include "aberfit/report/sweep_report.h"
#include "aberfit/specify/ceilings.h"
#include "aberfit/specify/psd_of_focus.h"
#include "aberfit/specify/solve.h"
#include "aberfit/study/study.h"
#include "aberfit/study/study_cases.h"

// The commands as functions. Each returns its result as a struct, which the headers of report turn into JSON,
// tables and pictures. Files are written only if options.output_directory names a folder.
namespace aberfit {

/// Threads and progress in the form that the method uses.
RunContext context_of(const RunOptions& options);

/// Makes the targets, fits terms to them and judges the result. The study has no map as target.
ResultDocument run_fit(const Study& study, const RunOptions& options);
/// The study of a result: `study` with the fit's choices where it leaves them open.
nlohmann::ordered_json resolved(const Study& study, const FitOutcome& outcome);
/// Fits terms to the measured map in target.map, which the study must have, in least squares. It traces them
/// or, if the study has a roughness, judges their irradiance against it (method/measured_part.h).
ResultDocument run_map_fit(const Study& study, const RunOptions& options);
/// Compares Harvey-Shack theory with random term surfaces, by rays and by waves. Throws InputError for a
/// study without roughness.
VerifyReport run_verify(const Study& study, const RunOptions& options);
/// Computes forward statistics only.
TraceReport run_trace(const Study& study, const RunOptions& options);
/// The measurement of a study; the first if a sum has several. Throws InputError if there is none.
const MeasuredPsd& measured_psd_of(const Study& study);
/// Reports what read_study or read_measured made of a measurement, with files and pictures. title: shown to
/// readers. study: where the measurement comes from, so that its files are found and its mirror is shown;
/// null: none, files are relative to the working directory.
PsdReport run_psd(const MeasuredPsd& measured, const std::string& title, const RunOptions& options,
                  const Study* study = nullptr);
/// Measures speed against accuracy on the study's own scene for about options.chart_seconds; see make_chart.
/// Files: chart.csv, result.json, summary.txt and pictures. Throws InputError for a study of a map, which has
/// no statistics.
Chart run_chart(const Study& study, const RunOptions& options);
/// Finds the roughness that meets the budgets of the study's `solve` block, which it must have. Files:
/// result.json, summary.txt; for two unknowns also contour.csv and a picture.
Specification run_solve(const Study& study, const RunOptions& options);
/// Finds how rough a mirror may be at all, for a `solve` block with `ceilings`. Files: result.json,
/// summary.txt, ceilings.csv, plots.
Ceilings run_ceilings(const Study& study, const RunOptions& options);
/// Finds the roughness that spreads the light like the measured focus of the study's `solve.focus`. Files:
/// result.json, summary.txt, focus.csv, a picture.
PsdOfFocus run_psd_of_focus(const Study& study, const RunOptions& options);
/// Options of `run_sweep` beyond its cases.
struct SweepOptions {
  std::string shard;         ///< text for read_shard
  bool gather_only = false;  ///< runs no case
  bool retry = false;        ///< runs failed cases again
};
/// Runs the cases of the study's `vary` block that have no record in options.output_directory, which must be
/// given. Then it makes the tables and pictures of all recorded cases. Under mpirun the ranks share the
/// cases, and only rank 0 returns a report. Throws InputError for a `vary` block that cannot be meant.
std::optional<SweepReport> run_sweep(const StudyCases& cases, const RunOptions& options,
                                     const SweepOptions& sweep);
/// Reports the resolved study, the numbers of its scene, the model it needs and why, and the cost of a fit.
/// With options.measure_iteration it times one iteration. The study has no map as target.
CheckReport run_check(const Study& study, const RunOptions& options);
/// The same for a study of a map.
MapCheckReport run_map_check(const Study& study, const RunOptions& options);

}  // namespace aberfit
