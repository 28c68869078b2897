#pragma once
#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "aberfit/core/warning.h"
#include "aberfit/report/result.h"

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

/// Everything chart.json holds.
struct Chart {
  nlohmann::ordered_json study;  ///< the resolved study
  std::string title;
  std::vector<ChartFamily> families;
  std::optional<StepLaw> step_law;
  nlohmann::ordered_json rates;  ///< measured times of the stages of a fit, see study/cost_model.h
  std::string instruction_set;   ///< of the kernels
  double budget_seconds = 0;     ///< what was asked for
  double seconds = 0;            ///< what it took
  Warnings warnings;
  Provenance provenance;
};

/// Sets the flags `on_frontier` (Pareto: of two rows with the same error and time both stay) and
/// `is_cheapest_within_tolerance` (error <= tolerance, least seconds; of equally fast ones the more accurate,
/// then the first; none whose reference is not known to the tolerance). Rows without an error or a time are
/// never flagged.
void mark_rows(ChartFamily* family);

/// chart.csv: one line per row, all of its members and its family's descriptions, SI units in the header;
/// what does not exist is empty.
std::string chart_csv(const Chart& chart);

/// chart.json; what does not exist is null.
nlohmann::ordered_json to_json(const Chart& chart);

/// The table people read on the terminal, at most 100 columns: per family the setting of today, the cheapest
/// one that meets the tolerance, and what the first costs more.
std::string summary_table(const Chart& chart);

/// "65,536 rays polar", "1 um central difference": a row by its setting.
std::string setting_text(const ChartRow& row);

/// Pictures below `directory`/plots: one per family, error against time with the frontier, today's setting
/// and the cheapest within tolerance marked; chart_normals_step, slope error against step with the law beside
/// it. As write_plots.
std::vector<std::string> write_chart_plots(const Chart& chart, const std::string& directory,
                                           Warnings* warnings);

}  // namespace aberfit
