#pragma once
#include <complex>
#include <vector>

#include "aberfit/core/instruction_set.h"
#include "aberfit/scene/pupil.h"
#include "line_transforms.h"
#include "partial_sums.h"
#include "polar_kernel.h"
#include "scratch_pool.h"
#include "term_operator.h"
#include "zernike_kernel.h"

namespace aberfit::internal {

/// Zernike part of L on rings of equally spaced points. On a ring of S points all terms of one m have the
/// same angular factor. So we sum over the radial orders first, which takes rows x rings operations. Then one
/// transform over the angle suffices for any number of terms.
///
/// With h = Re sum_m c_m(tau) z^m, c_m = A_m - i B_m the sums over the radial order, the gradient is one
/// complex field whose spectrum needs neither a rotation nor a division by rho:
///     dh/dx + i dh/dy = sum_m up_m e^(i (m+1) phi) + down_m e^(-i (m-1) phi),
///     up_m = 4 c'_m z0^(m+1),  down_m = conj((m c_m + 4 rho^2 c'_m) z0^(m-1)),
/// phi = 2 pi j / S the angle from the ring's first point z0 = rho e^(i turn). (d/dx + i d/dy = 2 d/d(conj
/// z), and Re f = (f + conj f) / 2.) Frequencies count modulo S, which is exact at the points, also for
/// orders above S / 2.
class ZernikePolar : public TermOperator {
 public:
  ZernikePolar(const TermSet& terms, const PolarRings& rings);

  void forward(const Eigen::VectorXd& coefficients, int threads, bool add,
               SurfaceField* field) const override;
  void adjoint(const SurfaceField& weights, int threads, Eigen::VectorXd* sums) const override;

 private:
  using Complex = std::complex<double>;
  /// Position of order m in the spectra of a ring.
  struct Fold {
    int height, up, down;  ///< frequency of the real spectrum, 0 .. S/2, and of the complex one, 0 .. S - 1
    bool height_conj;      ///< m aliases to S - height
    double height_factor;  ///< 1/2, or 1 if a frequency equals its negative
  };
  struct Scratch {
    std::vector<RingOrder> orders;
    std::vector<CacheLine> memory, lanes;
    Complex *half_spectrum, *spectrum, *slopes;
    double* heights;
  };
  void prepare(Scratch* scratch) const;
  RingBlock block_of(Eigen::Index begin) const;
  void forward_ring(int lane, Eigen::Index ring, bool add, Scratch* scratch, SurfaceField* field) const;
  void adjoint_ring(int lane, Eigen::Index ring, const SurfaceField& weights, Scratch* scratch) const;

  ZernikeRows rows_;
  Eigen::ArrayXd x_, y_;  // first points of the rings, in units of the radius
  Eigen::Index spokes_;
  double slope_unit_;  // 1 / radius
  std::vector<Fold> folds_;
  LineTransforms transforms_;
  InstructionSet set_;
  mutable ScratchPool<std::vector<double>> packed_;
  mutable ScratchPool<PartialSums> sums_;
  mutable ScratchPool<Scratch> scratch_;
};

}  // namespace aberfit::internal
