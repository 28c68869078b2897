#pragma once
#include <vector>

#include "aberfit/core/instruction_set.h"
#include "dense_kernel.h"
#include "partial_sums.h"
#include "point_coordinates.h"
#include "scratch_pool.h"
#include "term_operator.h"

namespace aberfit::internal {

/// Part of L as a stored basis, 24 bytes per point and term, built once by the recurrences. Products are
/// bound by the reading of the basis, so this is for small problems.
class DenseOperator : public TermOperator {
 public:
  /// The Zernike terms of the set (`fourier` false) or its Fourier terms (true).
  DenseOperator(const TermSet& terms, bool fourier, const PointCoordinates& points, int threads);

  void forward(const Eigen::VectorXd& coefficients, int threads, bool add,
               SurfaceField* field) const override;
  void adjoint(const SurfaceField& weights, int threads, Eigen::VectorXd* sums) const override;

 private:
  const double* basis_of(Eigen::Index block) const;
  void fill(int term, const SurfaceField& field);

  Eigen::Index points_, begin_;  // first coefficient
  int terms_;
  std::vector<CacheLine> basis_;
  InstructionSet set_;
  mutable ScratchPool<PartialSums> sums_;
};

}  // namespace aberfit::internal
