#pragma once

#include "aberfit/measured/height_map.h"
#include "aberfit/measured/profile.h"

namespace aberfit {

enum class DetrendShape {
  kNone,
  kPolynomial,  ///< all x^i y^j, i + j <= degree; 0: piston only
  /// profile: best-fit mirror ellipse (p, q, theta) with piston and tilt; map: polynomial of degree 2
  kEllipse,
  kZernike,  ///< maps: Noll-normalised modes up to radial order `degree` on the enclosing circle of the valid
             ///< points
};
struct DetrendOptions {
  DetrendShape shape = DetrendShape::kPolynomial;
  int degree = 2;  ///< degree of the shape for heights; one less for slopes
};

/// Returns the heights [m] of a profile. Slopes are integrated by the trapezoid rule on the true positions,
/// starting with 0 at the first sample. The integral bridges NaN slopes linearly; they stay NaN.
Profile heights_of(const Profile& profile);

/// Subtracts the least-squares shape. Slopes lose the derivative of the shape (polynomial of degree - 1).
Profile detrend(const Profile& profile, const DetrendOptions& options);
HeightMap detrend(const HeightMap& map, const DetrendOptions& options);

/// Returns the RMS about zero over the valid samples, each counted once.
double rms(const Profile& profile);
double rms(const HeightMap& map);

}  // namespace aberfit
