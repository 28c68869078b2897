#pragma once
#include <Eigen/Core>
#include <array>
#include <atomic>
#include <optional>
#include <string>
#include <vector>

#include "aberfit/specify/solve.h"
#include "aberfit/theory/psd_jacobian.h"
#include "exact_variable.h"

namespace aberfit::internal {

/// Budgets as functions of the unknowns. Const functions may be called from many threads.
class BudgetValues {
 public:
  BudgetValues(const TaskAt& task_at, const std::vector<SolveUnknown>& unknowns,
               const std::vector<Budget>& budgets, Theory theory, double confidence, int threads);

  /// Returns the budgeted quantities in their order at ln(unknown/start). Throws InputError if values are not
  /// allowed, ComputationError if the theory has no result.
  Eigen::ArrayXd at(const std::vector<double>& logs) const;
  /// The same with d ln(value)/d ln(unknown), budgets x unknowns. Exact if the unknown is a parameter of the
  /// PSD model, otherwise central differences of 1e-3.
  struct WithSlopes {
    Eigen::ArrayXd values;
    Eigen::ArrayXXd slopes;
  };
  WithSlopes with_slopes(const std::vector<double>& logs) const;
  /// Returns the quantities without roughness.
  Eigen::ArrayXd of_perfect_mirror() const;
  /// Returns ln(value/limit) of each budget, positive if violated, limited to +-kFarOff for root finding.
  Eigen::ArrayXd excess(const Eigen::ArrayXd& values) const;
  double worst_excess(const std::vector<double>& logs) const { return excess(at(logs)).maxCoeff(); }
  /// The same with its gradient over `logs`, which is that of the binding budget.
  double worst_excess(const std::vector<double>& logs, Eigen::VectorXd* gradient) const;
  /// Describes a place whose values are known.
  SolvePoint point(const std::vector<double>& logs, const WithSlopes& here) const;
  /// Describes a place in full, but without sensitivities if `whole` is false.
  SolvePoint point(const std::vector<double>& logs, bool whole) const;
  std::vector<BudgetState> states(const Eigen::ArrayXd& values) const;
  /// Returns the specular fraction of the energy at a place; NaN for rays.
  double core_share(const std::vector<double>& logs) const;

  std::vector<double> values_of(const std::vector<double>& logs) const { return values_at(unknowns_, logs); }
  /// Returns whether the task allows the values. An InputError is caught and its message goes to `why`.
  bool allowed(const std::vector<double>& logs, std::string* why) const;
  int evaluations() const { return evaluations_; }
  double focal_length() const { return focal_length_; }

  static constexpr double kFarOff = 50;

 private:
  bool in_light() const;
  /// Merges the values of statistics and of diffraction properties into the order of the budgets.
  Eigen::VectorXd in_order(const Eigen::VectorXd& statistics, const Eigen::VectorXd& light,
                           const RadialPsd& psd) const;
  Eigen::ArrayXd predict(const Task& task, double height_factor) const;
  /// Values, and d ln(value)/d ln(variable), budgets x variables.
  struct Exact {
    Eigen::VectorXd values;
    Eigen::MatrixXd logarithmic;
  };
  Exact exact(const Task& task, const std::vector<PsdVariable>& variables) const;
  PsdJacobian geometric_jacobian(const Task& task, const std::vector<PsdVariable>& variables) const;
  Eigen::ArrayXd difference(const std::vector<double>& logs, std::size_t unknown,
                            const Eigen::ArrayXd& here) const;

  const TaskAt& task_at_;
  const std::vector<SolveUnknown>& unknowns_;
  const std::vector<Budget>& budgets_;
  Theory theory_;
  double confidence_ = 0;
  int threads_ = 1;  // for the derivatives at one place; the two arms of a contour end at different times
  double focal_length_ = 0;
  std::vector<Statistic> statistics_;     // statistics of the budgets that have one
  std::optional<LightProperties> light_;  // of the budgets on diffraction properties
  std::optional<GhsPupil> pupil_;  // common to all evaluations, because no unknown is part of the scene
  std::vector<std::optional<PsdVariable>> variables_;
  mutable std::atomic<int> evaluations_ = 0;
};

/// Tolerance of ln(value/limit) for a budget that is met; roots are found to 1e-11.
inline constexpr double kOnBudget = 1e-9;

/// Traces the curve through `start`, a point on it; see Contour.
Contour trace_contour(const BudgetValues& budgets, const std::array<double, 2>& start, double reach,
                      const RunContext& context);

}  // namespace aberfit::internal
