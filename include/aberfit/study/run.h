#pragma once
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "aberfit/report/result.h"
#include "aberfit/study/study.h"

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

/// target -> fit -> verdict (the main path).
ResultDocument run_fit(const Study& study, const RunOptions& options);
/// Harvey-Shack branch, aberration-term branch and, where asked, published numbers side by side.
nlohmann::ordered_json run_verify(const Study& study, const RunOptions& options, std::string* table);
/// Forward statistics only.
nlohmann::ordered_json run_trace(const Study& study, const RunOptions& options, std::string* table);
/// The measurement of a study (the first, where a sum has several). Throws InputError when it has none.
const MeasuredPsd& measured_psd_of(const Study& study);
/// What read_study or read_measured made of a measurement, reported: files, pictures, the table,
/// result.json's content.
nlohmann::ordered_json run_psd(const MeasuredPsd& measured, const std::string& title,
                               const RunOptions& options, std::string* table);
/// The resolved study, the numbers of its scene, the model it needs and why, predicted cost (with a chart of
/// the same study within a factor 1.5, without within 3 for the studies of fits/). Computes no fit. Throws
/// InputError for a chart_file that is no chart.
nlohmann::ordered_json run_check(const Study& study, const RunOptions& options, std::string* table);

/// Speed against accuracy on the study's own scene: every method and setting, its error against a reference
/// and its time; writes chart.csv, chart.json, summary.txt and pictures. Which settings are measured, on
/// how many rays and against how fine a reference depends on options.chart_seconds and the machine; every row
/// says it. Throws InputError for a study of a map, which has no statistics to be wrong about.
nlohmann::ordered_json run_chart(const Study& study, const RunOptions& options, std::string* table);

}  // namespace aberfit
