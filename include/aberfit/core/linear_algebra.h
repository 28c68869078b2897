#pragma once
#include <Eigen/Core>
#include <memory>

/// Products and decompositions of dense real matrices by Eigen. They are compiled once, because the templates
/// take minutes to compile. Products, symmetric eigenvalues, Cholesky and the QR triangle use the processor's
/// best instruction set. They take a third of the time of plain Eigen; the bits depend on the processor.
namespace aberfit {

/// The products a b and a^T b of large matrices; for small ones use Eigen's own product.
Eigen::MatrixXd product(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);
Eigen::MatrixXd transposed_product(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);

/// Eigenvalues, ascending, and eigenvectors in columns of a symmetric matrix; only its lower half is used.
struct SymmetricEigen {
  Eigen::VectorXd values;
  Eigen::MatrixXd vectors;
};
SymmetricEigen symmetric_eigen(const Eigen::MatrixXd& matrix);

/// Eigenvalues, ascending, of a symmetric tridiagonal matrix with these elements.
Eigen::VectorXd tridiagonal_eigenvalues(const Eigen::VectorXd& diagonal, const Eigen::VectorXd& beside);

/// Decomposition left diag(values) right^T of a square matrix, values descending.
struct SingularValues {
  Eigen::MatrixXd left, right;
  Eigen::VectorXd values;
};
/// Divide and conquer (Gu & Eisenstat 1995). Error of a value: about 1e-15 of the largest one.
SingularValues singular_values(const Eigen::MatrixXd& matrix);

/// Singular values, or right singular vectors (thin), by descending value. Jacobi rotations, for small
/// matrices.
Eigen::VectorXd jacobi_singular_values(const Eigen::MatrixXd& matrix);
Eigen::MatrixXd jacobi_right_vectors(const Eigen::MatrixXd& matrix);

/// The QR triangle, columns x columns; the last rows are zero if `matrix` has fewer rows than columns.
Eigen::MatrixXd qr_triangle(const Eigen::MatrixXd& matrix);

/// Orthonormal columns; the first k span the same space as the first k of `matrix` (Householder QR).
Eigen::MatrixXd orthonormal_columns(const Eigen::MatrixXd& matrix);

/// L L^T of a symmetric positive definite matrix.
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

/// matrix^-1 right for a symmetric matrix that is positive or negative semidefinite (L D L^T, pivoted).
Eigen::VectorXd solve_symmetric(const Eigen::MatrixXd& matrix, const Eigen::VectorXd& right);
Eigen::MatrixXd solve_symmetric(const Eigen::MatrixXd& matrix, const Eigen::MatrixXd& right);

/// Least squares for any matrix, of least norm without full rank (complete orthogonal decomposition).
class LeastNorm {
 public:
  explicit LeastNorm(const Eigen::MatrixXd& matrix);
  ~LeastNorm();
  Eigen::VectorXd solve(const Eigen::VectorXd& right) const;
  Eigen::MatrixXd solve(const Eigen::MatrixXd& right) const;

 private:
  struct Decomposition;
  std::unique_ptr<const Decomposition> decomposition_;
};

/// Least squares for a matrix of full rank (QR with column pivoting).
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
