#pragma once
#include <Eigen/Core>

#include "aberfit/waves/diffraction_psf.h"

namespace aberfit {

/// Samples of an optical transfer function OTF(nu) = int PSF(X) exp(-2 pi i nu.X) d2X, nu in cycles/m of the
/// plane: value(row, column) at nu_y = (row - middle) step, nu_x = (column - middle) step. OTF(0) = 1: all
/// light that passes the aperture.
struct TransferImage {
  Eigen::ArrayXXcd value;   ///< square, 2 middle + 1 a side
  double step = 0;          ///< [cycles/m]
  Eigen::Index middle = 0;  ///< row and column of frequency 0
};

/// The autocorrelation of the pupil field in the plane z = f + dz at the lags of the pupil's cells (exact, by
/// a padded transform, as EE(r) has it; with `problem.scatter` times its H), all that are not zero; of more
/// than `most_lags` a side every second, third, ... Rounding: 1e-13 of OTF(0). Throws ComputationError where
/// cells are not square or the plane does not exist.
TransferImage diffraction_transfer(const DiffractionProblem& problem, const Eigen::ArrayXd& height, double dz,
                                   int most_lags);

/// Share of the light per pixel of a square image about the nominal focus, pixels x pixels over +-half_width
/// [m] in the plane z = f + dz: the exact integral of the pattern over each pixel, from the lags as above.
/// The pattern repeats with the field of view wavelength (f+dz)/pitch, of which one period is looked at:
/// nothing lies beyond it, and what `problem.scatter` throws there comes into it from the other side. row =
/// y, column = x, from -half_width up. Rounding: 1e-13 of the light. Throws ComputationError as
/// diffraction_transfer.
Eigen::ArrayXXd diffraction_pixels(const DiffractionProblem& problem, const Eigen::ArrayXd& height, double dz,
                                   double half_width, int pixels);

}  // namespace aberfit
