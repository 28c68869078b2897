#pragma once
#include "aberfit/waves/diffraction_psf.h"

namespace aberfit::internal {

/// The same at the k-th wavelength of its band.
DiffractionProblem at_line(const DiffractionProblem& problem, std::size_t k);

/// evaluate_diffraction in a band of light: energies of its lines add. Circles, squares and transfer
/// functions are sums by the lines' shares; a radius holds its share of the sum; a Strehl ratio is the mean
/// of the lines', weighted by the perfect mirror's irradiance, share/wavelength^2, each where its own is
/// highest. Widths of rings and line spreads do not exist.
bool evaluate_band(const DiffractionProblem& problem, const Eigen::ArrayXd& height,
                   const std::vector<Statistic>& statistics, int threads, DiffractionWorkspace* workspace,
                   Eigen::VectorXd* values, std::vector<Eigen::ArrayXd>* d_height,
                   const GradientReduction& reduce);

}  // namespace aberfit::internal
