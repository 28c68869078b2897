#pragma once
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "aberfit/core/warning.h"
#include "aberfit/method/run_context.h"
#include "aberfit/method/task.h"

namespace aberfit {

/// One method with one setting: what it misses and what it takes.
struct ChartRow {
  std::string family;                ///< name of the ChartFamily it belongs to
  std::string method;                ///< "rays", "waves", "terms and scatter", ...
  std::string parameter, unit;       ///< what is varied, and its SI unit: "1", or "/m" of f_c
  double value = std::nan("");       ///< of the parameter; NaN: the method has none
  std::int64_t rays = 0, terms = 0;  ///< sizes it was measured with
  std::int64_t statistics = 0;
  double error = std::nan("");      ///< as the family's `error_of` says; NaN: does not exist
  double error_rms = std::nan("");  ///< root mean square of what `error` is the largest of
  double error_of_reference = std::nan("");
  std::string reference;
  double seconds = std::nan("");                                   ///< median
  double seconds_low = std::nan(""), seconds_high = std::nan("");  ///< quartiles
  int repeats = 0;
  bool on_frontier = false;  ///< no other row of the family is better in one and no worse in the other
  bool is_default = false;   ///< what the study does today
  bool is_cheapest_within_tolerance = false;
  std::string note;  ///< what else was seen, one clause
};

/// Rows that do the same job, so that their errors and times may be compared.
struct ChartFamily {
  std::string name;      ///< kebab-case
  std::string title;     ///< for people
  std::string error_of;  ///< what `error` is
  std::string timed;     ///< what `seconds` are
  double tolerance = 0;  ///< what `error` is held against
  std::string tolerance_of;
  std::vector<ChartRow> rows;
  std::string remark;   ///< what the rows do not say, one sentence or none
  std::string skipped;  ///< why there are no rows, one sentence; empty where there are some
};

/// Speed against accuracy on one scene.
struct Chart {
  std::string title;  ///< of the task, for people
  std::vector<ChartFamily> families;
  std::string instruction_set;  ///< of the kernels
  int threads = 1;
  double budget_seconds = 0;  ///< what was asked for
  double seconds = 0;         ///< what it took
  Warnings warnings;
};

/// Sets the flags `on_frontier` (Pareto: of two rows with the same error and time both stay) and
/// `is_cheapest_within_tolerance` (error <= tolerance, least seconds; of equally fast ones the more accurate,
/// then the first; none whose reference is not known to the tolerance). Rows without an error or a time are
/// never flagged.
void mark_rows(ChartFamily* family);

/// Theories, rays and waves of one surface, whole fits and cuts of the band, on the study's own scene: each
/// with its error in light and its time. What is measured, and against how fine a reference, depends on the
/// budget [s], about what it may take, and on the machine; every row says it. A family that the scene does
/// not have says why. The study has statistics as targets, no map.
Chart make_chart(const Task& task, double budget, const RunContext& context);

}  // namespace aberfit
