#pragma once
#include <ceres/cost_function.h>

#include "focus_residuals.h"

namespace aberfit::internal {

/// A calibration about one surface xi0 in the few unknowns that decide its next step: coordinates y of xi -
/// centre in a fixed orthonormal basis B. With y0 those of xi0 - centre,
///   xi = xi0 + B (y - y0 + bend(y - y0)),   residuals (r(xi), w B^T (xi - centre)).
///
/// The gradient of |r|^2 + w^2 |xi - centre|^2, and its Levenberg-Marquardt step for any damping equal in all
/// directions, lie in the span of the K rows of the Jacobian and of xi0 - centre. In the other P - K - 1
/// directions the cost model is the prior alone, at its minimum. B spans these rows, or everything where P <=
/// K + 1; the step in y is then that in xi, at K^2 P operations and without a P x P matrix.
///
/// With far more terms than statistics, the valley of the cost is curved, and straight steps along it have to
/// be short. Geodesic acceleration (Transtrum & Sethna 2012, arXiv:1201.5885) follows the curve for one more
/// evaluation of r:
///   (J^T J + w^2 + damping) 2 bend = -J^T d^2 r / ds^2 along y - y0.
/// The bend is of second order. Derivatives are exact at y0, where a step starts, and elsewhere those of a
/// straight step.
class SpanResiduals : public ceres::CostFunction {
 public:
  /// residuals: r, last evaluated with derivatives at xi0; it must outlive this object. centre: of the prior;
  /// prior_weight: w. damping: of the next step; bends: false for straight steps.
  SpanResiduals(const WhiteResiduals& residuals, const Eigen::VectorXd& centre, double prior_weight,
                double damping, bool bends);

  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override;

  /// Number of unknowns: P, or at most K + 1.
  int size() const { return int(basis_.cols()); }
  /// y0.
  const Eigen::VectorXd& start() const { return start_; }

 private:
  Eigen::VectorXd bend(const Eigen::VectorXd& straight) const;

  const WhiteResiduals& r_;
  double prior_weight_;
  bool bends_;
  Eigen::VectorXd origin_, at_origin_;  // xi0, r(xi0)
  Eigen::MatrixXd basis_;               // B, terms x unknowns
  Eigen::MatrixXd slopes_;              // J B
  Eigen::VectorXd start_;               // y0 = B^T (xi0 - centre)
  Eigen::MatrixXd normal_;              // J^T J + w^2 + damping, in B; empty for straight steps
  // The step of the last y, because Ceres requests values and then derivatives at the same y.
  mutable Eigen::VectorXd y_seen_, step_seen_;
};

}  // namespace aberfit::internal
