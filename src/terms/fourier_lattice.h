#pragma once
#include <complex>
#include <cstdint>
#include <span>
#include <vector>

#include "aberfit/core/instruction_set.h"
#include "aberfit/roughness/fourier_transform.h"
#include "lattice_kernel.h"
#include "scratch_pool.h"
#include "term_operator.h"

namespace aberfit::internal {

/// Fourier part of L for frequencies on a lattice, at any points (nonuniform fast Fourier transform, PHYSICS
/// 4). It transforms on a grid twice as fine as the waves need, and a kernel connects grid cells and points.
/// Time grows as the points plus N log N of the lattice, memory as either.
class FourierLattice : public TermOperator {
 public:
  /// Throws std::invalid_argument unless terms.fourier_pitch > 0 and all modes are on that lattice to 1e-9 of
  /// it.
  FourierLattice(const TermSet& terms, const Eigen::ArrayXd& x, const Eigen::ArrayXd& y);

  void forward(const Eigen::VectorXd& coefficients, int threads, bool add,
               SurfaceField* field) const override;
  void adjoint(const SurfaceField& weights, int threads, Eigen::VectorXd* sums) const override;

  /// L^T of heights alone: column k of `sums` receives, from row `begin` on, the sums for weights[k].
  void heights(std::span<const Eigen::ArrayXd> weights, int threads, Eigen::Index begin,
               Eigen::MatrixXd* sums) const;

  /// Number of listed rays above which it is faster than phase sums.
  Eigen::Index enough_rays() const;

 private:
  struct Mode {
    std::uint32_t place, opposite;  // index of f and -f in the spectrum
    double scale;                   // inverse of the kernel's transform there
    double turn_x, turn_y;          // 2 pi f [1/m]
  };
  struct Scratch {
    std::vector<CacheLine> grid;  // with margins
    std::vector<std::complex<double>> spectrum;
    std::vector<double> values;
  };
  std::size_t margined() const {
    return std::size_t(side_ + kLatticeTaps) * std::size_t(side_ + kLatticeTaps);
  }
  void to_margined(const std::complex<double>* spectrum, double* grid) const;
  void from_margined(const double* grid, std::complex<double>* spectrum) const;
  template <typename Value>
  void spread_all(int grids, const Value& value, Scratch* scratch) const;

  Eigen::Index begin_;  // index of the first Fourier coefficient
  int side_ = 0;        // side of the fine grid
  std::vector<Mode> modes_;
  std::vector<LatticePlace> places_;
  std::unique_ptr<const FourierTransform> transform_;
  InstructionSet set_;
  mutable ScratchPool<Scratch> scratch_;
};

}  // namespace aberfit::internal
