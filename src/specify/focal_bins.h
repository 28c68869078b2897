#pragma once
#include <Eigen/Core>

#include "aberfit/measured/focal_data.h"

namespace aberfit::internal {

/// Measured light of a focal plane as sums of the encircled energy E of light that is symmetric about its
/// centre: datum k is the light in a region, and of any region the light is int E(rho) dtheta/(2 pi) along
/// its rim (Green's theorem), so that a pixel is counted exactly, whatever its size.
struct FocalBins {
  Eigen::ArrayXd radius;    ///< that a datum belongs to: of a circle, or the outer one of a ring [m]
  Eigen::ArrayXd measured;  ///< share within the circle, or light of the ring [unit of the image]
  Eigen::ArrayXd pixels;    ///< pixels of a ring; 0 of a circle
  Eigen::ArrayXd nodes;     ///< radii where E is asked for, > 0 [m]
  Eigen::MatrixXd weights;  ///< (datum, node): the sum
  bool are_rings = false;
  double centre_x = 0, centre_y = 0;  ///< of an image [pixels], first column and lowest row at 0
};

/// Circles. pixel: side of the pixels that the curve was counted with, centres within the radius, whose
/// lattice lies anywhere [m]; 0: none. resolution: lambda f/D, the detail of E [m].
FocalBins circles_of(const EncircledCurve& curve, double pixel, double resolution);

/// Rings of one pixel and of an eighth of their radius, whatever is more, about the centre of the light
/// (windowed centroid), out to `reach` [m], at most to the nearest side of the image; pixels without a value
/// belong to none. Throws FieldError for an image without light.
FocalBins rings_of(const FocalImage& image, double pixel, double resolution, double reach);

/// Standard deviation of a pixel, from those within a tenth of the sides of the image [unit of the image]:
/// 1.4826 median absolute deviation. 0 where too few have a value.
double noise_of_rim(const FocalImage& image);

}  // namespace aberfit::internal
