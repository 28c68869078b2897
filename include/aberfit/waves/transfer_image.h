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

}  // namespace aberfit
