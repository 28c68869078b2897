#pragma once
#include <ceres/cost_function.h>

#include <algorithm>

#include "calibrate_blocks.h"

namespace aberfit::internal {

/// A calibration in as few unknowns as decide it: as many as there are residuals, plus one, where there are
/// more terms than that, else the terms themselves.
///
/// The cost is |r(xi)|^2 + |xi - xi0|^2. Its gradient J^T r + (xi - xi0), and the Levenberg-Marquardt step of
/// any damping that treats all directions alike, lie in the span of the K rows of J and of xi - xi0: in the
/// P - K - 1 directions orthogonal to these the model of the cost is the prior alone, which is at its minimum
/// there. So Ceres gets coordinates y in an orthonormal basis B of that span, and
///   residuals (r(xi), B^T (xi - xi0)),  xi = xi_base + B (y - y_base),
/// which is the same problem with the same steps, at K^2 P operations an iteration and no P x P or P x K
/// matrix beside J itself. Where Ceres asks for derivatives, that is at every accepted point, the basis is
/// made anew for the span there. The residuals of the prior turn with it, their squares do not.
///
/// Far more terms than statistics leave a valley that bends: steps along it have to be short, and thirty
/// iterations do what nine do that follow the bend. So with `accelerate` a step d ends at
///   xi_base + B (d + a / 2),  (J^T J + damping) a = -J^T d^2 r / ds^2 along d,
/// geodesic acceleration (Transtrum & Sethna 2012, arXiv:1201.5885), for one more evaluation of r. To first
/// order, and so to Ceres, the step is the same. Valleys of no more terms than residuals bend as well: 133
/// terms (f 1.4 m, D 0.2 m, 226 nm over 5 to 20 /m) take 22 iterations for 131. From the start itself steps
/// are straight: there most are refused, for whole radii that are off, and not for a bend.
class ReducedResiduals : public ceres::CostFunction {
 public:
  /// `centre`: xi0; `start`: xi at y = 0. The blocks are evaluated here and must outlive this.
  /// prior_weight: factor on xi - xi0.
  ReducedResiduals(const CalibrationBlocks& blocks, const Eigen::VectorXd& centre, double prior_weight,
                   bool accelerate, Eigen::VectorXd start);

  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override;

  /// Number of unknowns.
  int size() const { return std::min(blocks_.residuals() + 1, int(base_.size())); }
  /// White coordinates of the last point at which derivatives were asked for.
  const Eigen::VectorXd& white() const { return base_; }

 private:
  // Fewer unknowns than terms; else B is the identity, and not kept.
  bool spans_less() const { return size() < base_.size(); }
  void set_base(Eigen::VectorXd white, const Eigen::VectorXd& y) const;
  void find_basis() const;
  Eigen::VectorXd moved(const Eigen::VectorXd& by) const;         // xi_base + B by
  Eigen::VectorXd correction(const Eigen::VectorXd& step) const;  // a / 2

  const CalibrationBlocks& blocks_;
  const Eigen::VectorXd& centre_;
  double prior_weight_;
  bool accelerate_;
  // Of the base point; Ceres evaluates constant cost functions.
  mutable Eigen::VectorXd base_, y_base_;
  mutable Eigen::VectorXd residuals_;  // r, without the prior's
  mutable Jacobian rows_;           // J, then xi - xi0, each divided by its norm; J where B is the identity
  mutable Eigen::MatrixXd basis_;   // B = rows_^T basis_
  mutable Eigen::MatrixXd slopes_;  // J B
  mutable Eigen::VectorXd away_;    // B^T (xi - xi0)
  // Of the last point that Ceres asked for: xi, and B^T (xi - xi_base).
  mutable Eigen::VectorXd y_seen_, white_, step_;
};

}  // namespace aberfit::internal
