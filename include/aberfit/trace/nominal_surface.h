#pragma once
#include <Eigen/Core>

#include "aberfit/scene/mirror.h"
#include "aberfit/scene/pupil.h"
#include "aberfit/terms/surface_operator.h"

namespace aberfit {

/// Heights [m] and slopes that the mirror's known Zernikes add to `base_surface` at the points of a pupil, by
/// the fast kernels of SurfaceOperator. Equal to `base_surface` within 1e-12 of the largest height and slope
/// for n <= 100. Empty without known Zernikes. For points beyond the Zernike disc see `options.hold_at_rim`.
SurfaceField known_zernike_field(const Mirror& mirror, const PupilSample& pupil,
                                 const OperatorOptions& options = {});

/// Sag of the nominal mirror less that of the parabola rho^2/(4f) [m] at the points of a pupil; empty for a
/// parabola. The path error is twice that, to first order in the slope, as for the surface error. Error:
/// rounding of the sag, 1e-16 of it, and that of known_zernike_field.
Eigen::ArrayXd departure_from_parabola(const Mirror& mirror, const PupilSample& pupil,
                                       const OperatorOptions& options = {});

}  // namespace aberfit
