#pragma once
#include <ceres/cost_function.h>

#include "focus_residuals.h"

namespace aberfit::internal {

/// A calibration about one surface xi0 in as few unknowns as decide its next step: coordinates y of
/// xi - centre in an orthonormal basis B, fixed as long as this lives. With y0 those of xi0 - centre,
///   xi = xi0 + B (y - y0 + bend(y - y0)),   residuals (r(xi), w B^T (xi - centre)).
///
/// The gradient of |r|^2 + w^2 |xi - centre|^2, and its Levenberg-Marquardt step of any damping that treats
/// all directions alike, lie in the span of the K rows of the Jacobian and of xi0 - centre: in the other
/// P - K - 1 directions the model of the cost is the prior alone, at its minimum. B spans that, or everything
/// where P <= K + 1; so the step in y is that in xi, at K^2 P operations and without a P x P matrix.
///
/// Far more terms than statistics leave a valley that bends: steps along it have to be short, and thirty
/// iterations do what nine do that follow the bend, by geodesic acceleration (Transtrum & Sethna 2012,
/// arXiv:1201.5885) for one more evaluation of r:
///   (J^T J + w^2 + damping) 2 bend = -J^T d^2 r / ds^2 along y - y0.
/// It is of second order, so the derivatives at y0, from where a step is taken, are exact; elsewhere they are
/// those of a straight step. Valleys of no more terms than residuals bend as well.
class SpanResiduals : public ceres::CostFunction {
 public:
  /// residuals: r, which has to have been evaluated with derivatives, last at xi0; it outlives this.
  /// centre: of the prior; prior_weight: w. damping: of the step to come; bends: false for straight steps.
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
  // Ceres asks for values and for derivatives at the same y, one after the other: the step of the last one.
  mutable Eigen::VectorXd y_seen_, step_seen_;
};

}  // namespace aberfit::internal
