#include "aberfit/core/linear_algebra.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <Eigen/SVD>
#include <algorithm>

namespace aberfit {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

SymmetricEigen symmetric_eigen(const MatrixXd& matrix) {
  const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(matrix);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

VectorXd tridiagonal_eigenvalues(const VectorXd& diagonal, const VectorXd& beside) {
  Eigen::SelfAdjointEigenSolver<MatrixXd> solver;
  solver.computeFromTridiagonal(diagonal, beside, Eigen::EigenvaluesOnly);
  return solver.eigenvalues();
}

SingularValues singular_values(const MatrixXd& matrix) {
  const Eigen::BDCSVD<MatrixXd> svd(matrix, Eigen::ComputeFullU | Eigen::ComputeFullV);
  return {svd.matrixU(), svd.matrixV(), svd.singularValues()};
}

VectorXd jacobi_singular_values(const MatrixXd& matrix) {
  return Eigen::JacobiSVD<MatrixXd>(matrix).singularValues();
}

MatrixXd jacobi_right_vectors(const MatrixXd& matrix) {
  return Eigen::JacobiSVD<MatrixXd>(matrix, Eigen::ComputeThinV).matrixV();
}

MatrixXd qr_triangle(const MatrixXd& matrix) {
  const Eigen::HouseholderQR<MatrixXd> qr(matrix);
  MatrixXd triangle = MatrixXd::Zero(matrix.cols(), matrix.cols());
  const Index filled = std::min(matrix.rows(), matrix.cols());
  triangle.topRows(filled) = qr.matrixQR().topRows(filled).triangularView<Eigen::Upper>();
  return triangle;
}

MatrixXd orthonormal_columns(const MatrixXd& matrix) {
  return matrix.householderQr().householderQ() * MatrixXd::Identity(matrix.rows(), matrix.cols());
}

Cholesky::Cholesky(const MatrixXd& matrix) {
  const Eigen::LLT<MatrixXd> cholesky(matrix);
  positive_ = cholesky.info() == Eigen::Success;
  lower_ = cholesky.matrixL();
}

MatrixXd Cholesky::solve_lower(const MatrixXd& right) const {
  return lower_.triangularView<Eigen::Lower>().solve(right);
}

VectorXd Cholesky::solve_lower(const VectorXd& right) const {
  return lower_.triangularView<Eigen::Lower>().solve(right);
}

MatrixXd Cholesky::solve(const MatrixXd& right) const {
  MatrixXd result = solve_lower(right);
  lower_.adjoint().triangularView<Eigen::Upper>().solveInPlace(result);
  return result;
}

VectorXd solve_symmetric(const MatrixXd& matrix, const VectorXd& right) { return matrix.ldlt().solve(right); }

MatrixXd solve_symmetric(const MatrixXd& matrix, const MatrixXd& right) { return matrix.ldlt().solve(right); }

struct LeastNorm::Decomposition {
  Eigen::CompleteOrthogonalDecomposition<MatrixXd> qtz;
};

LeastNorm::LeastNorm(const MatrixXd& matrix)
    : decomposition_(new Decomposition{Eigen::CompleteOrthogonalDecomposition<MatrixXd>(matrix)}) {}

LeastNorm::LeastNorm(const MatrixXd& matrix, double threshold) {
  auto decomposition = std::make_unique<Decomposition>();
  decomposition->qtz.setThreshold(threshold);
  decomposition->qtz.compute(matrix);
  decomposition_ = std::move(decomposition);
}

LeastNorm::~LeastNorm() = default;

VectorXd LeastNorm::solve(const VectorXd& right) const { return decomposition_->qtz.solve(right); }

MatrixXd LeastNorm::solve(const MatrixXd& right) const { return decomposition_->qtz.solve(right); }

struct LeastSquares::Decomposition {
  Eigen::ColPivHouseholderQR<MatrixXd> qr;
};

LeastSquares::LeastSquares(const MatrixXd& matrix)
    : decomposition_(new Decomposition{Eigen::ColPivHouseholderQR<MatrixXd>(matrix)}) {}

LeastSquares::~LeastSquares() = default;

VectorXd LeastSquares::solve(const VectorXd& right) const { return decomposition_->qr.solve(right); }

}  // namespace aberfit
