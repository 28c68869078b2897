#pragma once
#include "aberfit/core/instruction_set.h"

namespace aberfit::internal {

/// Eigen's dense products and decompositions compiled for one instruction set; matrices column after column,
/// without gaps. Eigen picks its vectors when it is compiled, so that what the whole library includes is
/// SSE2: these are a third of the time. Each set has Eigen in a namespace of its own, lest the linker give
/// one set's code to another.
struct EigenKernels {
  /// Of n x n, the lower half read: values ascending, vectors in columns.
  void (*symmetric_eigen)(long n, const double* matrix, double* values, double* vectors);
  /// L of L L^T, zero above the diagonal; false where the matrix is not positive definite.
  bool (*cholesky)(long n, const double* matrix, double* lower);
  /// L^-1 right or L^-T right in place, n x columns.
  void (*solve_lower)(long n, const double* lower, bool transposed, long columns, double* right);
  /// The upper min(rows, columns) x columns of the triangle of Householder's QR.
  void (*qr_triangle)(long rows, long columns, const double* matrix, double* triangle);
  /// A B or A^T B: rows x inner (or inner x rows) times inner x columns.
  void (*product)(bool transposed, long rows, long inner, long columns, const double* a, const double* b,
                  double* result);
};
const EigenKernels& eigen_kernels(InstructionSet set);

}  // namespace aberfit::internal
