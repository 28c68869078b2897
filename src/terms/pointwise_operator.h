#pragma once
#include <cstdint>
#include <vector>

#include "aberfit/core/instruction_set.h"
#include "fourier_kernel.h"
#include "partial_sums.h"
#include "point_coordinates.h"
#include "scratch_pool.h"
#include "term_operator.h"
#include "zernike_kernel.h"

namespace aberfit::internal {

/// The families of terms that a call uses.
struct Families {
  bool zernike = false, fourier = false, spherical = false;
  bool any() const { return zernike || fourier || spherical; }
};

/// L point by point without a stored matrix: Zernike recurrences, Fourier phase sums, spherical powers. It
/// takes any points and subsets. Every other method is tested against it, and falls back to it for few rays.
class PointwiseOperator : public TermOperator {
 public:
  /// `families`: families that forward and adjoint compute; add_adjoint can also compute the others.
  PointwiseOperator(const TermSet& terms, PointCoordinates points, Families families);

  void forward(const Eigen::VectorXd& coefficients, int threads, bool add,
               SurfaceField* field) const override;
  void adjoint(const SurfaceField& weights, int threads, Eigen::VectorXd* sums) const override;

  /// Writes the entries of `families` of L^T g for weights that vanish except at rays[i] (or i if rays is
  /// null).
  void adjoint(const std::uint32_t* rays, const SurfaceField& weights, Families families, int threads,
               Eigen::VectorXd* sums) const;

  Families families() const { return families_; }

 private:
  // A packed vector holds the coefficients in the order of the kernels: Zernike rows (cosine and sine, scaled
  // to the monic polynomials), then A and B per Fourier mode, then the spherical terms.
  std::size_t fourier_at() const { return 2 * zernike_.rows(); }
  std::size_t spherical_at() const { return fourier_at() + 2 * std::size_t(fourier_.modes()); }
  std::size_t packed_size() const { return spherical_at() + spherical_.size(); }
  void pack(const Eigen::VectorXd& coefficients, std::vector<double>* packed) const;
  void forward_block(const double* packed, Eigen::Index begin, int used, bool add, SurfaceField* field) const;
  void adjoint_block(const std::uint32_t* rays, const SurfaceField& weights, Families families,
                     Eigen::Index begin, int used, std::vector<CacheLine>* lanes, double* packed) const;

  double radius_;
  std::vector<int> spherical_;
  ZernikeRows zernike_;
  FourierRows fourier_;
  PointCoordinates points_;
  Families families_;
  InstructionSet set_;
  mutable ScratchPool<std::vector<double>> packed_;
  mutable ScratchPool<PartialSums> sums_;
  mutable ScratchPool<std::vector<CacheLine>> lanes_;
};

}  // namespace aberfit::internal
