// Rows of the design come from one SurfaceOperator per term and block of points. A single term costs one
// recurrence up to its own order, so that a block of P terms costs about P n_max / 4 term-points. One
// operator of all terms applied to P unit vectors would cost P^2. Measured (release, one thread, AVX-512):
// 122,725 points in 0.10 s for 36 terms, 1.5 s for 231.
#include "map_design.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "aberfit/core/linear_algebra.h"
#include "aberfit/core/parallel.h"
#include "aberfit/terms/surface_operator.h"

namespace aberfit::internal {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Singular values below this fraction of the largest are rounding of the basis.
constexpr double kNumericalRank = 1e-12;
constexpr Index kBlockPoints = 1024;
// Number of blocks whose triangles are kept at a time; they are stacked in a fixed order for any thread
// count.
constexpr Index kWaveBlocks = 16;

// Rows begin .. begin + size of the weighted A.
MatrixXd design_of(const TermSet& terms, const MapPoints& points, Index begin, Index size) {
  const Eigen::ArrayXd x = points.x.segment(begin, size), y = points.y.segment(begin, size);
  MatrixXd design(size, terms.size());
  SurfaceField field;
  Index column = 0;
  const auto add = [&](const TermSet& one) {
    const SurfaceOperator surface(one, x, y, 1);
    for (Index k = 0; k < one.size(); ++k) {
      surface.apply(VectorXd::Unit(one.size(), k), &field);
      design.col(column++) = field.height * points.root_weight.segment(begin, size);
    }
  };
  for (const ZernikeMode& mode : terms.zernike) add({terms.radius, {mode}, {}, {}});
  for (const FourierMode& mode : terms.fourier) add({terms.radius, {}, {mode}, {}});
  for (const int power : terms.spherical) add({terms.radius, {}, {}, {power}});
  return design;
}

// R of [A | further | height] by triangles of blocks (Demmel, Grigori, Hoemmen & Langou 2012, TSQR).
MatrixXd factor_of(const TermSet& terms, const TermSet& further, const MapPoints& points, int threads) {
  const Index columns = terms.size() + further.size() + 1, block_points = std::max(kBlockPoints, 4 * columns);
  const Index blocks = (points.size() + block_points - 1) / block_points;
  MatrixXd factor = MatrixXd::Zero(columns, columns);
  for (Index wave = 0; wave < blocks; wave += kWaveBlocks) {
    const Index count = std::min(kWaveBlocks, blocks - wave);
    MatrixXd stack((count + 1) * columns, columns);
    stack.topRows(columns) = factor;
    parallel_for(std::size_t(count), threads, [&](std::size_t b) {
      const Index begin = (wave + Index(b)) * block_points;
      const Index size = std::min(block_points, points.size() - begin);
      MatrixXd rows(size, columns);
      rows.leftCols(terms.size()) = design_of(terms, points, begin, size);
      rows.middleCols(terms.size(), further.size()) = design_of(further, points, begin, size);
      rows.col(columns - 1) = points.height.segment(begin, size) * points.root_weight.segment(begin, size);
      stack.middleRows((Index(b) + 1) * columns, columns) = qr_triangle(rows);
    });
    factor = qr_triangle(stack);
  }
  return factor;
}

VectorXd column_norms(const TermSet& terms, const MapPoints& points, int threads) {
  const Index blocks = (points.size() + kBlockPoints - 1) / kBlockPoints;
  MatrixXd squares(terms.size(), blocks);
  parallel_for(std::size_t(blocks), threads, [&](std::size_t b) {
    const Index begin = Index(b) * kBlockPoints, size = std::min(kBlockPoints, points.size() - begin);
    squares.col(Index(b)) = design_of(terms, points, begin, size).colwise().squaredNorm().transpose();
  });
  return squares.rowwise().sum().cwiseSqrt();
}

// A column of zeros (the sine of frequency 0) stays as it is and reduces the rank.
VectorXd inverse_scale(const VectorXd& norm) {
  return norm.unaryExpr([](double n) { return n > 0 ? 1 / n : 1.0; });
}

double bounded_ratio(double largest, double smallest) {
  const double eps = std::numeric_limits<double>::epsilon();
  return largest > 0 ? largest / std::max(smallest, eps * largest) : 1 / eps;
}

// Moves coefficients and root along the null space to the smallest norm of those not in `free`.
void to_minimum_norm(const MatrixXd& null_space, const std::vector<bool>& free, MapSolution* solution) {
  std::vector<Index> counted;
  for (Index j = 0; j < null_space.rows(); ++j)
    if (!free[std::size_t(j)]) counted.push_back(j);
  const LeastNorm reach(null_space(counted, Eigen::all));
  const VectorXd step = reach.solve(VectorXd(solution->coefficients(counted)));
  solution->coefficients -= null_space * step;
  const MatrixXd steps = reach.solve(MatrixXd(solution->root(counted, Eigen::all)));
  solution->root -= null_space * steps;
}

// Fills `beyond` and `leak` from R. Its last column, in the rows of the further terms, is the residual along
// the columns of Q orthogonal to the first `count`. left: of R's first columns, scaled.
void fill_beyond(const MatrixXd& factor, Index count, const MatrixXd& left, MapSolution* solution) {
  constexpr double kTold = 1e-6;  // fraction of a column's length; a smaller independent part is rounding
  std::vector<Index> told;
  for (Index k = count; k + 1 < factor.cols(); ++k)
    if (std::abs(factor(k, k)) > kTold * factor.col(k).norm()) told.push_back(k);
  solution->beyond = factor.rightCols(1)(told, 0);
  const MatrixXd own = factor(told, told), shared = factor.topRows(count)(Eigen::all, told);
  const MatrixXd per_component = own.triangularView<Eigen::Upper>().solve<Eigen::OnTheRight>(shared);
  solution->leak = solution->root * (left.transpose() * per_component);
}

}  // namespace

