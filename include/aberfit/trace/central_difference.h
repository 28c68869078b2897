#pragma once
#include "aberfit/scene/mirror.h"
#include "aberfit/scene/pupil.h"
#include "aberfit/terms/surface_operator.h"

namespace aberfit {

/// The surface error as central differences see it: slopes (z(x+d) - z(x-d))/(2d) of mirror plus terms in one
/// double, less the analytic slope of the mirror, so that `trace` uses exactly those normals. Analytic
/// normals are the default; this is the paper's way, a hidden low-pass filter with RMS slope error 0.0932 (2
/// pi f_max d)^2 and round-off about 1.2e-19/d rad (PHYSICS 8). step: d [m], > 0. Height is exact.
SurfaceField central_difference_field(const Mirror& mirror, const PupilSample& pupil, const TermSet& terms,
                                      const Eigen::VectorXd& coefficients, double step, int threads);

}  // namespace aberfit
