#include "calibrate_reduced.h"

#include "aberfit/core/linear_algebra.h"

namespace aberfit::internal {
namespace {

// Directions with a smaller share of the largest eigenvalue of the Gram matrix are left out of the basis:
// rounding would spoil their orthogonality, and the rows that differ by less than 1e-5 say the same.
constexpr double kIndependent = 1e-10;

}  // namespace

ReducedResiduals::ReducedResiduals(const CalibrationBlocks& blocks, const Eigen::VectorXd& centre,
                                   double prior_weight, Eigen::VectorXd start)
    : blocks_(blocks),
      centre_(centre),
      prior_weight_(prior_weight),
      base_(std::move(start)),
      y_base_(Eigen::VectorXd::Zero(size())) {
  set_num_residuals(blocks.residuals() + size());
  mutable_parameter_block_sizes()->push_back(size());
}

void ReducedResiduals::set_base(Eigen::VectorXd white, const Eigen::VectorXd& y) const {
  base_ = std::move(white);
  y_base_ = y;
  const Eigen::Index count = blocks_.residuals();
  rows_.resize(count + 1, base_.size());
  blocks_.copy_jacobian(&rows_);
  rows_.row(count) = (base_ - centre_).transpose();

  Eigen::VectorXd norm = rows_.rowwise().norm();
  for (Eigen::Index k = 0; k <= count; ++k)
    if (norm[k] > 0) rows_.row(k) /= norm[k];
  Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(count + 1, count + 1);
  gram.selfadjointView<Eigen::Lower>().rankUpdate(rows_);
  const SymmetricEigen eigen = symmetric_eigen(gram);  // reads the lower half
  const double least = kIndependent * eigen.values[count];
  const Eigen::VectorXd root =
      eigen.values.unaryExpr([least](double l) { return l > least ? std::sqrt(l) : 0.0; });
  const Eigen::VectorXd inverse = root.unaryExpr([](double r) { return r > 0 ? 1 / r : 0.0; });
  basis_ = eigen.vectors * inverse.asDiagonal();
  const Eigen::MatrixXd projected = norm.asDiagonal() * eigen.vectors * root.asDiagonal();
  slopes_ = projected.topRows(count);
  away_ = projected.row(count).transpose();
}

bool ReducedResiduals::Evaluate(double const* const* parameters, double* residuals,
                                double** jacobians) const {
  const Eigen::VectorXd y = Eigen::Map<const Eigen::VectorXd>(parameters[0], size());
  Eigen::VectorXd white = base_;
  // At the base itself without a step of zero, so that the blocks know the point again.
  if (y != y_base_) white.noalias() += rows_.transpose() * (basis_ * (y - y_base_));
  if (!blocks_.evaluate(white, jacobians != nullptr, residuals)) return false;
  if (jacobians) set_base(std::move(white), y);
  Eigen::Map<Eigen::VectorXd>(residuals + blocks_.residuals(), size()) =
      prior_weight_ * (away_ + y - y_base_);
  if (jacobians && jacobians[0]) {
    Eigen::Map<Jacobian> all(jacobians[0], num_residuals(), size());
    all.topRows(blocks_.residuals()) = slopes_;
    all.bottomRows(size()).setZero();
    all.bottomRows(size()).diagonal().setConstant(prior_weight_);
  }
  return true;
}

}  // namespace aberfit::internal
