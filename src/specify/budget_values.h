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

/// Budgets as functions of the unknowns. Const use from many threads.
class BudgetValues {
 public:
  BudgetValues(const TaskAt& task_at, const std::vector<SolveUnknown>& unknowns,
               const std::vector<Budget>& budgets, Theory theory, double confidence, int threads);

  /// What budgets limit, in their order, at ln(unknown/start). Throws InputError where values are not
  /// allowed, ComputationError where the theory has none.
  Eigen::ArrayXd at(const std::vector<double>& logs) const;
  /// The same with d ln(value)/d ln(unknown), budgets x unknowns: exact where the unknown is a number of the
  /// PSD's model itself, else by central differences of 1e-3.
  struct WithSlopes {
    Eigen::ArrayXd values;
    Eigen::ArrayXXd slopes;
  };
  WithSlopes with_slopes(const std::vector<double>& logs) const;
  /// Without roughness.
  Eigen::ArrayXd of_perfect_mirror() const;
  /// ln(value/limit) of each, the sign such that positive is violated; within +-kFarOff, for roots.
  Eigen::ArrayXd excess(const Eigen::ArrayXd& values) const;
  double worst_excess(const std::vector<double>& logs) const { return excess(at(logs)).maxCoeff(); }
  /// The same with its gradient over `logs`, which is that of the budget that binds there.
  double worst_excess(const std::vector<double>& logs, Eigen::VectorXd* gradient) const;
  /// A place whose values are known.
  SolvePoint point(const std::vector<double>& logs, const WithSlopes& here) const;
  /// Everything that is told of a place. Sensitivities are left out where `whole` is false.
  SolvePoint point(const std::vector<double>& logs, bool whole) const;
  std::vector<BudgetState> states(const Eigen::ArrayXd& values) const;
  /// Specular share of the light at a place; NaN for rays.
  double core_share(const std::vector<double>& logs) const;

  std::vector<double> values_of(const std::vector<double>& logs) const { return values_at(unknowns_, logs); }
  /// Whether the task allows the values: InputErrors are answered, and what they say goes to `why`.
  bool allowed(const std::vector<double>& logs, std::string* why) const;
  int evaluations() const { return evaluations_; }
  double focal_length() const { return focal_length_; }

  static constexpr double kFarOff = 50;

 private:
  bool in_light() const;
  /// The budgets' values in their order, of those of statistics and of light as they are kept.
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
  int threads_ = 1;  // of one place's derivatives: the two arms of a contour end at different times
  double focal_length_ = 0;
  std::vector<Statistic> statistics_;     // of the budgets that have one
  std::optional<LightProperties> light_;  // of those of light alone
  std::optional<GhsPupil> pupil_;         // no unknown is one of the scene: all evaluations share it
  std::vector<std::optional<PsdVariable>> variables_;
  mutable std::atomic<int> evaluations_ = 0;
};

/// Least values of ln(value/limit) that are still met: roots are found to 1e-11.
inline constexpr double kOnBudget = 1e-9;

/// The curve through `start`, a place on it; see Contour.
Contour trace_contour(const BudgetValues& budgets, const std::array<double, 2>& start, double reach,
                      const RunContext& context);

}  // namespace aberfit::internal
