#pragma once
#include "aberfit/core/quadrature.h"

namespace aberfit {

/// Quadrature that gives the ensquared energy from the encircled energy E, as a mean over all orientations of
/// the square:
///   E_square(side) = (4/pi) int_0^(pi/4) E(side/(2 cos t)) dt.
/// Nodes: circle radii over the side, in [1/2, 1/sqrt(2)]. The weights sum to 1. turn: 2 pi side nu [rad],
/// the phase along a side of the highest spatial frequency nu of the irradiance. Gauss-Legendre over t with
/// twelve nodes, and one more for each 2 rad of phase between the middle of an edge and a corner. There are
/// at most 512 nodes, because E is nearly constant beyond that.
Quadrature circles_of_square(double turn);

}  // namespace aberfit
