#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "aberfit/core/instruction_set.h"
#include "aberfit/scene/pupil.h"
#include "aberfit/terms/term_set.h"
#include "fourier_kernel.h"
#include "partial_sums.h"
#include "scratch_pool.h"
#include "zernike_kernel.h"

namespace aberfit::internal {

/// L^T of heights alone for many weights, as a matrix product. L is made block by block and never stored. On
/// a grid that mirrors itself in x and y, up to four points are combined. Terms are even or odd under either
/// reflection, so a quarter of L and of the products suffices, even if some of the four points are missing.
class HeightProducts {
 public:
  /// hold_at_rim: as in OperatorOptions.
  HeightProducts(const TermSet& terms, const PupilSample& pupil, bool hold_at_rim);

  /// terms x weights.size(): column k is L^T of weights[k], one number per point. Threads change no bit.
  Eigen::MatrixXd operator()(std::span<const Eigen::ArrayXd> weights, int threads) const;

 private:
  std::size_t sums_rows() const {
    return 2 * zernike_.rows() + 2 * std::size_t(fourier_.modes()) + spherical_.size();
  }
  void fold(std::span<const Eigen::ArrayXd> weights, Eigen::Index begin, int used, int columns,
            std::size_t of_class, double* to) const;
  void add_block(std::span<const Eigen::ArrayXd> weights, int columns, Eigen::Index begin, int used,
                 std::vector<CacheLine>* scratch, double* sums) const;

  double radius_;
  ZernikeRows zernike_;
  FourierRows fourier_;
  std::vector<int> spherical_;
  bool hold_at_rim_, folded_ = false;
  Eigen::ArrayXd x_, y_;  // of the orbits [m]
  // If folded, four points per orbit: at (x, y), (-x, y), (x, -y), (-x, -y); -1: none. Else empty.
  std::vector<std::int32_t> members_;
  InstructionSet set_;
  mutable ScratchPool<PartialSums> sums_;
  mutable ScratchPool<std::vector<CacheLine>> scratch_;
};

}  // namespace aberfit::internal
