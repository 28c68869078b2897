#pragma once
#include <Eigen/Core>
#include <vector>

#include "aberfit/focus/statistic.h"
#include "aberfit/roughness/psd_derivative.h"
#include "aberfit/theory/generalised_harvey_shack.h"
#include "aberfit/theory/light_property.h"

namespace aberfit {

/// Statistics of generalised Harvey-Shack and their derivatives over the parameters of a PSD.
struct PsdJacobian {
  std::vector<PsdVariable> parameters;
  Eigen::VectorXd parameter_values;
  Eigen::VectorXd values;  ///< [unit of the statistic], bit-identical to those of GeneralisedHarveyShack
  /// statistics x parameters [statistic's unit per parameter's unit]. NaN for values that are not finite.
  Eigen::MatrixXd derivatives;

  /// d ln(statistic)/d ln(parameter).
  Eigen::MatrixXd logarithmic() const;
};

/// Derivatives without differences of the roughness. The transfer function is linear in H = exp(-E), so its
/// change is -dE/dp H. dE/dp is the structure function of dS/dp (`PsdDerivative`), on separate panels that
/// resolve it to 1e-12. Statistics that an equation defines use the implicit function theorem. For a radius,
/// dr/dp = -(dE(r)/dp)/(dE(r)/dr). For a full width the half crossings move, with the peak and with the ring.
/// RMS height, RMS and mean scatter angle are linear in S or a root of it.
///
/// light: further rows after those of `statistics`, for the same pupil. Irradiance, transfer function and
/// ensquared energy are linear in H as encircled energy is; PSSN is quadratic. Sides and widths use the
/// implicit function theorem; 1 - core uses the height variance.
///
/// Relative error 1e-9 against the form of the theory that `pupil` selects, and 1e-8 for a ring_fwhm
/// (eighth-order difference over the plane). The exact form interpolates H over the aperture to 2e-6, and so
/// its derivatives. A PatchBsdf and the Strehl ratio of a pupil without symmetry use central differences of
/// 1e-3, error about 1e-6. The cost is one structure function and one set of panels per parameter and plane.
/// Throws as GeneralisedHarveyShack does; std::invalid_argument for parameters that the model does not have.
PsdJacobian psd_jacobian(const PsdModel& psd, const std::vector<PsdVariable>& parameters,
                         const std::vector<Statistic>& statistics, const GhsPupil& pupil, int threads = 1,
                         const LightProperties* light = nullptr);

}  // namespace aberfit
