#pragma once
#include "aberfit/core/instruction_set.h"

namespace aberfit::internal {

/// Eigen's dense products and decompositions for one instruction set. Matrices are column-major without gaps.
/// Eigen chooses its vectors at compile time, so the rest of the library gets SSE2; these take a third of the
/// time. Each set has Eigen in its own namespace, so that the linker cannot mix the code of two sets.
struct EigenKernels {
  /// Ascending eigenvalues, and eigenvectors in columns, of n x n; only the lower half is used.
  void (*symmetric_eigen)(long n, const double* matrix, double* values, double* vectors);
  /// L of L L^T, zero above the diagonal; false where the matrix is not positive definite.
  bool (*cholesky)(long n, const double* matrix, double* lower);
  /// L^-1 right or L^-T right in place, n x columns.
  void (*solve_lower)(long n, const double* lower, bool transposed, long columns, double* right);
  /// The upper min(rows, columns) x columns part of the triangle of Householder's QR.
  void (*qr_triangle)(long rows, long columns, const double* matrix, double* triangle);
  /// A B or A^T B: rows x inner (or inner x rows) times inner x columns.
  void (*product)(bool transposed, long rows, long inner, long columns, const double* a, const double* b,
                  double* result);
};
const EigenKernels& eigen_kernels(InstructionSet set);

}  // namespace aberfit::internal
