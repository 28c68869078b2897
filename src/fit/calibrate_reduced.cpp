#include "calibrate_reduced.h"

#include <algorithm>
#include <cmath>

#include "aberfit/core/linear_algebra.h"

namespace aberfit::internal {
namespace {

// Directions with a smaller share of the largest eigenvalue of the Gram matrix are left out of the basis:
// rounding would spoil their orthogonality, and the rows that differ by less than 1e-5 say the same.
constexpr double kIndependent = 1e-10;

// Of a step: where its curvature is looked at, and what the correction for it may be at most. Where that is
// larger, third derivatives count as much, and steps come out too long as often as right.
constexpr double kProbe = 0.1, kLargestShare = 0.375;

}  // namespace

ReducedResiduals::ReducedResiduals(const CalibrationBlocks& blocks, const Eigen::VectorXd& centre,
                                   double prior_weight, bool accelerate, Eigen::VectorXd start)
    : blocks_(blocks),
      centre_(centre),
      prior_weight_(prior_weight),
      accelerate_(accelerate),
      base_(std::move(start)),
      y_base_(Eigen::VectorXd::Zero(size())),
      y_seen_(y_base_),
      white_(base_),
      step_(y_base_) {
  set_num_residuals(blocks.residuals() + size());
  mutable_parameter_block_sizes()->push_back(size());
}

void ReducedResiduals::set_base(Eigen::VectorXd white, const Eigen::VectorXd& y) const {
  base_ = std::move(white);
  y_base_ = y_seen_ = y;
  step_ = Eigen::VectorXd::Zero(size());
  if (spans_less()) {
    find_basis();
  } else {
    rows_.resize(blocks_.residuals(), size());
    blocks_.copy_jacobian(&rows_);
    slopes_ = rows_;
    away_ = base_ - centre_;
  }
}

void ReducedResiduals::find_basis() const {
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

Eigen::VectorXd ReducedResiduals::moved(const Eigen::VectorXd& by) const {
  if (!spans_less()) return base_ + by;
  return base_ + rows_.transpose() * (basis_ * by);
}

Eigen::VectorXd ReducedResiduals::correction(const Eigen::VectorXd& step) const {
  Eigen::VectorXd none = Eigen::VectorXd::Zero(size());
  Eigen::VectorXd probe(blocks_.residuals());
  if (!blocks_.evaluate(moved(kProbe * step), false, probe.data()) || !probe.allFinite()) return none;
  const Eigen::VectorXd along = slopes_ * step,
                        second = (2 / kProbe) * ((probe - residuals_) / kProbe - along);
  // Ceres does not tell its damping: (J^T J + w^2 + damping) step = -gradient does.
  const double w2 = prior_weight_ * prior_weight_, length = step.norm();
  const Eigen::VectorXd gradient = slopes_.transpose() * residuals_ + w2 * away_;
  const double damping = std::max(0.0, -(step.dot(gradient) + along.squaredNorm()) / (length * length) - w2);
  Eigen::MatrixXd normal = transposed_product(slopes_, slopes_);
  normal.diagonal().array() += w2 + damping;
  const Cholesky factor(normal);
  if (!factor.positive()) return none;
  const Eigen::VectorXd half = -0.5 * factor.solve(slopes_.transpose() * second);
  return std::min(1.0, kLargestShare * length / half.norm()) * half;
}

bool ReducedResiduals::Evaluate(double const* const* parameters, double* residuals,
                                double** jacobians) const {
  const Eigen::VectorXd y = Eigen::Map<const Eigen::VectorXd>(parameters[0], size());
  // At the base itself without a step of zero, so that the blocks know the point again.
  if (y != y_seen_) {
    y_seen_ = y;
    step_ = y - y_base_;
    const bool from_start = y_base_.isZero(0);
    if (accelerate_ && !from_start && y != y_base_) step_ += correction(step_);
    white_ = y == y_base_ ? base_ : moved(step_);
  }
  if (!blocks_.evaluate(white_, jacobians != nullptr, residuals)) return false;
  if (jacobians) {
    residuals_ = Eigen::Map<const Eigen::VectorXd>(residuals, blocks_.residuals());
    set_base(white_, y);
  }
  Eigen::Map<Eigen::VectorXd>(residuals + blocks_.residuals(), size()) = prior_weight_ * (away_ + step_);
  if (jacobians && jacobians[0]) {
    Eigen::Map<Jacobian> all(jacobians[0], num_residuals(), size());
    all.topRows(blocks_.residuals()) = slopes_;
    all.bottomRows(size()).setZero();
    all.bottomRows(size()).diagonal().setConstant(prior_weight_);
  }
  return true;
}

}  // namespace aberfit::internal
