#pragma once
#include <chrono>
#include <functional>
#include <string>
#include <vector>

#include "aberfit/chart/chart.h"
#include "aberfit/focus/evaluate.h"
#include "aberfit/method/constants.h"
#include "aberfit/method/groundwork.h"
#include "aberfit/method/plan.h"
#include "aberfit/method/run_context.h"

namespace aberfit::internal {

/// What the errors of a family are held against.
struct ErrorLimit {
  double value = 0;
  std::string name;
};

/// What every family of a chart is measured on: the study with the surface its fit would start from.
struct ChartBench {
  const Task& task;
  Groundwork ground;
  TargetSets targets;
  TermSet terms;
  CoefficientPrior prior;
  Eigen::VectorXd coefficients;       ///< a seeded draw of the prior [m]
  std::vector<Statistic> statistics;  ///< the fitted ones
  double tolerance = 0;               ///< smallest tolerance of a target, relative to its value
  double smoothing = 0;               ///< half-width of the fit's last kernel [m]
  int threads = 1;
  std::function<void(const std::string&)> say;

  ErrorLimit margin() const { return {task.equivalence.margin, "margin of equivalence"}; }
  ErrorLimit third_of_margin() const {
    return {law::kShareOfMargin * task.equivalence.margin, "a third of the margin"};
  }
  ErrorLimit least_tolerance() const { return {tolerance, "tolerance of the targets"}; }
};
/// All of the roughness by rays, whatever the scene needs.
ChartBench bench_of_rays(const Task& task, Theory theory, const RunContext& context);
/// As `fit` lays it out: its physics, and where the band is split the terms stand for the part below the cut
/// alone. Where all of it scatters there are no terms.
ChartBench bench_of_fit(const Task& task, const RunContext& context);

/// L, O and S on one pupil; memory is reused from call to call.
class ChartTrace {
 public:
  ChartTrace(const ChartBench& bench, const TermSet& terms, PupilSample pupil, int threads);
  /// Of the bench's terms on its threads.
  ChartTrace(const ChartBench& bench, const PupilOptions& pupil);

  const PupilSample& pupil() const { return pupil_; }
  const SurfaceOperator& surface() const { return surface_; }
  const RayBundle& nominal() const { return nominal_; }
  const RayBundle& rays() const { return rays_; }
  const SurfaceField& field() const { return field_; }
  const std::vector<StatisticGradient>& gradients() const { return gradients_; }

  /// Exact statistics of the surface with these coefficients [m].
  Eigen::VectorXd exact(const Eigen::VectorXd& coefficients, const std::vector<Statistic>& statistics);
  /// The bench's statistics of its surface.
  Eigen::VectorXd exact() { return exact(bench_.coefficients, bench_.statistics); }
  /// Exact statistics of a surface error at the pupil points, however it was come by.
  Eigen::VectorXd exact_of(const SurfaceField& field, const std::vector<Statistic>& statistics);
  /// Smooth statistics, and by one adjoint pass per statistic their Jacobian (statistics x terms) where
  /// wanted. False where one does not exist.
  bool smooth(const Eigen::VectorXd& coefficients, const std::vector<Statistic>& statistics, double width,
              Eigen::VectorXd* values, Eigen::MatrixXd* jacobian);

  /// How many rays, terms and statistics of the bench there are.
  void set_sizes(ChartRow* row) const;

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

/// A family without rows.
ChartFamily family_of(const std::string& name, const std::string& title, const std::string& error_of,
                      const std::string& timed, const ErrorLimit& limit);
/// A row of a method that is not measured yet; a parameter without a name has no value.
ChartRow row_of(const std::string& method, const std::string& parameter, double value,
                const std::string& unit = "1");
void set_time(const ChartTime& time, ChartRow* row);

/// Largest and root mean square of errors; both NaN where one of them is no number or there are none.
struct StatisticErrors {
  double worst = std::nan(""), rms = worst;
};
void set_errors(const StatisticErrors& errors, const std::string& reference, double error_of_reference,
                ChartRow* row);
StatisticErrors worst_and_rms(const std::vector<double>& errors);
/// How far values are off a reference, each relative to the reference (RingThrough: share of the light).
/// Statistics without a reference do not count; one without a value makes both NaN.
StatisticErrors statistic_errors(const Eigen::VectorXd& values, const Eigen::VectorXd& reference,
                                 const std::vector<Statistic>& statistics);
/// What a statistic's error is relative to.
double statistic_scale(const Statistic& statistic, double reference);

/// Targets of encircled energy.
std::vector<Target> in_light(std::vector<Target> targets);

/// The study's pupil, with no more than `most` rays.
PupilOptions pupil_of_at_most(const Task& task, std::int64_t most);
/// Nothing where the layout does not exist for the shape.
std::optional<PupilSample> try_pupil(const Aperture& aperture, const PupilOptions& options);
std::string name_of(PupilLayout layout);
/// Mean of the square of the slope [rad^2].
double mean_square_slope(const PupilSample& pupil, const SurfaceField& field);

}  // namespace aberfit::internal
