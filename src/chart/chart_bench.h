#pragma once
#include <chrono>
#include <functional>
#include <string>
#include <vector>

#include "aberfit/chart/chart.h"
#include "aberfit/method/constants.h"
#include "aberfit/method/groundwork.h"
#include "aberfit/method/run_context.h"

// The families of a chart, one function each, and what they share. Flags of the rows and the name of their
// family are left to make_chart.
namespace aberfit::internal {

/// What the errors of a family are held against.
struct ErrorLimit {
  double value = 0;
  std::string name;
};

/// What every family of a chart is measured on: the study as `fit` lays it out, with the surface its fit
/// would start from. Where the band is split the terms stand for the part below the cut alone; where all of
/// it scatters there are none.
struct ChartBench {
  ChartBench(const Task& task, const RunContext& context);

  const Task& task;
  Groundwork ground;
  TargetSets targets;
  TermSet terms;
  Eigen::VectorXd coefficients;  ///< a seeded draw of the prior [m]
  int threads = 1;
  std::function<void(const std::string&)> say;

  ErrorLimit margin() const { return {task.equivalence.margin, "margin of equivalence"}; }
  ErrorLimit third_of_margin() const {
    return {law::kShareOfMargin * task.equivalence.margin, "a third of the margin"};
  }
};

/// Theories of the mean spot in focus, in light, against the aperture-exact one; its own error is what it
/// leaves out. seconds, here and below: about how long the family may take.
ChartFamily chart_theories(const ChartBench& bench, double seconds);
/// Rays by number and waves by grid, of one surface: encircled energies in light against a finer grid.
ChartFamily chart_models(const ChartBench& bench, double seconds);
/// Fits of growing orders by rays, by waves that begin on a coarse grid, and by waves on the safe grid alone:
/// what light says of the surfaces against their targets. Of terms and scatter no fit goes by rays.
ChartFamily chart_fits(const ChartBench& bench, double seconds);
/// Whole fits by where the roughness is split between terms and scatter: what light says of the mean, and how
/// far mirrors that share the terms differ.
ChartFamily chart_bands(const ChartBench& bench, double seconds);

/// Seconds since it was made, against seconds it may take.
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
/// Repeats `run` at least five times where `budget` [s] allows it, once in any case, and no more than needed
/// to fill a fifth of the budget.
ChartTime measure_time(double budget, const std::function<void()>& run);

/// A family without rows.
ChartFamily family_of(const std::string& name, const std::string& title, const std::string& error_of,
                      const std::string& timed, const ErrorLimit& limit);
/// A row of a method that is not measured yet; a parameter without a name has no value.
ChartRow row_of(const std::string& method, const std::string& parameter, double value,
                const std::string& unit = "1");
void set_time(const ChartTime& time, ChartRow* row);

/// The largest of these errors and their root mean square, into a row; both are NaN where one of them is no
/// number or there are none.
void set_errors(const std::vector<double>& errors, const std::string& reference, double error_of_reference,
                ChartRow* row);

/// Targets of encircled energy.
std::vector<Target> in_light(std::vector<Target> targets);

}  // namespace aberfit::internal
