#pragma once
#include <chrono>
#include <functional>
#include <string>
#include <vector>

#include "aberfit/chart/chart.h"
#include "aberfit/focus/evaluate.h"
#include "aberfit/method/groundwork.h"
#include "aberfit/method/plan.h"
#include "aberfit/method/run_context.h"

namespace aberfit::internal {

/// What every family of a chart is measured on: the study with the surface its fit would start from.
struct ChartBench {
  const Task& task;
  Groundwork ground;
  TargetSets targets;
  TermSet terms;
  double captured = 0;
  CoefficientPrior prior;
  Eigen::VectorXd coefficients;       ///< a seeded draw of the prior [m]
  std::vector<Statistic> statistics;  ///< the fitted ones
  double tolerance = 0;               ///< smallest tolerance of a target, relative to its value
  double smoothing = 0;               ///< half-width of the fit's last kernel [m]
  double targets_seconds = 0, prior_seconds = 0;
  int threads = 1;
  std::function<void(const std::string&)> say;
};
ChartBench make_chart_bench(const Task& task, const PhysicsRequest& physics, const RunContext& context);

/// L, O and S on one pupil; memory is reused from call to call.
class ChartTrace {
 public:
  ChartTrace(const ChartBench& bench, const TermSet& terms, PupilSample pupil, int threads);

  const PupilSample& pupil() const { return pupil_; }
  const SurfaceOperator& surface() const { return surface_; }
  const RayBundle& nominal() const { return nominal_; }
  const RayBundle& rays() const { return rays_; }
  const SurfaceField& field() const { return field_; }
  const std::vector<StatisticGradient>& gradients() const { return gradients_; }

  /// Exact statistics of the surface with these coefficients [m].
  Eigen::VectorXd exact(const Eigen::VectorXd& coefficients, const std::vector<Statistic>& statistics);
  /// Exact statistics of a surface error at the pupil points, however it was come by.
  Eigen::VectorXd exact_of(const SurfaceField& field, const std::vector<Statistic>& statistics);
  /// Smooth statistics, and by one adjoint pass per statistic their Jacobian (statistics x terms) where
  /// wanted. False where one does not exist.
  bool smooth(const Eigen::VectorXd& coefficients, const std::vector<Statistic>& statistics, double width,
              Eigen::VectorXd* values, Eigen::MatrixXd* jacobian);

 private:
  const ChartBench& bench_;
  int threads_;
  PupilSample pupil_;
  SurfaceOperator surface_;
  RayBundle nominal_, rays_;
  SurfaceField field_;
  FocusWorkspace workspace_;
  std::vector<StatisticGradient> gradients_;
};

/// Seconds since it was made, against seconds it may take.
class ChartClock {
 public:
  explicit ChartClock(double budget) : budget_(budget), begin_(std::chrono::steady_clock::now()) {}
  double elapsed() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
  }
  double left() const { return budget_ - elapsed(); }
  double budget() const { return budget_; }

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
void set_time(const ChartTime& time, ChartRow* row);

/// Largest and root mean square of errors; both NaN where one of them is no number or there are none.
struct StatisticErrors {
  double worst = 0, rms = 0;
};
StatisticErrors worst_and_rms(const std::vector<double>& errors);
/// How far values are off a reference, each relative to the reference (RingThrough: share of the light).
/// Statistics without a reference do not count; one without a value makes both NaN.
StatisticErrors statistic_errors(const Eigen::VectorXd& values, const Eigen::VectorXd& reference,
                                 const std::vector<Statistic>& statistics);
/// What a statistic's error is relative to.
double statistic_scale(const Statistic& statistic, double reference);

/// The study's pupil, with no more than `most` rays.
PupilOptions pupil_of_at_most(const Task& task, std::int64_t most);

}  // namespace aberfit::internal
