#pragma once
#include <Eigen/Core>
#include <memory>

#include "aberfit/spectrum/psd_estimate.h"
#include "aberfit/terms/surface_operator.h"

namespace aberfit {

/// PSD bins of a term surface, which are quadratic in the coefficients, with their Jacobian.
class SurfaceSpectrum {
 public:
  virtual ~SurfaceSpectrum() = default;
  virtual Eigen::Index bins() const = 0;
  /// values [m^4]; jacobian (may be null): bins x coefficients.
  virtual void evaluate(const Eigen::VectorXd& coefficients, Eigen::VectorXd* values,
                        Eigen::MatrixXd* jacobian) const = 0;
};

/// Ring-averaged PSD of a Zernike surface over its whole disc, without a window. Each bin is the average over
/// [low, high] with weight f df. S(f) = |H(f)|^2 / (pi R^2) averaged over directions = sum over signed m of
/// |sum_n a_nm F_nm(f)|^2 in closed form (PHYSICS 4). Throws std::invalid_argument for other terms.
std::unique_ptr<SurfaceSpectrum> zernike_spectrum(const TermSet& terms, const Eigen::ArrayXd& low,
                                                  const Eigen::ArrayXd& high);

/// PSD of any terms by the estimator of measured maps (detrending, window, bins; lines are not removed). The
/// surface is sampled at grid_size x grid_size cell centres over the square inscribed in the disc, of side
/// sqrt(2) radius. `low` and `high` receive the edges of all bins of the estimator. Throws
/// std::invalid_argument for a radius that is not positive, a grid below 4 x 4 and a detrending that leaves
/// nothing.
std::unique_ptr<SurfaceSpectrum> estimated_spectrum(const TermSet& terms, const PsdEstimatorOptions& options,
                                                    int grid_size, int threads, Eigen::ArrayXd* low,
                                                    Eigen::ArrayXd* high);

}  // namespace aberfit
