#pragma once
#include "aberfit/scene/mirror.h"
#include "aberfit/scene/pupil.h"
#include "aberfit/terms/surface_operator.h"

namespace aberfit {

/// The surface error with slopes by central differences, as in the paper (PHYSICS 8): (z(x+d) - z(x-d))/(2d)
/// of mirror plus terms in one double, less the analytic slope of the mirror. Analytic normals are the
/// default. The difference is a low-pass filter with an RMS slope error of 0.0932 (2 pi f_max d)^2 and a
/// rounding error of about 1.2e-19/d rad. step: d [m], > 0. The height is exact.
SurfaceField central_difference_field(const Mirror& mirror, const PupilSample& pupil, const TermSet& terms,
                                      const Eigen::VectorXd& coefficients, double step, int threads);

}  // namespace aberfit
