#pragma once
#include <optional>

#include "aberfit/scene/aperture.h"
#include "aberfit/scene/pupil.h"

namespace aberfit {

/// Points and weights over the whole aperture, margin not taken off, whose weighted sum of every polynomial
/// in x and y of total degree <= `degree` is its mean over the aperture, but for rounding (1e-13 of the
/// largest value). Circle and annulus: Gauss-Legendre in rho^2 on degree/4 + 1 rings of more than `degree`
/// spokes each. Rectangle: Gauss-Legendre in x times in y. Polygon: the signed triangles of its edges with
/// its centroid, each by Gauss-Legendre in the two coordinates of the square that collapses onto it (Stroud
/// 1971, 2.4); where a polygon is not star-shaped about its centroid some weights are negative and some
/// points outside, within the circle about the axis that holds it. Points: about degree^2/4 on circles and
/// rectangles, that many per edge of a polygon. degree >= 0.
PupilSample quadrature_pupil(const Aperture& aperture, int degree);

/// How many points that is, or a little less.
double quadrature_points(const Aperture& aperture, int degree);

/// The aperture that is left when its margin is taken off: where rays lie. Nothing for a polygon with a
/// margin, which is no polygon along its bent corners. Throws nothing; sizes may end at or below zero.
std::optional<Aperture> without_margin(const Aperture& aperture);

}  // namespace aberfit
