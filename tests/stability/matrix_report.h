#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace aberfit {

/// Summary of rows of the matrix (run_row).
struct MatrixReport {
  std::string text;      ///< shares by class, times, promises, and every row that is not equivalent
  bool sound = true;     ///< no row is a failure
  bool promised = true;  ///< and every share is as promised
};
MatrixReport report_on(const std::vector<nlohmann::json>& rows);

/// Draws the shares of outcomes by class into an SVG, by gnuplot; whether it is there and did.
bool draw_shares(const std::vector<nlohmann::json>& rows, const std::string& svg);

}  // namespace aberfit
