#pragma once
#include "aberfit/waves/diffraction_psf.h"

namespace aberfit::internal {

/// The same problem at the k-th wavelength of its band.
DiffractionProblem at_line(const DiffractionProblem& problem, std::size_t k);

/// evaluate_diffraction for a band of wavelengths, whose irradiances add. Encircled and ensquared energies
/// and transfer functions are weighted sums over the wavelengths. A radius holds its fraction of the summed
/// energy. A Strehl ratio is the mean over wavelengths, each at its own highest point, weighted by the axial
/// irradiance of the perfect mirror, fraction/wavelength^2. Ring and line-spread widths do not exist.
bool evaluate_band(const DiffractionProblem& problem, const Eigen::ArrayXd& height,
                   const std::vector<Statistic>& statistics, int threads, DiffractionWorkspace* workspace,
                   Eigen::VectorXd* values, std::vector<Eigen::ArrayXd>* d_height,
                   const GradientReduction& reduce);

}  // namespace aberfit::internal
