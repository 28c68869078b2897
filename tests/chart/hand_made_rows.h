#pragma once
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "aberfit/chart/chart.h"

namespace aberfit::test {

inline constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

inline ChartRow row(const std::string& method, double seconds, double error) {
  ChartRow r;
  r.family = "hand-made";
  r.method = method;
  r.parameter = "rays";
  r.unit = std::string("1");  // GCC 12 warns falsely of a literal
  r.value = 1024 * (seconds > 0 ? seconds : 1);
  r.seconds = r.seconds_low = r.seconds_high = seconds;
  r.error = r.error_rms = error;
  r.repeats = 5;
  return r;
}

inline ChartFamily family(std::vector<ChartRow> rows, double tolerance) {
  ChartFamily f;
  f.name = "hand-made";
  f.title = "Made by hand";
  f.error_of = "error, made up";
  f.timed = "nothing";
  f.tolerance = tolerance;
  f.tolerance_of = "a wish";
  f.rows = std::move(rows);
  mark_rows(&f);
  return f;
}

}  // namespace aberfit::test
