#pragma once
#include <optional>

#include "aberfit/scene/aperture.h"
#include "aberfit/scene/pupil.h"

namespace aberfit {

/// Quadrature over the whole aperture; the margin is not subtracted. The weighted sum of every polynomial in
/// x and y of total degree <= `degree` (>= 0) is its mean over the aperture. The rounding error is 1e-13 of
/// the largest value. Circle and annulus: Gauss-Legendre in rho^2 on degree/4 + 1 rings of more than `degree`
/// spokes each. Rectangle: Gauss-Legendre in x times in y. Polygon: signed triangles between its edges and
/// its centroid; Gauss-Legendre in the coordinates of a square that is mapped to each triangle (Stroud 1971,
/// 2.4). If a polygon is not star-shaped about its centroid, some weights are negative and some points lie
/// outside it. They stay within the circle about the axis that holds the polygon. The number of points is
/// about degree^2/4 on circles and rectangles, and degree^2/4 per edge of a polygon.
PupilSample quadrature_pupil(const Aperture& aperture, int degree);

/// The number of those points, or slightly less.
double quadrature_points(const Aperture& aperture, int degree);

/// The aperture reduced by its margin, where rays lie. Returns nothing for a polygon with a margin, because
/// the reduced shape is not a polygon. Never throws; sizes of the result may be zero or negative.
std::optional<Aperture> without_margin(const Aperture& aperture);

}  // namespace aberfit
