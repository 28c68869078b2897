#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "aberfit/roughness/psd.h"
#include "aberfit/terms/term_set.h"

namespace aberfit {

/// Covariances <a_j a_j'> [m^2] of the orthonormal Zernike coefficients of a stationary isotropic surface
/// over a disc of `radius` [m], for one signed m (they vanish between different m and do not depend on its
/// sign): PHYSICS 4, after Noll 1976. n_values: radial orders of that m, ascending. Error below 1e-9
/// sqrt(C_jj C_kk). Throws ComputationError where the integral diverges (piston of a power law down to f = 0,
/// say).
Eigen::MatrixXd zernike_covariance(const RadialPsd& psd, double radius, int m,
                                   const std::vector<int>& n_values);

enum class CovarianceKind {
  kFull,
  kDiagonal,  ///< the paper's independent coefficients: piles slope up at the rim (PHYSICS 4)
};

/// Gaussian prior of a coefficient vector, zero mean, block-diagonal covariance, each block = factor *
/// factor^T. Turns white coordinates xi into coefficients, c = F xi, and gradients back, F^T g. Covers every
/// coefficient exactly once.
class CoefficientPrior {
 public:
  struct Block {
    std::vector<Eigen::Index> index;  ///< coefficients it covers
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
  /// xi with F xi = c, by least squares within each block.
  Eigen::VectorXd whiten(const Eigen::VectorXd& coefficients) const;

 private:
  Eigen::Index size_ = 0;
  std::vector<Block> blocks_;
};

/// Prior of Zernike and Fourier terms that share a PSD. Zernikes: `zernike_covariance` per signed m. Fourier:
/// independent, A and B of a mode with the variance of its share of the band, so that the surface has the
/// PSD's height variance (see `fourier_modes`), and of a mode of a lattice with that of its cell. With both
/// kinds the PSD is split at the cut-off frequency of the Zernikes, (n_max + 1) / (2 pi R). Spherical terms
/// have no PSD, nor have segments: blocks for them are appended by the caller with `spherical_prior_block`
/// and `segment_prior_blocks`.
CoefficientPrior make_prior(const TermSet& terms, const RadialPsd& psd, CovarianceKind kind);

/// Spherical terms: prior standard deviation `rms` [m] for the RMS height over the disc of each of a set of
/// orthonormalised combinations (raw powers overlap strongly; the orthonormalised ones are well scaled).
CoefficientPrior::Block spherical_prior_block(const TermSet& terms, double rms);

/// Errors of segments: every one independent, with the standard deviations that terms.segments has.
std::vector<CoefficientPrior::Block> segment_prior_blocks(const TermSet& terms);

/// Standard normal vector of `size` entries, stream ("coefficient-draw", seed): white coordinates of a seeded
/// draw.
Eigen::VectorXd draw_white(Eigen::Index size, std::uint64_t seed);

/// Share of the PSD's height variance over the disc that Zernikes n_min..n_max carry, sum of variances /
/// height variance of the band.
double captured_fraction(const RadialPsd& psd, double radius, int n_min, int n_max);

/// `count` plane waves of the half plane that sample the PSD's band: log-uniform rings with golden-angle
/// directions (stratified by seed). The share of height variance each stands for is what make_prior gives it.
std::vector<FourierMode> fourier_modes(const RadialPsd& psd, int count, std::uint64_t seed);

/// The plane waves of the half plane at all points (i, j) pitch [cycles/m] whose cells, squares of that
/// pitch, have part of the band of the PSD: one of f and -f, by rising |f|; not 0, whose cell is not the
/// waves'. Of a band without an upper end up to where 1e-4 of the height variance is left. With their pitch
/// in TermSet::fourier_pitch make_prior gives each the variance of its cell, and a draw is periodic over
/// 1/pitch and has the PSD of the band. Throws ComputationError for more than kMostLatticeModes.
std::vector<FourierMode> fourier_lattice(const RadialPsd& psd, double pitch);
inline constexpr double kMostLatticeModes = 1e6;

}  // namespace aberfit
