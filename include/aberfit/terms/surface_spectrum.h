#pragma once
#include <Eigen/Core>
#include <memory>

#include "aberfit/spectrum/psd_estimate.h"
#include "aberfit/terms/surface_operator.h"

namespace aberfit {

/// PSD bins of a term surface: quadratic in the coefficients, with their Jacobian.
class SurfaceSpectrum {
 public:
  virtual ~SurfaceSpectrum() = default;
  virtual Eigen::Index bins() const = 0;
  /// values [m^4]; jacobian (may be null): bins x coefficients.
  virtual void evaluate(const Eigen::VectorXd& coefficients, Eigen::VectorXd* values,
                        Eigen::MatrixXd* jacobian) const = 0;
};

/// Ring-averaged PSD of a Zernike surface over its whole disc, unwindowed, at each bin the average over [low,
/// high] (weight f df): S(f) = |H(f)|^2 / (pi R^2) averaged over directions = sum over signed m of |sum_n
/// a_nm F_nm(f)|^2 in closed form (PHYSICS 4). Zernike terms only: throws std::invalid_argument otherwise.
std::unique_ptr<SurfaceSpectrum> zernike_spectrum(const TermSet& terms, const Eigen::ArrayXd& low,
                                                  const Eigen::ArrayXd& high);

/// Any terms: the surface on a square grid of grid_size x grid_size points in the middle of equal cells over
/// the disc's inscribed square (side sqrt(2) radius) goes through the same estimator (detrend, window, bins)
/// as a measured map; lines are not taken out. `low`, `high` get the edges of the estimator's bins, all of
/// them. Throws std::invalid_argument for a radius that is not positive, a grid below 4 x 4 and a detrending
/// that leaves nothing.
std::unique_ptr<SurfaceSpectrum> estimated_spectrum(const TermSet& terms, const PsdEstimatorOptions& options,
                                                    int grid_size, int threads, Eigen::ArrayXd* low,
                                                    Eigen::ArrayXd* high);

}  // namespace aberfit
