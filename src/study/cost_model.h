#pragma once
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "chart_bench.h"

namespace aberfit {

/// What the cost of a fit depends on.
struct FitSize {
  double rays = 0, terms = 0;
  double fitted = 0;  ///< targets and guides
  double judged = 0;  ///< targets and held-out statistics
  double zone_points = 0;
  double threads = 1;
};
FitSize fit_size(const Study& study, const TermSet& terms, const TargetSets& targets, int threads);

/// Times of the stages of one fit [s], and the size they were measured at.
struct FitRates {
  FitSize size;
  double targets = 0, prior = 0;
  double iteration = 0;  ///< one iteration, its share of rejected steps and of the start included
  double iterations = 0;
  bool iterations_known = false;  ///< the fit was run to its end
  double exact = 0;  ///< one exact evaluation of the targets on the fitted rays, L and O included
  double fresh = 0, zones = 0;
  double forward = 0, jacobian = 0;  ///< smooth values; the same with the full Jacobian
  std::string source;                ///< where they come from, a clause
};

/// Measures the stages on the study itself in about `seconds`; long ones on fewer rays or iterations.
FitRates measure_rates(const ChartBench& bench, double seconds);

/// Rates of the machine that the constants come from; for studies without a chart.
FitRates built_in_rates();

nlohmann::ordered_json to_json(const FitRates& rates);
/// The rates of a chart.json or of the folder it lies in; `same_study`: whether it is of this resolved study.
/// Throws InputError for a file that is no chart.
FitRates read_rates(const std::string& file_or_folder, const nlohmann::ordered_json& study, bool* same_study);

/// Predicted times of the stages of `fit`, in order, first start only, pictures left out.
std::vector<std::pair<std::string, double>> predict_fit(const FitRates& rates, const FitSize& size);

/// Predicted time [s] of the least squares of a map of `points` with `terms`.
double predict_map_fit(double points, double terms, int threads);

}  // namespace aberfit
