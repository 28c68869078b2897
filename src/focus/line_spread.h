#pragma once
#include <optional>
#include <vector>

#include "aberfit/trace/ray_bundle.h"

namespace aberfit::internal {

/// Light of this many bandwidths' RMS radius is not too wide for a width, wherever its rays are.
inline constexpr int kNarrowestLine = 2000;

/// FWHM [m] of the weighted distribution of `position` [m] smoothed by a Gaussian of standard deviation
/// `bandwidth` [m]: distance of the outermost half-maximum crossings around the highest peak, to rounding of
/// the line's length; lumps that pass half by less than 5e-4 of it may be overlooked. Positions more than 8
/// standard deviations from their mean do not count. `d_position`, when given, gets `scale` times d fwhm per
/// ray. Nothing when the bandwidth is not positive, or light reaches farther from its mean than 16384 of it,
/// where single rays are all the peaks there are.
std::optional<double> line_spread_fwhm(const Eigen::ArrayXd& position, const Eigen::ArrayXd& weight,
                                       double bandwidth, double scale, std::vector<double>* d_position);

}  // namespace aberfit::internal
