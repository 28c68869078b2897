#pragma once
#include <Eigen/Core>
#include <vector>

#include "aberfit/focus/statistic.h"
#include "aberfit/roughness/psd_derivative.h"
#include "aberfit/theory/generalised_harvey_shack.h"
#include "aberfit/theory/light_property.h"

namespace aberfit {

/// Statistics of generalised Harvey-Shack and their derivatives over the numbers of a PSD.
struct PsdJacobian {
  std::vector<PsdVariable> parameters;
  Eigen::VectorXd parameter_values;
  Eigen::VectorXd values;  ///< [unit of the statistic]: to the last bit those of GeneralisedHarveyShack
  /// statistics x parameters [unit of the statistic per unit of the parameter]. NaN where the value is not
  /// finite.
  Eigen::MatrixXd derivatives;

  /// d ln(statistic)/d ln(parameter).
  Eigen::MatrixXd logarithmic() const;
};

/// Exact derivatives, no differences of roughness: the transfer function is linear in H = exp(-E) and its
/// change is -dE/dp H, with dE/dp the structure function of dS/dp (`PsdDerivative`), on panels of its own
/// that resolve it to 1e-12. Statistics that are defined by an equation come by the implicit function
/// theorem: of a radius r_p dr/dp = -(dE(r)/dp)/(dE(r)/dr), of a full width its half crossings, which move
/// with the top and with the ring. RMS height, RMS and mean scatter angle are linear in S or a root of it.
/// Relative error 1e-9 against the form of the theory that `pupil` asks for, of a ring_fwhm (whose slope over
/// the plane is a difference of eighth order) 1e-8; the exact form interpolates H over the aperture to 2e-6,
/// and so its derivatives. It costs one structure function and one set of panels per parameter and plane.
/// light: further rows, after those of `statistics`, of the same pupil. Irradiance, transfer function and the
/// share in a square are linear in H as encircled energy is, PSSN is its square; sides and widths come by the
/// implicit function theorem, 1 - core by the height variance. A PatchBsdf alone has central differences of
/// 1e-3, error about 1e-6. Throws as GeneralisedHarveyShack does; std::invalid_argument for parameters that
/// the model does not have.
PsdJacobian psd_jacobian(const PsdModel& psd, const std::vector<PsdVariable>& parameters,
                         const std::vector<Statistic>& statistics, const GhsPupil& pupil, int threads = 1,
                         const LightProperties* light = nullptr);

}  // namespace aberfit
