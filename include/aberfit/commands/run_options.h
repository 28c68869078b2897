#pragma once
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace aberfit {

/// Ranges of the paper's table of R, one cell for each combination. Defaults: the cells whose R the paper
/// prints (1 nm, 1 um; 100 nm, 10 um), at its 500 nm.
struct PaperTable {
  std::vector<double> rms_heights = {1e-9, 10e-9, 100e-9};        ///< sigma [m], > 0
  std::vector<double> correlation_lengths = {1e-6, 10e-6, 1e-3};  ///< l_c = int C/C(0) dr [m], > 0
  std::vector<double> diameters = {0.2, 0.4, 0.5, 1.0};           ///< D [m], > 0
  double wavelength = 500e-9;                                     ///< [m], > 0
};

struct RunOptions {
  int threads = 0;                                   ///< 0: all the process may use
  bool plots = true;                                 ///< drawn only when the study wants them too
  std::string output_directory;                      ///< empty: nothing is written
  std::string coefficients_file;                     ///< trace, verify: surface to use instead of a draw
  std::function<void(const std::string&)> progress;  ///< one line of progress; called often
  double chart_seconds = 60;                         ///< chart: about how long it may take [s], > 0
  std::string chart_file;                            ///< check: chart.json whose rates predict the cost
  std::optional<PaperTable> paper_table;             ///< check: the paper's table of R beside ours
  bool chart_optional = false;  ///< check: a chart_file that is absent or of another study is passed over
};

}  // namespace aberfit
