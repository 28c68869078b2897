#pragma once
#include <Eigen/Core>
#include <vector>

#include "aberfit/measured/focal_data.h"

namespace aberfit::internal {

/// Data of a focal plane as linear functions of the encircled energy E of a symmetric spot. The energy in
/// region k is int E(rho) dtheta/(2 pi) along its boundary (Green's theorem), exact for pixels of any size.
struct FocalBins {
  Eigen::ArrayXd radius;    ///< radius of a circle, or mean radius of the pixels of a ring [m]
  Eigen::ArrayXd measured;  ///< fraction within the circle, or energy in the ring [unit of the image]
  Eigen::ArrayXd pixels;    ///< number of pixels of a ring; 0 for a circle
  Eigen::ArrayXd nodes;     ///< radii at which E is evaluated, > 0 [m]
  Eigen::MatrixXd weights;  ///< (datum, node): weights of E
  bool are_rings = false;
  Eigen::ArrayXd edges;      ///< outer radii of rings [m]; for circles `radius`
  std::vector<int> ring_of;  ///< index of each datum into `edges`
};

/// Returns the circles of a curve. pixel: side of the pixels from which it was counted, by centres within the
/// radius, with the pixel grid at any position [m]; 0: none. resolution: lambda f/D, the detail of E [m].
FocalBins circles_of(const EncircledCurve& curve, double pixel, double resolution);

/// A position in an image [pixels]; the first column and the lowest row are 0.
struct PixelPlace {
  double x = 0, y = 0;
};
/// Returns the centroid under a window. For a spot much finer than a pixel the error is up to half a pixel:
/// see `rings_of`. Throws FieldError for an image without signal.
PixelPlace centre_of(const FocalImage& image);

/// Returns rings about `centre`, as wide as the larger of one pixel and an eighth of their radius, out to
/// `reach` [m] or the nearest side of the image. Each pixel of the innermost rings is a separate datum,
/// because these locate the centre best. Pixels without a value are omitted. light: assumed centre of the
/// spot.
FocalBins rings_of(const FocalImage& image, double pixel, double resolution, double reach,
                   const PixelPlace& centre, const PixelPlace& light);

/// Returns the standard deviation of a pixel within a tenth of the sides of the image [unit of the image]:
/// 1.4826 median absolute deviation. 0 if too few have a value.
double noise_of_rim(const FocalImage& image);

}  // namespace aberfit::internal
