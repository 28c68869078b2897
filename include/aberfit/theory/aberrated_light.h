#pragma once
#include <Eigen/Core>
#include <array>

#include "aberfit/theory/generalised_harvey_shack.h"
#include "aberfit/waves/diffraction_peak.h"

namespace aberfit {

/// The mean light of a mirror with known aberrations in two dimensions, where GeneralisedHarveyShack has its
/// mean over direction: the pupil field of the mirror without roughness on cells, and on its transfer
/// function the factor H of the roughness, which is that of the parabola in the same aperture, averaged over
/// each overlap (GeneralisedHarveyShack::overlap_transfer). Light beyond the cells' field of view is that of
/// the parabola. Without aberrations it is generalised Harvey-Shack exactly; with them H is taken as the same
/// in all of an overlap, some 1e-3 of the scattered light at f/2. Const use from many threads.
class AberratedLight {
 public:
  /// Cells: 128 across, and so many that the phase of the aberration turns by at most a quarter of a turn
  /// between neighbours, at most 2048 a side. Throws ComputationError beyond that, and as
  /// GeneralisedHarveyShack does.
  explicit AberratedLight(const GhsPupil& pupil);

  /// Highest irradiance, and that on the axis, with the mean scatter of `psd`.
  DiffractionPeak peak(const RadialPsd& psd) const;
  /// Centroid of the light in the focus [m]: scatter, which is isotropic, does not move it. That of the rays
  /// of the mirror without roughness and without GhsOptions::departure, which is that of its waves.
  std::array<double, 2> centroid() const { return centroid_; }
  /// Radius [m] that holds half of the light in the focus, about the nominal focus and about the centroid.
  struct HalfLight {
    double about_focus, about_centroid;
  };
  HalfLight half_light(const RadialPsd& psd) const;

 private:
  DiffractionProblem problem(const RadialPsd& psd) const;

  GhsPupil parabola_;
  DiffractionPupil cells_;
  Eigen::ArrayXd height_;  // of the aberration at the cells [m]
  std::array<double, 2> centroid_{};
};

}  // namespace aberfit
