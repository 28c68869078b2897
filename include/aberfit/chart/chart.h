#pragma once
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "aberfit/core/warning.h"
#include "aberfit/method/run_context.h"
#include "aberfit/method/task.h"

namespace aberfit {

/// One method with one setting: its error and its time.
struct ChartRow {
  std::string family;                ///< name of its ChartFamily
  std::string method;                ///< "rays", "waves", "terms and scatter", ...
  std::string parameter, unit;       ///< the parameter and its SI unit: "1", or "/m" for a cut f_c
  double value = std::nan("");       ///< value of the parameter; NaN: the method has none
  std::int64_t rays = 0, terms = 0;  ///< sizes of the measurement
  std::int64_t statistics = 0;
  double error = std::nan("");      ///< defined by the family's `error_of`; NaN: does not exist
  double error_rms = std::nan("");  ///< root mean square of the errors whose largest is `error`
  double error_of_reference = std::nan("");
  std::string reference;
  double seconds = std::nan("");                                   ///< median
  double seconds_low = std::nan(""), seconds_high = std::nan("");  ///< quartiles
  int repeats = 0;
  bool on_frontier = false;  ///< no other row of the family is better in one and no worse in the other
  bool is_default = false;   ///< setting of the study today
  bool is_cheapest_within_tolerance = false;
  std::string note;  ///< further observation, one clause
};

/// Rows for the same task, so that their errors and times can be compared.
struct ChartFamily {
  std::string name;      ///< kebab-case
  std::string title;     ///< for people
  std::string error_of;  ///< definition of `error`
  std::string timed;     ///< definition of `seconds`
  double tolerance = 0;  ///< limit for `error`
  std::string tolerance_of;
  std::vector<ChartRow> rows;
  std::string remark;   ///< supplement to the rows, one sentence or none
  std::string skipped;  ///< why there are no rows, one sentence; empty where there are some
};

/// Speed against accuracy on one scene.
struct Chart {
  std::string title;  ///< title of the task, for people
  std::vector<ChartFamily> families;
  std::string instruction_set;  ///< instruction set of the kernels
  int threads = 1;
  double budget_seconds = 0;  ///< requested budget
  double seconds = 0;         ///< total time
  Warnings warnings;
};

/// Sets the flags `on_frontier` (Pareto: of two rows with the same error and time both stay) and
/// `is_cheapest_within_tolerance`. The cheapest row has error <= tolerance and the least seconds; equally
/// fast rows are ordered by error, then by position. No row is flagged whose reference is not known to the
/// tolerance, or without an error or a time.
void mark_rows(ChartFamily* family);

/// Measures theories, rays and waves for one surface, whole fits, and cuts of the band, on the study's own
/// scene. Each row has its error against wave optics and its time. The number of rows and the resolution of
/// the reference depend on the budget [s], which is nearly met, and on the machine; every row states them. A
/// family that the scene lacks gives the reason. The study has statistics as targets, no map.
Chart make_chart(const Task& task, double budget, const RunContext& context);

}  // namespace aberfit
