#pragma once
#include <Eigen/Core>
#include <complex>
#include <limits>
#include <vector>

#include "aberfit/roughness/psd.h"

namespace aberfit {

// Quadrature for integrals over a PSD: panels on which S is smooth, and weights for an oscillating factor.

inline constexpr int kPanelNodes = 24;
using PanelArray = Eigen::Array<double, kPanelNodes, 1>;

/// A frequency interval [a, b] on which S equals the polynomial through its nodes to 1e-14 of its maximum.
struct PsdPanel {
  double a = 0, b = 0;        ///< [cycles/m]
  PanelArray f, weight, psd;  ///< nodes [cycles/m], weights [cycles/m], S at the nodes [m^4]
};

/// Panels that cover [a, b], 0 < a < b < inf, ascending. They are cut at the breakpoints of S, have b/a <=
/// `max_ratio` and widths <= `max_width`, and are halved until S is resolved. Panels with S = 0 are omitted.
std::vector<PsdPanel> resolved_panels(const RadialPsd& psd, double a, double b, double max_ratio = 2.0,
                                      double max_width = std::numeric_limits<double>::infinity());

/// Weights W_j = int_a^b l_j(f) exp(i omega f) df of the panel nodes, l_j the Lagrange polynomials. For any
/// omega, sum_j W_j g(f_j) integrates g(f) exp(i omega f) as accurately as Gauss-Legendre integrates g. This
/// is the Legendre form of Filon's rule (Bakhvalov and Vasil'eva 1968): int_-1^1 P_l(t) exp(i w t) dt = 2 i^l
/// j_l(w).
Eigen::Array<std::complex<double>, kPanelNodes, 1> oscillatory_weights(double a, double b, double omega);

/// h_nu = P + iQ with J_nu(x) = sqrt(2/(pi x)) Re(h_nu exp(i(x - nu pi/2 - pi/4))), for nu = 0 and 1
/// (DLMF 10.17.5). x >= 30; error below 1e-15. Higher orders: h_{nu+1} = h_{nu-1} + i (2 nu/x) h_nu.
struct HankelAmplitudes {
  std::complex<double> h0, h1;
};
HankelAmplitudes hankel_amplitudes(double x);

/// Frequencies beyond which S equals its power terms to rounding: the low-frequency terms below `low`, and
/// the high-frequency terms above `high`. If the band starts at f > 0 or ends, these are the band edges.
struct PowerLawLimits {
  double low = 0, high = 0;  ///< [cycles/m], 0 < low <= high < inf
};
PowerLawLimits power_law_limits(const RadialPsd& psd);

/// 2 pi int_a^b f^(power + 1) S df; power = 0 gives the height variance of the band [m^2]. 0 <= a, b may be
/// infinity. Relative error below 1e-12; infinity when the integral does not exist.
double radial_moment(const RadialPsd& psd, double power, double a = 0,
                     double b = std::numeric_limits<double>::infinity());

}  // namespace aberfit
