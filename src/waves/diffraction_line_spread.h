#pragma once
#include <Eigen/Core>
#include <optional>

namespace aberfit::internal {

/// FWHM, between the outermost half crossings, of the line spread function L(xi) = Re(C_0) + 2 Re sum_(m>0)
/// C_m exp(-2 pi i m xi). xi is in periods of the PSF; C_m is the transfer function along one axis.
/// `gradient`, when given: g_m with d FWHM = Re sum_m g_m dC_m. Returns nothing when there is no peak or no
/// crossing in the period.
std::optional<double> otf_line_width(const Eigen::ArrayXcd& transfer, Eigen::ArrayXcd* gradient);

}  // namespace aberfit::internal
