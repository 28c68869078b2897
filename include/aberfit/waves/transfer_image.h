#pragma once
#include <Eigen/Core>

#include "aberfit/waves/diffraction_psf.h"

namespace aberfit {

/// Samples of an optical transfer function OTF(nu) = int PSF(X) exp(-2 pi i nu.X) d2X, with nu in cycles/m of
/// the plane. value(row, column) is at nu_y = (row - middle) step, nu_x = (column - middle) step. OTF(0) = 1
/// for all energy that passes the aperture.
struct TransferImage {
  Eigen::ArrayXXcd value;   ///< square, 2 middle + 1 a side
  double step = 0;          ///< [cycles/m]
  Eigen::Index middle = 0;  ///< row and column of frequency 0
};

/// Autocorrelation of the pupil field in the plane z = f + dz at all nonzero lags of the grid, exact by a
/// padded transform. With `problem.scatter` it is multiplied by H. Above `most_lags` a side it keeps every
/// second, third, ... lag. Rounding error: 1e-13 of OTF(0). Throws ComputationError when cells are not square
/// or the plane does not exist.
TransferImage diffraction_transfer(const DiffractionProblem& problem, const Eigen::ArrayXd& height, double dz,
                                   int most_lags);

/// Energy fraction per pixel of a square image about the nominal focus, pixels x pixels over +-half_width [m]
/// in the plane z = f + dz. It is the exact integral of the PSF over each pixel, from the lags above. row =
/// y, column = x, from -half_width up. The PSF repeats with the field of view wavelength (f+dz)/pitch, and
/// only one period is used. Energy that `problem.scatter` sends beyond it returns from the opposite side.
/// Rounding error: 1e-13 of the energy. Throws ComputationError like diffraction_transfer.
Eigen::ArrayXXd diffraction_pixels(const DiffractionProblem& problem, const Eigen::ArrayXd& height, double dz,
                                   double half_width, int pixels);

}  // namespace aberfit
