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

// The commands as functions: each returns what it found as a struct, of which the headers of report make
// JSON, tables and pictures. Files are written where options.output_directory names a folder.
namespace aberfit {

/// Threads and progress as the method takes them.
RunContext context_of(const RunOptions& options);

/// target -> fit -> verdict (the main path). The study has no map as target.
ResultDocument run_fit(const Study& study, const RunOptions& options);
/// The study of a result: `study` with what the fit has chosen where it leaves that open.
nlohmann::ordered_json resolved(const Study& study, const FitOutcome& outcome);
/// Least-squares terms of the measured map in target.map, which the study has: traced, or, beside a
/// roughness, judged in light against it (method/measured_part.h).
ResultDocument run_map_fit(const Study& study, const RunOptions& options);
/// Compares Harvey-Shack theory with random term surfaces, by rays and by waves. Throws InputError for a
/// study without roughness.
VerifyReport run_verify(const Study& study, const RunOptions& options);
/// Forward statistics only.
TraceReport run_trace(const Study& study, const RunOptions& options);
/// The measurement of a study (the first, where a sum has several). Throws InputError when it has none.
const MeasuredPsd& measured_psd_of(const Study& study);
/// What read_study or read_measured made of a measurement, reported: files and pictures. title: for people.
PsdReport run_psd(const MeasuredPsd& measured, const std::string& title, const RunOptions& options);
/// Speed against accuracy on the study's own scene, about options.chart_seconds long; see make_chart. Files:
/// chart.csv, result.json, summary.txt and pictures. Throws InputError for a study of a map, which has no
/// statistics to be wrong about.
Chart run_chart(const Study& study, const RunOptions& options);
/// Which roughness meets the budgets of the study's `solve` block, which it must have. Files: result.json,
/// summary.txt, of two unknowns contour.csv and a picture.
Specification run_solve(const Study& study, const RunOptions& options);
/// How rough a mirror may be at all, of a `solve` block with `ceilings`. Files: result.json, summary.txt,
/// ceilings.csv, plots.
Ceilings run_ceilings(const Study& study, const RunOptions& options);
/// Which roughness spreads the light as the measured focus of the study's `solve.focus` has it. Files:
/// result.json, summary.txt, focus.csv, a picture.
PsdOfFocus run_psd_of_focus(const Study& study, const RunOptions& options);
/// What `run_sweep` does besides its cases.
struct SweepOptions {
  std::string shard;         ///< as read_shard takes it
  bool gather_only = false;  ///< runs no case
  bool retry = false;        ///< cases that failed are done again
};
/// The cases of the study's `vary` block that the folder of options.output_directory, which must be given,
/// has no record of; then the tables and pictures of all that are recorded. Under mpirun the ranks share
/// them; then only rank 0 has a report, the others nothing. Throws InputError for a `vary` block that cannot
/// be meant.
std::optional<SweepReport> run_sweep(const StudyCases& cases, const RunOptions& options,
                                     const SweepOptions& sweep);
/// The resolved study, the numbers of its scene, the model it needs and why, and what a fit takes: with
/// options.measure_iteration, one iteration is made and timed. The study has no map as target.
CheckReport run_check(const Study& study, const RunOptions& options);
/// The same of a study of a map.
MapCheckReport run_map_check(const Study& study, const RunOptions& options);

}  // namespace aberfit
