#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace aberfit {

/// Summary of rows of the matrix (run_row).
struct MatrixReport {
  std::string text;      ///< fractions by class, times, promises, and every row that is not equivalent
  bool sound = true;     ///< no row is a failure
  bool promised = true;  ///< and every fraction is as promised
};
MatrixReport report_on(const std::vector<nlohmann::json>& rows);

/// Draws the fractions of outcomes by class into an SVG. Returns whether gnuplot exists and succeeded.
bool draw_shares(const std::vector<nlohmann::json>& rows, const std::string& svg);

}  // namespace aberfit
