#pragma once
#include <Eigen/Core>
#include <vector>

#include "aberfit/measured/focal_data.h"

namespace aberfit::internal {

/// Measured light of a focal plane as sums of the encircled energy E of light that is symmetric about its
/// centre: datum k is the light in a region, and of any region the light is int E(rho) dtheta/(2 pi) along
/// its rim (Green's theorem), so that a pixel is counted exactly, whatever its size.
struct FocalBins {
  Eigen::ArrayXd radius;    ///< that a datum belongs to: of a circle, or mean of a ring's pixels [m]
  Eigen::ArrayXd measured;  ///< share within the circle, or light of the ring [unit of the image]
  Eigen::ArrayXd pixels;    ///< pixels of a ring; 0 of a circle
  Eigen::ArrayXd nodes;     ///< radii where E is asked for, > 0 [m]
  Eigen::MatrixXd weights;  ///< (datum, node): the sum
  bool are_rings = false;
  Eigen::ArrayXd edges;      ///< outer radii of rings [m]; of circles `radius`
  std::vector<int> ring_of;  ///< of each datum, index into `edges`
};

/// Circles. pixel: side of the pixels that the curve was counted with, centres within the radius, whose
/// lattice lies anywhere [m]; 0: none. resolution: lambda f/D, the detail of E [m].
FocalBins circles_of(const EncircledCurve& curve, double pixel, double resolution);

/// A place in an image [pixels], first column and lowest row at 0.
struct PixelPlace {
  double x = 0, y = 0;
};
/// Centroid under a window. Light much finer than a pixel is found to half of one: see `rings_of`. Throws
/// FieldError for an image without light.
PixelPlace centre_of(const FocalImage& image);

/// Rings of one pixel and of an eighth of their radius, whatever is more, about `centre`, out to `reach` [m],
/// at most to the nearest side of the image; the pixels of the innermost ones each for itself, since they
/// know best where the light is. Pixels without a value belong to none. light: where the light's centre is
/// taken to be.
FocalBins rings_of(const FocalImage& image, double pixel, double resolution, double reach,
                   const PixelPlace& centre, const PixelPlace& light);

/// Standard deviation of a pixel, from those within a tenth of the sides of the image [unit of the image]:
/// 1.4826 median absolute deviation. 0 where too few have a value.
double noise_of_rim(const FocalImage& image);

}  // namespace aberfit::internal
