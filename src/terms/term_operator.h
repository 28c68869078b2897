#pragma once
#include <Eigen/Core>

#include "aberfit/terms/surface_operator.h"

namespace aberfit::internal {

/// Part of L: some families of terms (Zernike, Fourier, spherical) by one method at all points. Coefficient
/// vectors are those of the whole TermSet; a part uses only the entries of its families. Results do not
/// depend on `threads`, and several threads may call it at once.
class TermOperator {
 public:
  virtual ~TermOperator() = default;

  /// Writes its L c to the field (`add` false) or adds it (true). The field has as many entries as points.
  virtual void forward(const Eigen::VectorXd& coefficients, int threads, bool add,
                       SurfaceField* field) const = 0;

  /// Writes its entries of L^T g. There are as many weights as points.
  virtual void adjoint(const SurfaceField& weights, int threads, Eigen::VectorXd* sums) const = 0;
};

/// Writes `from` to the field at `to`, or adds it, for a sequence of points.
inline void deliver(const double* from, Eigen::Index count, bool add, double* to) {
  if (add)
    for (Eigen::Index i = 0; i < count; ++i) to[i] += from[i];
  else
    for (Eigen::Index i = 0; i < count; ++i) to[i] = from[i];
}

}  // namespace aberfit::internal
