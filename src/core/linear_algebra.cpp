#include "aberfit/core/linear_algebra.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <Eigen/SVD>
#include <algorithm>
#include <cassert>

#include "eigen_kernels.h"

namespace aberfit {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

const internal::EigenKernels& kernels() {
  static const internal::EigenKernels& best = internal::eigen_kernels(best_instruction_set());
  return best;
}

}  // namespace

MatrixXd product(const MatrixXd& a, const MatrixXd& b) {
  assert(a.cols() == b.rows());
  MatrixXd result(a.rows(), b.cols());
  kernels().product(false, a.rows(), a.cols(), b.cols(), a.data(), b.data(), result.data());
  return result;
}

MatrixXd transposed_product(const MatrixXd& a, const MatrixXd& b) {
  assert(a.rows() == b.rows());
  MatrixXd result(a.cols(), b.cols());
  kernels().product(true, a.cols(), a.rows(), b.cols(), a.data(), b.data(), result.data());
  return result;
}

SymmetricEigen symmetric_eigen(const MatrixXd& matrix) {
  SymmetricEigen result{VectorXd(matrix.rows()), MatrixXd(matrix.rows(), matrix.rows())};
  kernels().symmetric_eigen(matrix.rows(), matrix.data(), result.values.data(), result.vectors.data());
  return result;
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
  MatrixXd filled(std::min(matrix.rows(), matrix.cols()), matrix.cols());
  kernels().qr_triangle(matrix.rows(), matrix.cols(), matrix.data(), filled.data());
  MatrixXd triangle = MatrixXd::Zero(matrix.cols(), matrix.cols());
  triangle.topRows(filled.rows()) = filled;
  return triangle;
}

MatrixXd orthonormal_columns(const MatrixXd& matrix) {
  return matrix.householderQr().householderQ() * MatrixXd::Identity(matrix.rows(), matrix.cols());
}

Cholesky::Cholesky(const MatrixXd& matrix) {
  lower_.resize(matrix.rows(), matrix.rows());
  positive_ = kernels().cholesky(matrix.rows(), matrix.data(), lower_.data());
}

MatrixXd Cholesky::solve_lower(const MatrixXd& right) const {
  MatrixXd result = right;
  kernels().solve_lower(lower_.rows(), lower_.data(), false, result.cols(), result.data());
  return result;
}

VectorXd Cholesky::solve_lower(const VectorXd& right) const {
  return lower_.triangularView<Eigen::Lower>().solve(right);
}

MatrixXd Cholesky::solve(const MatrixXd& right) const {
  MatrixXd result = solve_lower(right);
  kernels().solve_lower(lower_.rows(), lower_.data(), true, result.cols(), result.data());
  return result;
}

VectorXd solve_symmetric(const MatrixXd& matrix, const VectorXd& right) { return matrix.ldlt().solve(right); }

MatrixXd solve_symmetric(const MatrixXd& matrix, const MatrixXd& right) { return matrix.ldlt().solve(right); }

struct LeastNorm::Decomposition {
  Eigen::CompleteOrthogonalDecomposition<MatrixXd> qtz;
};

LeastNorm::LeastNorm(const MatrixXd& matrix)
    : decomposition_(new Decomposition{Eigen::CompleteOrthogonalDecomposition<MatrixXd>(matrix)}) {}

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
