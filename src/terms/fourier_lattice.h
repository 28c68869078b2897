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

/// Fourier part of L where all frequencies are points of a lattice, on any points: one transform on a grid
/// twice as fine as the waves need, from whose cells a kernel carries to the points and back (a nonuniform
/// fast Fourier transform, PHYSICS 4). Time goes as the points plus N log N of the lattice, memory as either.
class FourierLattice : public TermOperator {
 public:
  /// terms.fourier_pitch has to be positive, and every mode a point of that lattice to 1e-9 of the pitch, or
  /// std::invalid_argument.
  FourierLattice(const TermSet& terms, const Eigen::ArrayXd& x, const Eigen::ArrayXd& y);

  void forward(const Eigen::VectorXd& coefficients, int threads, bool add,
               SurfaceField* field) const override;
  void adjoint(const SurfaceField& weights, int threads, Eigen::VectorXd* sums) const override;

  /// L^T of heights alone: column k of `sums` gets, from row `begin` on, that of weights[k].
  void heights(std::span<const Eigen::ArrayXd> weights, int threads, Eigen::Index begin,
               Eigen::MatrixXd* sums) const;

  /// Listed rays from which on it is faster than phase sums.
  Eigen::Index enough_rays() const;

 private:
  struct Mode {
    std::uint32_t place, opposite;  // of f and -f in the spectrum
    double scale;                   // 1 over the kernel's transform there
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

  Eigen::Index begin_;  // first Fourier coefficient
  int side_ = 0;        // of the fine grid
  std::vector<Mode> modes_;
  std::vector<LatticePlace> places_;
  std::unique_ptr<const FourierTransform> transform_;
  InstructionSet set_;
  mutable ScratchPool<Scratch> scratch_;
};

}  // namespace aberfit::internal
