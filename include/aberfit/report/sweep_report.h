#pragma once
#include <cstddef>
#include <string>
#include <vector>

#include "aberfit/core/warning.h"
#include "aberfit/report/drawn_picture.h"
#include "aberfit/report/result.h"

namespace aberfit {

/// A quantity that varies in a sweep.
struct SweepAxis {
  std::string pointer;      ///< JSON pointer into the study
  std::string unit;         ///< unit of its numbers as typed; empty: plain numbers
  bool is_numeric = false;  ///< every value is a number in that unit
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

/// All finished cases of a sweep, in their order.
struct SweepReport {
  std::string title;
  std::string run;                      ///< the computation of each case
  bool is_grid = true;                  ///< else Sobol points
  bool has_seeds = false;               ///< the last axis is `/fit/seed`: realisations
  std::vector<SweepAxis> axes;          ///< in the order of the study
  std::vector<std::string> statistics;  ///< names with their SI unit
  std::vector<std::string> shown;       ///< those in pictures and summary
  std::vector<SweepRow> rows;
  std::size_t planned = 0;
  std::size_t failed() const;
  bool is_complete() const { return rows.size() == planned; }
  Warnings warnings;
};

/// A statistic over those realisations of one place that have a value.
struct SweepQuantiles {
  std::size_t row = 0;    ///< the first of its rows
  std::size_t count = 0;  ///< realisations with a value
  double mean = 0, standard_deviation = 0, smallest = 0, largest = 0;
  double q05 = 0, q25 = 0, q50 = 0, q75 = 0, q95 = 0;
};
/// Quantiles of a sample; NaN values are ignored. Order statistics are interpolated linearly at p (n - 1)
/// from the smallest (Hyndman and Fan 1996, type 7). Without a value all are NaN.
SweepQuantiles quantiles_of(std::vector<double> values);
/// Quantiles of one statistic, place by place in the order of the rows.
std::vector<SweepQuantiles> sweep_quantiles(const SweepReport& report, std::size_t statistic);

/// cases.csv and quantiles.csv (FORMATS).
std::string cases_csv(const SweepReport& report);
std::string quantiles_csv(const SweepReport& report);
/// Draws pictures of each statistic in report.shown, as a fit does (report/pictures.h). curve_<statistic> is
/// over the first axis with numbers, with bands for the other axes, or a line for each of their values if
/// these are few. A grid in two axes with numbers also has map_<statistic>, the median in colours, and
/// contour_<statistic>, its contour lines.
std::vector<DrawnPicture> draw_pictures(const SweepReport& report, const std::string& directory,
                                        const PictureOptions& options, Warnings* warnings);

}  // namespace aberfit
