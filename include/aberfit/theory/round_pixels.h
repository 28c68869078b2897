#pragma once
#include <Eigen/Core>
#include <functional>

namespace aberfit {

/// Fractions of the energy of round light in pixels x pixels squares of side `pixel`, the axis in the middle.
/// By the divergence theorem the energy in a pixel is the flux of E(r) r/(2 pi r^2) through its edges, E the
/// energy within r. flux_through(y, a, b): through the piece from x = a >= 0 to b of the line at y > 0.
Eigen::ArrayXXd round_pixels(double pixel, int pixels,
                             const std::function<double(double y, double a, double b)>& flux_through);

}  // namespace aberfit
