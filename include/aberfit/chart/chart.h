#pragma once
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "aberfit/core/warning.h"
#include "aberfit/method/run_context.h"
#include "aberfit/method/task.h"

namespace aberfit {

/// One method with one setting: what it misses and what it takes.
struct ChartRow {
  std::string family;                ///< name of the ChartFamily it belongs to
  std::string method;                ///< "polar", "central difference", "adjoint", ...
  std::string parameter, unit;       ///< what is varied, and its SI unit (or "1")
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

/// What central differences of step d [m] do to the slopes, PHYSICS 8: RMS error over the RMS slope is
/// `truncation` d^2 + `roundoff` / d.
struct StepLaw {
  double truncation = 0;  ///< [1/m^2]: 0.0932 (2 pi f_max)^2 for a uniform PSD
  double roundoff = 0;    ///< [m]: 1.2e-19 m over the RMS slope per axis, for a rim of 3.57 mm
  double best_step() const { return std::cbrt(roundoff / (2 * truncation)); }
  double operator()(double step) const { return truncation * step * step + roundoff / step; }
};

/// Speed against accuracy on one scene.
struct Chart {
  std::string title;  ///< of the task, for people
  std::vector<ChartFamily> families;
  std::optional<StepLaw> step_law;
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

/// Every method and setting on the study's own scene: its error against a reference and its time. Which
/// settings are measured, on how many rays and against how fine a reference depends on the budget [s], about
/// what it may take, and on the machine; every row says it. The study has statistics as targets, no map.
/// Throws ComputationError where the surface that all is measured on is flat.
Chart make_chart(const Task& task, double budget, const RunContext& context);

}  // namespace aberfit
