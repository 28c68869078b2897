#pragma once
#include <Eigen/Core>
#include <complex>
#include <limits>
#include <vector>

#include "aberfit/roughness/psd.h"

namespace aberfit {

// Quadrature that the integrals over a PSD share: panels on which S is smooth, and weights for an oscillating
// factor on them.

inline constexpr int kPanelNodes = 24;
using PanelArray = Eigen::Array<double, kPanelNodes, 1>;

/// An interval [a, b] of frequency on which S is, to 1e-14 of its maximum there, the polynomial through its
/// Gauss-Legendre nodes.
struct PsdPanel {
  double a = 0, b = 0;        ///< [cycles/m]
  PanelArray f, weight, psd;  ///< nodes [cycles/m], weights [cycles/m], S at the nodes [m^4]
};

/// Panels that cover [a, b], 0 < a < b < inf, in ascending order: cut at the breakpoints of S, b/a at most
/// `max_ratio`, no wider than `max_width`, and halved until S is resolved. Panels on which S vanishes are
/// left out.
std::vector<PsdPanel> resolved_panels(const RadialPsd& psd, double a, double b, double max_ratio = 2.0,
                                      double max_width = std::numeric_limits<double>::infinity());

/// Weights W_j = int_a^b l_j(f) exp(i omega f) df of the panel nodes, l_j the Lagrange polynomials: sum_j W_j
/// g(f_j) integrates g(f) exp(i omega f) as accurately for any omega as plain Gauss-Legendre integrates g.
/// Legendre form of Filon's rule (Bakhvalov and Vasil'eva 1968): int_-1^1 P_l(t) exp(i w t) dt = 2 i^l
/// j_l(w).
Eigen::Array<std::complex<double>, kPanelNodes, 1> oscillatory_weights(double a, double b, double omega);

/// h_nu = P + iQ with J_nu(x) = sqrt(2/(pi x)) Re(h_nu exp(i(x - nu pi/2 - pi/4))), for nu = 0 and 1
/// (DLMF 10.17.5). x >= 30; error below 1e-15. Higher orders: h_{nu+1} = h_{nu-1} + i (2 nu/x) h_nu.
struct HankelAmplitudes {
  std::complex<double> h0, h1;
};
HankelAmplitudes hankel_amplitudes(double x);

/// Where the power terms of S take over from panels: S equals its low-frequency terms below `low` and its
/// high-frequency terms above `high`, to rounding. For a band that starts at f > 0 or ends these are the band
/// edges.
struct PowerLawLimits {
  double low = 0, high = 0;  ///< [cycles/m], 0 < low <= high < inf
};
PowerLawLimits power_law_limits(const RadialPsd& psd);

/// 2 pi int_a^b f^(power + 1) S df; power = 0 is the height variance of the band [m^2]. 0 <= a, b may be
/// infinity. Relative error below 1e-12; infinity when the integral does not exist.
double radial_moment(const RadialPsd& psd, double power, double a = 0,
                     double b = std::numeric_limits<double>::infinity());

}  // namespace aberfit
