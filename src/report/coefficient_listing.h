#pragma once
#include <string>
#include <vector>

#include "aberfit/report/exports.h"

namespace aberfit::internal {

struct ZernikeCoefficient {
  ZernikeMode mode;
  double value = 0;  ///< of the orthonormal mode [m]
};

/// The surface as Zernikes alone. Spherical terms are radial polynomials, so they go over exactly:
/// (rho/R)^2k = sum over l <= k of sqrt(2l + 1) k!^2 / ((k - l)! (k + l + 1)!) Z_2l^0, the integral over t =
/// (rho/R)^2 of t^k times the shifted Legendre polynomial P_l(2t - 1). `format` is named when Fourier terms
/// make it impossible: std::invalid_argument.
std::vector<ZernikeCoefficient> as_zernikes(const ExportInput& input, const std::string& format);

/// zernike_standard.txt.
std::string zernike_listing_text(const ExportInput& input);
/// zernike_fringe.int.
std::string codev_zfr_text(const ExportInput& input);

/// A title on one line of printable characters, at most `limit` of them.
std::string one_line(const std::string& title, std::size_t limit);

}  // namespace aberfit::internal
