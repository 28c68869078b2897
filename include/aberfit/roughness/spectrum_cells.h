#pragma once
#include <functional>
#include <vector>

#include "aberfit/roughness/psd.h"

namespace aberfit {

/// int_a^b g df, divided at those of `cuts` (ascending) that lie inside. Each piece has 24 Gauss-Legendre
/// nodes in a variable that removes square-root ends (edges of a band, tangents of a circle).
double integral_in_pieces(const std::function<double(double)>& g, double a, double b,
                          const std::vector<double>& cuts);

/// int S df_x df_y [m^2] over [x0, x1] x [y0, y1], all >= 0 [cycles/m]. The integrand is S as a function of
/// the radius, times the angle of the circle inside the rectangle. So S may be steep or jump inside.
double rectangle_variance(const RadialPsd& psd, double x0, double x1, double y0, double y1);

/// Breakpoints where S jumps: its values on the two sides differ by more than 1e-3 of the larger one.
std::vector<double> jumps(const RadialPsd& psd);

}  // namespace aberfit
