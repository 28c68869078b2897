#pragma once
#include <cstddef>
#include <string>
#include <vector>

#include "aberfit/core/warning.h"
#include "aberfit/report/drawn_picture.h"
#include "aberfit/report/result.h"

namespace aberfit {

/// What varies in a sweep.
struct SweepAxis {
  std::string pointer;      ///< JSON pointer into the study
  std::string unit;         ///< of its numbers, as typed; empty: plain
  bool is_numeric = false;  ///< every value is a number, in that unit
  bool is_log = false;      ///< its numbers are spaced by factors
};

/// One case of a sweep.
struct SweepRow {
  std::size_t index = 0;
  std::string id;
  std::vector<std::string> typed;  ///< value of each axis as typed, strings without quotes
  std::vector<double> number;      ///< the same as a number in the axis' unit; NaN: none
  bool failed = false;
  std::string error, verdict;
  std::vector<std::string> warnings;
  double seconds = 0;
  std::vector<double> values;  ///< parallel to SweepReport::statistics; NaN: does not exist
};

/// All cases of a sweep that were done so far, in their order.
struct SweepReport {
  std::string title;
  std::string run;                      ///< what was computed of each case
  bool is_grid = true;                  ///< else Sobol points
  bool has_seeds = false;               ///< the last axis is `/fit/seed`: realisations
  std::vector<SweepAxis> axes;          ///< in the order of the study
  std::vector<std::string> statistics;  ///< names with their SI unit
  std::vector<std::string> shown;       ///< of those, what pictures and the summary show
  std::vector<SweepRow> rows;
  std::size_t planned = 0;
  std::size_t failed() const;
  bool is_complete() const { return rows.size() == planned; }
  Warnings warnings;
};

/// A statistic over the realisations of one place: those that have a value.
struct SweepQuantiles {
  std::size_t row = 0;    ///< the first of its rows
  std::size_t count = 0;  ///< realisations with a value
  double mean = 0, standard_deviation = 0, smallest = 0, largest = 0;
  double q05 = 0, q25 = 0, q50 = 0, q75 = 0, q95 = 0;
};
/// Quantiles of a sample that holds NaN where there is none: order statistics, linear in between, at
/// p (n - 1) from the smallest (Hyndman and Fan 1996, type 7). All NaN for none.
SweepQuantiles quantiles_of(std::vector<double> values);
/// Of the k-th statistic, place by place in the order of the rows.
std::vector<SweepQuantiles> sweep_quantiles(const SweepReport& report, std::size_t statistic);

/// cases.csv and quantiles.csv (FORMATS).
std::string cases_csv(const SweepReport& report);
std::string quantiles_csv(const SweepReport& report);
/// Pictures of each statistic in report.shown, as those of a fit (report/pictures.h): curve_<statistic> over
/// the first axis with numbers, with bands of all else that varies or, where that is few, a line for each;
/// of a grid in two axes with numbers also map_<statistic>, the median in colours, and contour_<statistic>,
/// its contour lines.
std::vector<DrawnPicture> draw_pictures(const SweepReport& report, const std::string& directory,
                                        const PictureOptions& options, Warnings* warnings);

}  // namespace aberfit
