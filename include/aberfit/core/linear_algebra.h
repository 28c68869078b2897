#pragma once
#include <Eigen/Core>
#include <memory>

/// Products and decompositions of dense real matrices, Eigen's: compiled once, because its templates for them
/// take minutes. Products, symmetric eigenvalues, Cholesky's and the triangle of QR by the processor's best
/// instruction set: a third of the time of Eigen as everything else includes it, and the same bits on one
/// kind of processor.
namespace aberfit {

/// a b and a^T b of large matrices; where Eigen's own product costs nothing that counts, it reads better.
Eigen::MatrixXd product(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);
Eigen::MatrixXd transposed_product(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);

/// Of a symmetric matrix, of which the lower half is read: values ascending, vectors in columns.
struct SymmetricEigen {
  Eigen::VectorXd values;
  Eigen::MatrixXd vectors;
};
SymmetricEigen symmetric_eigen(const Eigen::MatrixXd& matrix);

/// Eigenvalues, ascending, of a symmetric matrix with this diagonal and these elements beside it.
Eigen::VectorXd tridiagonal_eigenvalues(const Eigen::VectorXd& diagonal, const Eigen::VectorXd& beside);

/// left diag(values) right^T of a square matrix, values descending.
struct SingularValues {
  Eigen::MatrixXd left, right;
  Eigen::VectorXd values;
};
/// By divide and conquer (Gu & Eisenstat 1995): error of a value about 1e-15 of the largest one.
SingularValues singular_values(const Eigen::MatrixXd& matrix);

/// By Jacobi rotations, for small matrices: the values alone, or the right singular vectors (thin), both by
/// descending value.
Eigen::VectorXd jacobi_singular_values(const Eigen::MatrixXd& matrix);
Eigen::MatrixXd jacobi_right_vectors(const Eigen::MatrixXd& matrix);

/// The triangle of the QR decomposition: columns x columns, with zero rows below where `matrix` has fewer
/// rows than columns.
Eigen::MatrixXd qr_triangle(const Eigen::MatrixXd& matrix);

/// Orthonormal columns of which the first k span what the first k of `matrix` span (Householder QR).
Eigen::MatrixXd orthonormal_columns(const Eigen::MatrixXd& matrix);

/// Of a symmetric positive definite matrix: L L^T.
class Cholesky {
 public:
  explicit Cholesky(const Eigen::MatrixXd& matrix);
  /// False where the matrix is not positive definite.
  bool positive() const { return positive_; }
  /// L, zero above the diagonal.
  const Eigen::MatrixXd& lower() const { return lower_; }
  /// L^-1 right.
  Eigen::MatrixXd solve_lower(const Eigen::MatrixXd& right) const;
  Eigen::VectorXd solve_lower(const Eigen::VectorXd& right) const;
  /// (L L^T)^-1 right.
  Eigen::MatrixXd solve(const Eigen::MatrixXd& right) const;

 private:
  Eigen::MatrixXd lower_;
  bool positive_;
};

/// matrix^-1 right of a symmetric matrix that is positive or negative semidefinite (L D L^T, pivoted).
Eigen::VectorXd solve_symmetric(const Eigen::MatrixXd& matrix, const Eigen::VectorXd& right);
Eigen::MatrixXd solve_symmetric(const Eigen::MatrixXd& matrix, const Eigen::MatrixXd& right);

/// Least squares of any matrix; where it has less than full rank, the solution of least norm (complete
/// orthogonal decomposition).
class LeastNorm {
 public:
  explicit LeastNorm(const Eigen::MatrixXd& matrix);
  /// `threshold`: pivots below this share of the largest are none.
  LeastNorm(const Eigen::MatrixXd& matrix, double threshold);
  ~LeastNorm();
  Eigen::VectorXd solve(const Eigen::VectorXd& right) const;
  Eigen::MatrixXd solve(const Eigen::MatrixXd& right) const;

 private:
  struct Decomposition;
  std::unique_ptr<const Decomposition> decomposition_;
};

/// Least squares of a matrix of full rank (QR with column pivoting).
class LeastSquares {
 public:
  explicit LeastSquares(const Eigen::MatrixXd& matrix);
  ~LeastSquares();
  Eigen::VectorXd solve(const Eigen::VectorXd& right) const;

 private:
  struct Decomposition;
  std::unique_ptr<const Decomposition> decomposition_;
};

}  // namespace aberfit
