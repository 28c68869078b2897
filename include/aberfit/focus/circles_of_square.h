#pragma once
#include "aberfit/core/quadrature.h"

namespace aberfit {

/// Circles about the middle of a square that its edge cuts: nodes are their radii over the side, in [1/2,
/// 1/sqrt(2)], weights sum to 1. Light in the square, in the mean over squares turned all ways, is the
/// weighted sum of the light in them:
///   E_square(side) = (4/pi) int_0^(pi/4) E(side/(2 cos t)) dt.
/// turn: by how much the fastest part of the light turns along a side, 2 pi side nu [rad]. Gauss-Legendre
/// over t with twelve nodes and one for each 2 rad that the light turns between the middle of an edge and a
/// corner, 512 at most: further out E hardly changes.
Quadrature circles_of_square(double turn);

}  // namespace aberfit
