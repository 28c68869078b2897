#pragma once
#include "aberfit/waves/diffraction_psf.h"

namespace aberfit {

/// The highest point of a pattern in the focus, and what a tilt that moves it onto the axis would do.
struct DiffractionPeak {
  double strehl = 0;      ///< highest irradiance over that of the same pupil without any height
  double axis_ratio = 0;  ///< irradiance on the axis over the same
  double x = 0, y = 0;    ///< where the highest irradiance is, from the nominal focus [m]
};

/// Looks for the highest irradiance among samples half of lambda (f/D) apart, and from every local maximum
/// that may be the highest by Newton's method on the exact sum over cells (with `problem.scatter` over lags).
/// StrehlRatio of evaluate_diffraction is the same number. The irradiance is that of cell centres with the
/// weights of DiffractionPupil::amplitude: against closed forms 1e-6 on 128 cells across. Throws
/// std::invalid_argument as every function of a problem does.
DiffractionPeak diffraction_peak(const DiffractionProblem& problem, const Eigen::ArrayXd& height);

}  // namespace aberfit
