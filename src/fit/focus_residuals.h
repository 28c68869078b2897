#pragma once
#include <ceres/cost_function.h>

#include <memory>

#include "aberfit/fit/calibrate.h"

namespace aberfit {

/// Sizes of the parameter blocks that the white coordinates are cut into: small enough that the prior's
/// identity stays sparse, so that a CGNR step costs (residuals + kBlock) x terms.
std::vector<int> white_block_sizes(Eigen::Index terms);

/// White coordinates to statistics of the traced surface, with exact derivatives by one adjoint pass per
/// statistic: xi -> F xi -> L -> trace -> smooth statistics.
class FocusModel {
 public:
  FocusModel(const FitProblem& problem, double width, int threads);  ///< statistics: targets, then guides

  /// Statistics at `white`; `jacobian` (statistics x terms), when given, gets their derivatives. False when
  /// one does not exist.
  bool operator()(const Eigen::VectorXd& white, Eigen::VectorXd* values, Eigen::MatrixXd* jacobian) const;

 private:
  const FitProblem& problem_;
  double width_;
  int threads_;
  std::vector<Statistic> statistics_;
  RayBundle nominal_;
};

/// (S_k - T_k) / tolerance_k as one Ceres cost over all white blocks. Remembers the residuals and the
/// Jacobian of the last point at which Ceres asked for derivatives: that is the accepted point when an
/// iteration ends.
class FocusResiduals : public ceres::CostFunction {
 public:
  FocusResiduals(const FitProblem& problem, double width, int threads);
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override;

  struct Linearisation {
    Eigen::VectorXd values;  ///< smooth statistics
    Eigen::VectorXd residuals;
    Eigen::MatrixXd jacobian;  ///< of the residuals
  };
  const Linearisation& last() const { return last_; }
  int evaluations() const { return evaluations_; }

 private:
  const FitProblem& problem_;
  std::vector<Target> targets_;  // with the guides behind them
  FocusModel model_;
  mutable Linearisation last_;
  mutable int evaluations_ = 0;
};

}  // namespace aberfit
