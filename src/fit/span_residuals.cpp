#include "span_residuals.h"

#include <algorithm>

#include "aberfit/core/linear_algebra.h"

namespace aberfit::internal {
namespace {

// Fraction of a step at which its curvature is measured, and largest bend as a fraction of the step. Beyond
// that, third derivatives count as much, and the corrected step is too long as often as right.
constexpr double kProbe = 0.1, kLargestShare = 0.375;

// Directions below this fraction of the largest eigenvalue of the Gram matrix are left out of the basis.
// Rounding would spoil their orthogonality, and gradients that differ by less than 1e-5 are equivalent.
constexpr double kIndependent = 1e-10;

// Orthonormal columns that span the rows of `jacobian` and `away`; all directions where these are no fewer.
Eigen::MatrixXd basis_of(const Jacobian& jacobian, const Eigen::VectorXd& away) {
  const Eigen::Index count = jacobian.rows(), terms = jacobian.cols();
  if (terms <= count + 1) return Eigen::MatrixXd::Identity(terms, terms);
  Eigen::MatrixXd directions(terms, count + 1);
  directions << jacobian.transpose(), away;
  for (Eigen::Index k = 0; k <= count; ++k) directions.col(k).normalize();  // a zero column stays zero
  const SymmetricEigen gram = symmetric_eigen(transposed_product(directions, directions));
  const Eigen::Index kept = (gram.values.array() > kIndependent * gram.values[count]).count();
  if (kept == 0) return Eigen::MatrixXd::Identity(terms, 1);
  return product(directions, gram.vectors.rightCols(kept) *
                                 gram.values.tail(kept).cwiseSqrt().cwiseInverse().asDiagonal());
}

}  // namespace

SpanResiduals::SpanResiduals(const WhiteResiduals& residuals, const Eigen::VectorXd& centre,
                             double prior_weight, double damping, bool bends)
    : r_(residuals),
      prior_weight_(prior_weight),
      bends_(bends),
      origin_(residuals.last().white),
      at_origin_(residuals.last().residuals),
      basis_(basis_of(residuals.last().jacobian, origin_ - centre)),
      slopes_(product(residuals.last().jacobian, basis_)),
      start_(basis_.transpose() * (origin_ - centre)) {
  if (bends_) {
    normal_ = transposed_product(slopes_, slopes_);
    normal_.diagonal().array() += prior_weight * prior_weight + damping;
  }
  set_num_residuals(residuals.num_residuals() + size());
  mutable_parameter_block_sizes()->push_back(size());
}

Eigen::VectorXd SpanResiduals::bend(const Eigen::VectorXd& straight) const {
  const double length = straight.norm();
  const Eigen::VectorXd none = Eigen::VectorXd::Zero(size());
  if (!bends_ || length == 0) return none;
  Eigen::VectorXd probe(r_.num_residuals());
  if (!r_.evaluate(origin_ + basis_ * (kProbe * straight), false, probe.data()) || !probe.allFinite())
    return none;
  const Eigen::VectorXd second = (2 / kProbe) * ((probe - at_origin_) / kProbe - slopes_ * straight);
  const Cholesky factor(normal_);
  if (!factor.positive()) return none;
  const Eigen::VectorXd half = -0.5 * factor.solve(slopes_.transpose() * second);
  return std::min(1.0, kLargestShare * length / half.norm()) * half;
}

bool SpanResiduals::Evaluate(double const* const* parameters, double* residuals, double** jacobians) const {
  const Eigen::VectorXd y = Eigen::Map<const Eigen::VectorXd>(parameters[0], size());
  if (y_seen_.size() == 0 || y != y_seen_) {
    y_seen_ = y;
    step_seen_ = y - start_ + bend(y - start_);
  }
  if (!r_.evaluate(origin_ + basis_ * step_seen_, jacobians != nullptr, residuals)) return false;
  Eigen::Map<Eigen::VectorXd>(residuals + r_.num_residuals(), size()) = prior_weight_ * (start_ + step_seen_);
  if (jacobians && jacobians[0]) {
    Eigen::Map<Jacobian> all(jacobians[0], num_residuals(), size());
    all.topRows(r_.num_residuals()) = product(r_.last().jacobian, basis_);
    all.bottomRows(size()) = prior_weight_ * Eigen::MatrixXd::Identity(size(), size());
  }
  return true;
}

}  // namespace aberfit::internal
