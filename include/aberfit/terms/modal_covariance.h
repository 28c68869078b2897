#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "aberfit/roughness/psd.h"
#include "aberfit/terms/term_set.h"

namespace aberfit {

/// Covariances <a_j a_j'> [m^2] of the orthonormal Zernike coefficients of a stationary isotropic surface
/// over a disc of `radius` [m], for one signed m (PHYSICS 4, after Noll 1976). They vanish between different
/// m and do not depend on its sign. n_values: radial orders of that m, ascending. Error below 1e-9 sqrt(C_jj
/// C_kk). Throws ComputationError when the integral diverges, e.g. piston of a power law down to f = 0.
Eigen::MatrixXd zernike_covariance(const RadialPsd& psd, double radius, int m,
                                   const std::vector<int>& n_values);

enum class CovarianceKind {
  kFull,
  kDiagonal,  ///< the independent coefficients of the paper; they overstate the slope at the rim (PHYSICS 4)
};

/// Gaussian prior of a coefficient vector: zero mean and a block-diagonal covariance, each block = factor *
/// factor^T. It turns white coordinates xi into coefficients, c = F xi, and gradients back, F^T g. Each
/// coefficient belongs to exactly one block.
class CoefficientPrior {
 public:
  struct Block {
    std::vector<Eigen::Index> index;  ///< coefficients of the block
    Eigen::MatrixXd factor;           ///< index.size() x index.size() [m]
  };
  CoefficientPrior() = default;
  CoefficientPrior(Eigen::Index size, std::vector<Block> blocks);

  Eigen::Index size() const { return size_; }
  const std::vector<Block>& blocks() const { return blocks_; }
  /// c = F xi.
  Eigen::VectorXd colour(const Eigen::VectorXd& white) const;
  /// F^T g.
  Eigen::VectorXd colour_transpose(const Eigen::VectorXd& gradient) const;

 private:
  Eigen::Index size_ = 0;
  std::vector<Block> blocks_;
};

/// Prior of Zernike and Fourier terms of one PSD. Zernike terms follow `zernike_covariance` for each signed
/// m. Fourier amplitudes A and B are independent. Their variance is that of the mode's part of the band, so
/// that the surface has the height variance of the PSD (see `fourier_modes`). A lattice mode has the variance
/// of its grid cell. With both kinds the PSD is divided at the cut-off frequency of the Zernike terms, (n_max
/// + 1) / (2 pi R). Spherical terms and segments have no PSD; the caller appends `spherical_prior_block` and
/// `segment_prior_blocks`.
CoefficientPrior make_prior(const TermSet& terms, const RadialPsd& psd, CovarianceKind kind);

/// Block of the spherical terms. Raw powers overlap strongly, so the block uses orthonormal combinations of
/// them. `rms` [m] is the prior standard deviation of the RMS height over the disc of each combination.
CoefficientPrior::Block spherical_prior_block(const TermSet& terms, double rms);

/// Blocks of the segment errors, which are independent with the standard deviations of terms.segments.
std::vector<CoefficientPrior::Block> segment_prior_blocks(const TermSet& terms);

/// Standard normal vector of `size` entries from the stream ("coefficient-draw", seed): white coordinates.
Eigen::VectorXd draw_white(Eigen::Index size, std::uint64_t seed);

/// Fraction of the PSD's height variance over the disc in Zernike terms n_min..n_max.
double captured_fraction(const RadialPsd& psd, double radius, int n_min, int n_max);

/// `count` plane waves of the half plane that sample the PSD's band: log-uniform rings with golden-angle
/// directions (stratified by seed). make_prior gives each wave its part of the height variance.
std::vector<FourierMode> fourier_modes(const RadialPsd& psd, int count, std::uint64_t seed);

/// The plane waves of the half plane at lattice points (i, j) pitch [cycles/m] whose square cells overlap the
/// band of the PSD, by rising |f|. There is one wave for f and -f; 0 is excluded. For a band without an upper
/// end they stop where 1e-4 of the height variance remains. With this pitch in TermSet::fourier_pitch,
/// make_prior gives each wave the variance of its cell. A realisation then has period 1/pitch and the PSD of
/// the band. Throws ComputationError for more than kMostLatticeModes.
std::vector<FourierMode> fourier_lattice(const RadialPsd& psd, double pitch);
inline constexpr double kMostLatticeModes = 1e6;

}  // namespace aberfit
