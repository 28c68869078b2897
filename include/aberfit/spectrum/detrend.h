#pragma once

#include "aberfit/measured/height_map.h"
#include "aberfit/measured/profile.h"

namespace aberfit {

enum class DetrendShape {
  kNone,
  kPolynomial,  ///< all x^i y^j, i + j <= degree; 0: piston only
  kEllipse,  ///< profile: best-fit mirror ellipse (height p, q, theta), piston and tilt; map: polynomial of
             ///< degree 2 (quadric)
  kZernike,  ///< maps: Noll-normalised modes up to radial order `degree` over the enclosing circle of the
             ///< valid points
};
struct DetrendOptions {
  DetrendShape shape = DetrendShape::kPolynomial;
  int degree = 2;  ///< of heights; slopes lose one degree less
};

/// Heights [m] of a profile: its own, or its slopes integrated (trapezoid rule on the true positions, 0 at
/// the first sample). NaN slopes inside are bridged linearly for the integral and stay NaN.
Profile heights_of(const Profile& profile);

/// The profile minus its least-squares shape. Slopes: minus the derivative of the shape (polynomial of degree
/// - 1).
Profile detrend(const Profile& profile, const DetrendOptions& options);
HeightMap detrend(const HeightMap& map, const DetrendOptions& options);

/// RMS about zero over the valid samples, each counted once.
double rms(const Profile& profile);
double rms(const HeightMap& map);

}  // namespace aberfit