MapSolution solve_by_qr(const TermSet& terms, const TermSet& further, const MapPoints& points,
                        const std::vector<bool>& free, int threads) {
  const Index count = terms.size();
  const MatrixXd factor = factor_of(terms, further, points, threads);
  const VectorXd height = factor.rightCols(1).topRows(count);
  MapSolution solution;
  solution.column_norm = factor.leftCols(count).colwise().norm().transpose();
  const VectorXd inverse = inverse_scale(solution.column_norm);
  const MatrixXd scaled = factor.topLeftCorner(count, count) * inverse.asDiagonal();
  const SingularValues svd = singular_values(scaled);
  const VectorXd& singular = svd.values;
  const Index rank = (singular.array() > kNumericalRank * singular[0]).count();
  solution.rank = int(rank);
  solution.condition_number = bounded_ratio(singular[0], singular[count - 1]);
  solution.root =
      inverse.asDiagonal() * svd.right.leftCols(rank) * singular.head(rank).cwiseInverse().asDiagonal();
  solution.coefficients = solution.root * (svd.left.leftCols(rank).transpose() * height);
  fill_beyond(factor, count, svd.left.leftCols(rank), &solution);
  if (rank == count) return solution;
  // Where columns differ by many powers of ten, the null space is rounding, and a step along it may destroy
  // the fit. The solution of least norm in scaled coefficients is kept then.
  MapSolution shorter = solution;
  to_minimum_norm(inverse.asDiagonal() * svd.right.rightCols(count - rank), free, &shorter);
  const auto misfit = [&](const MapSolution& s) {
    return (factor.topLeftCorner(count, count).triangularView<Eigen::Upper>() * s.coefficients - height)
        .norm();
  };
  const double slack = 1e-9 * factor.rightCols(1).norm();
  return misfit(shorter) <= misfit(solution) + slack ? shorter : solution;
}

MapSolution solve_by_conjugate_gradients(const TermSet& terms, const TermSet& further,
                                         const MapPoints& points, int threads) {
  constexpr int kIterations = 5000;
  constexpr double kRelativeGradient = 1e-13;
  MapSolution solution;
  solution.column_norm = column_norms(terms, points, threads);
  solution.rank = int(terms.size());
  const VectorXd inverse = inverse_scale(solution.column_norm);
  const SurfaceOperator surface(terms, points.x, points.y, threads);
  SurfaceField field, weights;
  weights.resize(points.size());
  weights.slope_x.setZero();
  weights.slope_y.setZero();
  const auto gradient = [&](const Eigen::ArrayXd& residual) -> VectorXd {
    weights.height = residual * points.root_weight;
    return inverse.cwiseProduct(surface.apply_transpose(weights));
  };

  VectorXd scaled = VectorXd::Zero(terms.size());
  Eigen::ArrayXd residual = points.height * points.root_weight;
  VectorXd descent = gradient(residual), direction = descent;
  const double first = descent.squaredNorm();
  double now = first;
  std::vector<double> diagonal, beside;  // Lanczos matrix of the normal equations
  double alpha_before = 1, beta = 0;
  for (int i = 0; i < kIterations && now > kRelativeGradient * kRelativeGradient * first; ++i) {
    surface.apply(inverse.cwiseProduct(direction), &field);
    field.height *= points.root_weight;
    const double alpha = now / field.height.matrix().squaredNorm();
    scaled += alpha * direction;
    residual -= alpha * field.height;
    descent = gradient(residual);
    if (i > 0) beside.push_back(std::sqrt(beta) / alpha_before);
    diagonal.push_back(1 / alpha + (i > 0 ? beta / alpha_before : 0.0));
    const double next = descent.squaredNorm();
    beta = next / now;
    direction = descent + beta * direction;
    alpha_before = alpha;
    now = next;
  }
  solution.converged = now <= kRelativeGradient * kRelativeGradient * first;
  solution.coefficients = inverse.cwiseProduct(scaled);
  weights.height = residual * points.root_weight;
  solution.beyond =
      inverse_scale(column_norms(further, points, threads))
          .cwiseProduct(SurfaceOperator(further, points.x, points.y, threads).apply_transpose(weights));
  if (diagonal.empty()) return solution;
  const VectorXd values =
      tridiagonal_eigenvalues(Eigen::Map<const VectorXd>(diagonal.data(), Index(diagonal.size())),
                              Eigen::Map<const VectorXd>(beside.data(), Index(beside.size())));
  solution.condition_number = std::sqrt(bounded_ratio(values[values.size() - 1], std::max(values[0], 0.0)));
  return solution;
}

}  // namespace aberfit::internal
