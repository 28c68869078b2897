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

/// Weighted least-squares solution of A c = height, with A the heights of the terms at the points (points x
/// terms). Below, rows of A and height are multiplied by root_weight.
struct MapSolution {
  Eigen::VectorXd coefficients;  ///< [m]
  Eigen::MatrixXd root;          ///< (A^T A)^+ = root root^T; empty where it was not computed
  Eigen::VectorXd column_norm;   ///< of A
  int rank = 0;
  double condition_number = 0;  ///< condition number of A with columns of unit length, at most 1 / eps
  bool converged = true;
  /// Components of the weighted residual along further terms, orthonormalised beside the others. leak: part
  /// of each component in the coefficients (terms x components; empty where unknown).
  Eigen::VectorXd beyond;
  Eigen::MatrixXd leak;
};

/// Solution by orthogonal transformations: R of [A | height] block by block, then the singular values of R
/// with its columns scaled. Relative error of the coefficients about 1e-15 times the condition number. Where
/// the rank is short, it has the smallest sum of squares of the coefficients not in `free` (flags, one per
/// term). further: terms of MapSolution::beyond; those that the points do not separate from others are left
/// out.
MapSolution solve_by_qr(const TermSet& terms, const TermSet& further, const MapPoints& points,
                        const std::vector<bool>& free, int threads);

/// Solution by conjugate gradients on the column-scaled normal equations (CGLS, Hestenes & Stiefel 1952,
/// section 10) through the operator, for more terms than a dense matrix allows. The condition number, and so
/// the accuracy, follows from the Lanczos values of the iteration. The rank is not computed; it is set to the
/// number of terms. further: for `beyond`, assumed to be orthogonal on the points as they are on the disc.
MapSolution solve_by_conjugate_gradients(const TermSet& terms, const TermSet& further,
                                         const MapPoints& points, int threads);

}  // namespace aberfit::internal
