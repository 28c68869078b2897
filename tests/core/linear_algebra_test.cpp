#include "aberfit/core/linear_algebra.h"

#include <gtest/gtest.h>

#include "../../src/core/eigen_kernels.h"
#include "aberfit/core/random.h"

namespace aberfit {
namespace {

Eigen::MatrixXd random_matrix(Eigen::Index rows, Eigen::Index columns, const char* name) {
  const RandomStream stream(11, name);
  Eigen::MatrixXd matrix(rows, columns);
  for (Eigen::Index i = 0; i < matrix.size(); ++i) matrix.data()[i] = stream.normal(std::uint64_t(i));
  return matrix;
}

double gap(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) { return (a - b).norm() / b.norm(); }

// Definitions, for every set of the processor and for sizes that are no multiple of a vector.
TEST(EigenKernels, MeetTheirDefinitionsOnEveryInstructionSet) {
  for (const InstructionSet set :
       {InstructionSet::kBaseline, InstructionSet::kAvx2, InstructionSet::kAvx512}) {
    if (!is_supported(set)) continue;
    const internal::EigenKernels& kernels = internal::eigen_kernels(set);
    const Eigen::Index n = 37, m = 53;
    const Eigen::MatrixXd a = random_matrix(m, n, "a"), right = random_matrix(n, 5, "right");
    Eigen::MatrixXd gram(n, n), there(m, 5);
    kernels.product(true, n, m, n, a.data(), a.data(), gram.data());
    kernels.product(false, m, n, 5, a.data(), right.data(), there.data());
    EXPECT_LT(gap(gram, a.transpose().lazyProduct(a)), 1e-14);
    EXPECT_LT(gap(there, a.lazyProduct(right)), 1e-14);

    Eigen::VectorXd values(n);
    Eigen::MatrixXd vectors(n, n), lower(n, n), triangle(n, n);
    kernels.symmetric_eigen(n, gram.data(), values.data(), vectors.data());
    EXPECT_LT(gap(vectors * values.asDiagonal() * vectors.transpose(), gram), 1e-13);
    EXPECT_LT(gap(vectors.transpose() * vectors, Eigen::MatrixXd::Identity(n, n)), 1e-13);
    EXPECT_TRUE((values.tail(n - 1).array() >= values.head(n - 1).array()).all());

    EXPECT_TRUE(kernels.cholesky(n, gram.data(), lower.data()));
    EXPECT_LT(gap(lower * lower.transpose(), gram), 1e-14);
    EXPECT_EQ(lower(0, n - 1), 0);
    Eigen::MatrixXd solved = right;
    kernels.solve_lower(n, lower.data(), false, 5, solved.data());
    EXPECT_LT(gap(lower * solved, right), 1e-13);
    solved = right;
    kernels.solve_lower(n, lower.data(), true, 5, solved.data());
    EXPECT_LT(gap(lower.transpose() * solved, right), 1e-13);
    const Eigen::MatrixXd negative = -gram;
    EXPECT_FALSE(kernels.cholesky(n, negative.data(), lower.data()));

    kernels.qr_triangle(m, n, a.data(), triangle.data());
    EXPECT_LT(gap(triangle.transpose() * triangle, gram), 1e-13);
    EXPECT_EQ(triangle(n - 1, 0), 0);
  }
}

TEST(LinearAlgebra, ProductsAreThoseOfTheirSums) {
  const Eigen::MatrixXd a = random_matrix(41, 23, "a"), b = random_matrix(23, 17, "b"),
                        c = random_matrix(41, 9, "c");
  EXPECT_LT(gap(product(a, b), a.lazyProduct(b)), 1e-14);
  EXPECT_LT(gap(transposed_product(a, c), a.transpose().lazyProduct(c)), 1e-14);
}

}  // namespace
}  // namespace aberfit
