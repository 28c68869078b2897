#include "posterior.h"

#include "aberfit/core/linear_algebra.h"

namespace aberfit::internal {
namespace {

// Directions below this fraction of the largest singular value are rounding.
constexpr double kRankOfRows = 1e-10;

}  // namespace

void fill_posterior(const FitProblem& problem, const Jacobian& jacobian, FitResult* result) {
  const Eigen::Index statistics = jacobian.rows(), terms = jacobian.cols();
  const Eigen::MatrixXd gram = jacobian * jacobian.transpose();
  const SymmetricEigen eigen = symmetric_eigen(gram);
  const Eigen::Index shown = std::min(statistics, terms);
  result->singular_values = eigen.values.cwiseMax(0.0).cwiseSqrt().reverse().head(shown);
  const double largest = shown > 0 ? result->singular_values[0] : 0.0;
  result->rank = int((result->singular_values.array() > 1.0).count());
  result->null_directions = int(terms - (result->singular_values.array() > kRankOfRows * largest).count());

  // Woodbury: (I + J^T J)^-1 = I - J^T M^-1 J with M = I + J J^T = C C^T: the prior variance of a
  // coefficient, minus the reduction by the data.
  const Cholesky cholesky(gram + Eigen::MatrixXd::Identity(statistics, statistics));
  const Eigen::MatrixXd reduced = cholesky.solve_lower(Eigen::MatrixXd(jacobian));
  Eigen::ArrayXd variance = Eigen::ArrayXd::Zero(terms);
  for (const CoefficientPrior::Block& block : problem.prior.blocks()) {
    const Eigen::VectorXd own = block.factor.rowwise().squaredNorm();
    for (std::size_t i = 0; i < block.index.size(); ++i) variance[block.index[i]] = own[Eigen::Index(i)];
  }
  const Eigen::ArrayXd prior_variance = variance;
  for (Eigen::Index k = 0; k < statistics; ++k)
    variance -= problem.prior.colour(reduced.row(k).transpose()).array().square();
  // For a very well determined coefficient, the subtraction leaves only rounding of the prior variance.
  result->coefficient_std = variance.max(1e-16 * prior_variance).sqrt();

  const Eigen::MatrixXd solved = cholesky.solve(gram);  // J cov J^T = gram - gram M^-1 gram = M^-1 gram
  const auto targets = Eigen::Index(problem.targets.size());
  result->statistic_std.resize(targets);
  for (Eigen::Index k = 0; k < targets; ++k)
    result->statistic_std[k] =
        problem.targets[std::size_t(k)].tolerance * std::sqrt(std::max(0.0, solved(k, k)));
}

}  // namespace aberfit::internal
