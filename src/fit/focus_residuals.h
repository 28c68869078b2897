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

/// Residuals of the white coordinates as one Ceres cost over all white blocks. Remembers values, residuals
/// and Jacobian of the last point at which Ceres asked for derivatives: that is the accepted point when an
/// iteration ends.
class WhiteResiduals : public ceres::CostFunction {
 public:
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override;

  struct Linearisation {
    Eigen::VectorXd values;  ///< what is compared with the targets: smooth statistics, PSD bins [m^4]
    Eigen::VectorXd residuals;
    Eigen::MatrixXd jacobian;  ///< of the residuals
  };
  const Linearisation& last() const { return last_; }
  int evaluations() const { return evaluations_; }

  /// Values and residuals at `white` and, when asked for, the residuals' Jacobian. False where they do not
  /// exist.
  virtual bool linearise(const Eigen::VectorXd& white, bool with_jacobian, Linearisation* result) const = 0;

 protected:
  WhiteResiduals(int residuals, Eigen::Index terms);

 private:
  mutable Linearisation last_;
  mutable int evaluations_ = 0;
};

/// (S_k - T_k) / tolerance_k, targets, then guides.
class FocusResiduals : public WhiteResiduals {
 public:
  FocusResiduals(const FitProblem& problem, double width, int threads);
  bool linearise(const Eigen::VectorXd& white, bool with_jacobian, Linearisation* result) const override;

 private:
  std::vector<Target> targets_;  // with the guides behind them
  FocusModel model_;
};

/// log(S_b / T_b) / tolerance_b of the surface's own PSD bins. False where a bin is not positive: there its
/// logarithm has no value.
class SpectrumResiduals : public WhiteResiduals {
 public:
  explicit SpectrumResiduals(const FitProblem& problem);
  bool linearise(const Eigen::VectorXd& white, bool with_jacobian, Linearisation* result) const override;

 private:
  const FitProblem& problem_;
};

}  // namespace aberfit
