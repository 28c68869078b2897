#pragma once
#include <optional>
#include <vector>

#include "aberfit/trace/ray_bundle.h"

namespace aberfit::internal {

/// A bandwidth of at least the RMS radius over this number gives a width for every distribution of rays.
inline constexpr int kNarrowestLine = 2000;

/// FWHM [m] of the weighted distribution of `position` [m], smoothed by a Gaussian of standard deviation
/// `bandwidth` [m]. It is the distance of the outermost half-maximum crossings around the highest peak, to
/// rounding of the line's length. Secondary peaks that exceed half by less than 5e-4 of it may be missed.
/// Positions more than 8 standard deviations from their mean are ignored. `d_position`, when given, gets
/// `scale` times d fwhm per ray. Returns nothing when the bandwidth is not positive, or when the line extends
/// farther than 16384 bandwidths from its mean. Then the profile would show only single rays.
std::optional<double> line_spread_fwhm(const Eigen::ArrayXd& position, const Eigen::ArrayXd& weight,
                                       double bandwidth, double scale, std::vector<double>* d_position);

}  // namespace aberfit::internal
