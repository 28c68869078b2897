#pragma once
#include "aberfit/waves/diffraction_psf.h"

namespace aberfit {

/// The point of highest irradiance in the focus, and the tilt that moves it onto the axis.
struct DiffractionPeak {
  double strehl = 0;      ///< highest irradiance over that of the same pupil with zero height
  double axis_ratio = 0;  ///< axial irradiance over the same reference
  double x = 0, y = 0;    ///< position of the highest irradiance from the nominal focus [m]
};

/// Finds the highest irradiance. It samples the focus at half of lambda (f/D), then applies Newton's method
/// to the exact sum over grid cells (over lags with `problem.scatter`) from every local maximum that may be
/// the highest. StrehlRatio of evaluate_diffraction is the same number. The sum uses cell centres with the
/// weights DiffractionPupil::amplitude; its error against closed forms is 1e-6 for 128 cells across. Throws
/// std::invalid_argument like every function of a DiffractionProblem.
DiffractionPeak diffraction_peak(const DiffractionProblem& problem, const Eigen::ArrayXd& height);

}  // namespace aberfit
