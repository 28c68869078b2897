#pragma once

namespace aberfit::internal {

/// 1 - 2 J1(z)/z with a relative error of rounding.
double one_minus_jinc(double z);
/// 1 - (2/Gamma(nu)) (a/2)^nu K_nu(a). Up to a = 2 it uses the series of K_nu without its first term: DLMF
/// 10.27.4 with 10.25.2, and 10.31.1 for an integer nu.
double one_minus_matern(double nu, double a);

}  // namespace aberfit::internal
