#pragma once
#include <Eigen/Core>

#include "aberfit/focus/evaluate.h"
#include "aberfit/trace/ray_bundle.h"

namespace aberfit::internal {

// These functions make curves and images of a ray bundle for pictures in one pass over the rays. Fractions
// are of the energy that arrives: lost rays have weight 0. If all weights are zero, results are NaN.

/// The statistic of the rays as in the results. nominal: the same pupil without surface error.
double ray_statistic(const RayBundle& rays, const RayBundle& nominal, Centre centre,
                     const Statistic& statistic);

/// EE(r): fraction of the energy within each of `radii` [m, ascending] of the centre at plane dz [m]. O(N log
/// M).
Eigen::ArrayXd encircled_energy_curve(const RayBundle& rays, Centre centre, double dz,
                                      const Eigen::ArrayXd& radii);

/// N(dz): fraction of the energy inside the ring of `radius` [m] at each of `planes` [m, ascending]. The ring
/// is centred as for RingFwhm: on the axis, or on the centroid of the plane z = f. Each ray is inside for one
/// interval of dz, so this is O(N log M), not O(N M).
Eigen::ArrayXd ring_through_curve(const RayBundle& rays, Centre centre, double radius,
                                  const Eigen::ArrayXd& planes);

/// Fraction of the energy per pixel of a square image, pixels x pixels over +-half_width [m] about the centre
/// at plane dz [m]; column = x, row = y, from -half_width up. A ray is divided among the four nearest pixel
/// centres by bilinear weights (cloud in cell, Birdsall & Fuss 1969), because regular pupils and square
/// pixels would give moire otherwise. Energy off the image is left out.
Eigen::ArrayXXd focal_image(const RayBundle& rays, Centre centre, double dz, double half_width, int pixels);

/// Weighted density [1/unit of values] of `values` in `bins` equal bins over [low, high], normalised to the
/// total weight, including that outside.
Eigen::ArrayXd weighted_density(const Eigen::ArrayXd& values, const Eigen::ArrayXd& weights, double low,
                                double high, int bins);

}  // namespace aberfit::internal
