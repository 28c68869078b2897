#pragma once
#include <Eigen/Core>
#include <array>

#include "aberfit/theory/generalised_harvey_shack.h"
#include "aberfit/waves/diffraction_peak.h"

namespace aberfit {

/// The mean irradiance in two dimensions of a mirror with known aberrations; GeneralisedHarveyShack has only
/// its mean over direction. It takes the pupil field of the mirror without roughness on a grid and multiplies
/// its transfer function by the factor H of the roughness. H is that of the parabola in the same aperture,
/// averaged over each overlap (GeneralisedHarveyShack::overlap_transfer). Energy beyond the field of view of
/// the grid is that of the parabola. Without aberrations the result is generalised Harvey-Shack exactly. Else
/// H constant over an overlap is an error of about 1e-3 of the scatter at f/2. Const use from many threads is
/// safe.
class AberratedLight {
 public:
  /// The grid has 128 to 2048 points across: the phase changes by a quarter of a turn per point or less.
  /// Throws ComputationError if 2048 are too few, and as GeneralisedHarveyShack.
  explicit AberratedLight(const GhsPupil& pupil);

  /// Highest irradiance and irradiance on the axis, with the mean scatter of `psd`.
  DiffractionPeak peak(const RadialPsd& psd) const;
  /// Centroid of the energy in the focus [m], from rays of the mirror without roughness and without
  /// GhsOptions::departure. Isotropic scatter does not move it, and wave optics gives the same centroid.
  std::array<double, 2> centroid() const { return centroid_; }
  /// Radius [m] that holds half of the energy in the focus, about the nominal focus and about the centroid.
  struct HalfLight {
    double about_focus, about_centroid;
  };
  HalfLight half_light(const RadialPsd& psd) const;

 private:
  DiffractionProblem problem(const RadialPsd& psd) const;

  GhsPupil parabola_;
  DiffractionPupil cells_;
  Eigen::ArrayXd height_;  // aberration at the grid points [m]
  std::array<double, 2> centroid_{};
};

}  // namespace aberfit
