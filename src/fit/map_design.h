#pragma once
#include <Eigen/Core>
#include <vector>

#include "aberfit/terms/term_set.h"

namespace aberfit::internal {

/// Heights at points of a map; positions relative to the axis [m].
struct MapPoints {
  Eigen::ArrayXd x, y, height;
  Eigen::ArrayXd root_weight;  ///< square roots of the weights of the points

  Eigen::Index size() const { return x.size(); }
};

/// Weighted least-squares solution of A c = height, A being the heights of the terms at the points (points x
/// terms); below, A and height have their rows multiplied by root_weight.
struct MapSolution {
  Eigen::VectorXd coefficients;  ///< [m]
  Eigen::MatrixXd root;          ///< (A^T A)^+ = root root^T; empty where it was not worked out
  Eigen::VectorXd column_norm;   ///< of A
  int rank = 0;
  double condition_number = 0;  ///< of A with columns of unit length, at most 1 / eps
  bool converged = true;
  /// Components of the weighted residual along further terms, orthonormalised beside the others; and how much
  /// of one of each the coefficients have taken along (terms x components; empty where that is not known).
  Eigen::VectorXd beyond;
  Eigen::MatrixXd leak;
};

/// By orthogonal transformations: R of [A | height] block of points by block of points, then the singular
/// values of R with its columns scaled. Relative error of the coefficients about 1e-15 times the condition
/// number. Where the rank is short, of all solutions that with the smallest sum of squares of the
/// coefficients not in `free` (flags, one per term). `further`: of MapSolution::beyond; those that the points
/// do not tell from others are left out.
MapSolution solve_by_qr(const TermSet& terms, const TermSet& further, const MapPoints& points,
                        const std::vector<bool>& free, int threads);

/// By conjugate gradients on the column-scaled normal equations (CGLS, Hestenes & Stiefel 1952, section 10)
/// through the operator, for more terms than a dense matrix can take. Condition number and so the reached
/// accuracy from the Lanczos values of the iteration; the rank is not found (the number of terms is given).
/// `beyond` is along `further` terms that are taken to be orthogonal on the points as they are on the disc.
MapSolution solve_by_conjugate_gradients(const TermSet& terms, const TermSet& further,
                                         const MapPoints& points, int threads);

}  // namespace aberfit::internal
