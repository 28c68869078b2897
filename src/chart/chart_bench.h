#pragma once
#include <chrono>
#include <functional>
#include <string>
#include <vector>

#include "aberfit/chart/chart.h"
#include "aberfit/method/constants.h"
#include "aberfit/method/groundwork.h"
#include "aberfit/method/run_context.h"

// The families of a chart, one function each. Flags of rows and names of families are left to make_chart.
namespace aberfit::internal {

/// Upper limit for the errors of a family.
struct ErrorLimit {
  double value = 0;
  std::string name;
};

/// The study as `fit` lays it out, with the first surface of its fit, for every family of a chart. Where the
/// band is split, terms represent the part below the cut; where all of it scatters there are none.
struct ChartBench {
  ChartBench(const Task& task, const RunContext& context);

  const Task& task;
  Groundwork ground;
  TargetSets targets;
  TermSet terms;
  Eigen::VectorXd coefficients;  ///< a seeded realisation of the prior [m]
  int threads = 1;
  std::function<void(const std::string&)> say;

  ErrorLimit margin() const { return {task.equivalence.margin, "margin of equivalence"}; }
  ErrorLimit third_of_margin() const {
    return {law::kShareOfMargin * task.equivalence.margin, "a third of the margin"};
  }
};

/// Theories of the mean spot in the focus, by wave optics, against the aperture-exact one, whose own error is
/// what it neglects. seconds, here and below: approximate time for the family.
ChartFamily chart_theories(const ChartBench& bench, double seconds);
/// Rays by number and waves by grid, for one surface: encircled energies against a finer grid of waves.
ChartFamily chart_models(const ChartBench& bench, double seconds);
/// Fits of growing orders by rays, by waves from a coarse grid on, and by waves on the safe grid alone.
/// Errors are those of the surfaces by wave optics against their targets. Fits with scatter are not made by
/// rays.
ChartFamily chart_fits(const ChartBench& bench, double seconds);
/// Whole fits by the cut of the roughness into terms and scatter: error of the mean by wave optics, and
/// spread of mirrors that share the terms.
ChartFamily chart_bands(const ChartBench& bench, double seconds);

class ChartClock {
 public:
  explicit ChartClock(double budget) : budget_(budget), begin_(std::chrono::steady_clock::now()) {}
  double elapsed() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
  }
  double left() const { return budget_ - elapsed(); }

 private:
  double budget_;
  std::chrono::steady_clock::time_point begin_;
};

/// Median and quartiles of the time of `run` [s].
struct ChartTime {
  double median = 0, low = 0, high = 0;
  int repeats = 0;
};
/// Repeats `run` at least five times within `budget` [s], always once, and at most for a fifth of the budget.
ChartTime measure_time(double budget, const std::function<void()>& run);

ChartFamily family_of(const std::string& name, const std::string& title, const std::string& error_of,
                      const std::string& timed, const ErrorLimit& limit);
/// A row of a method that is not measured yet; a parameter without a name has no value.
ChartRow row_of(const std::string& method, const std::string& parameter, double value,
                const std::string& unit = "1");
void set_time(const ChartTime& time, ChartRow* row);

/// Writes the largest and the root mean square of these errors into a row; NaN where one is NaN or none
/// exist.
void set_errors(const std::vector<double>& errors, const std::string& reference, double error_of_reference,
                ChartRow* row);

std::vector<Target> in_light(std::vector<Target> targets);

}  // namespace aberfit::internal
