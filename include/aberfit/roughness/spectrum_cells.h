#pragma once
#include <functional>
#include <vector>

#include "aberfit/roughness/psd.h"

namespace aberfit {

/// int_a^b g df, cut at those of `cuts` (ascending) that lie inside; 24 Gauss-Legendre nodes a piece, in a
/// variable that takes square-root ends (edges of a band, tangents of a circle) away.
double integral_in_pieces(const std::function<double(double)>& g, double a, double b,
                          const std::vector<double>& cuts);

/// int S df_x df_y [m^2] over [x0, x1] x [y0, y1], all >= 0 [cycles/m]. S is written as a function of the
/// radius and multiplied by the angle that the circle has inside the rectangle, so that S may rise steeply or
/// jump inside.
double rectangle_variance(const RadialPsd& psd, double x0, double x1, double y0, double y1);

/// Where S jumps: the breakpoints at which its values on the two sides differ by more than 1e-3.
std::vector<double> jumps(const RadialPsd& psd);

}  // namespace aberfit
