#pragma once
#include <optional>
#include <vector>

#include "aberfit/trace/ray_bundle.h"

namespace aberfit::internal {

/// FWHM [m] of the weighted distribution of `position` smoothed by a Gaussian of standard deviation
/// `bandwidth` [m]: distance of the outermost half-maximum crossings around the peak. `d_position`, when
/// given, gets `scale` times d fwhm per ray. Nothing when the bandwidth is not positive.
std::optional<double> line_spread_fwhm(const Eigen::ArrayXd& position, const Eigen::ArrayXd& weight,
                                       double bandwidth, double scale, std::vector<double>* d_position);

}  // namespace aberfit::internal
