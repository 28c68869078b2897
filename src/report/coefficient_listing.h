#pragma once
#include <string>
#include <vector>

#include "aberfit/report/exports.h"

namespace aberfit::internal {

struct ZernikeCoefficient {
  ZernikeMode mode;
  double value = 0;  ///< coefficient of the orthonormal mode [m]
};

/// The surface as Zernikes alone. Spherical terms are radial polynomials, so the conversion is exact:
/// (rho/R)^2k = sum over l <= k of sqrt(2l + 1) k!^2 / ((k - l)! (k + l + 1)!) Z_2l^0, from the integral over
/// t = (rho/R)^2 of t^k times the shifted Legendre polynomial P_l(2t - 1). Throws std::invalid_argument,
/// which names `format`, for Fourier terms.
std::vector<ZernikeCoefficient> as_zernikes(const ExportInput& input, const std::string& format);

/// Content of zernike_standard.txt.
std::string zernike_listing_text(const ExportInput& input);
/// Content of zernike_fringe.int.
std::string codev_zfr_text(const ExportInput& input);

/// A title as one line of at most `limit` printable characters.
std::string one_line(const std::string& title, std::size_t limit);

}  // namespace aberfit::internal
