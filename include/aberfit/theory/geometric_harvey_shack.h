#pragma once
#include <vector>

#include "aberfit/focus/statistic.h"
#include "aberfit/scene/aperture.h"
#include "aberfit/scene/mirror.h"
#include "aberfit/theory/gaussian_in_disc.h"
#include "aberfit/theory/vocabulary.h"

namespace aberfit {

/// Geometric Harvey-Shack prediction: an isotropic Gaussian slope error of per-axis standard deviation
/// `slope` deflects every ray. It is of first order in the slope and exact in the aperture (PHYSICS 5).
/// Relative error about 4.6 slope^2, and 8 slope at f/0.25, where the rim has its largest allowed slope.
/// Valid for every rotationally symmetric mirror (`is_rotationally_symmetric`) and every aperture shape.
/// Known Zernikes with m != 0 are left out; trace_perturbed has them. The nominal offset and the two focal
/// standard deviations (radial, tangential) are functions of rho alone, averaged with `radial_quadrature`.
/// With P the slope of the mirror at rho and u = zk - z the height of the plane over it: physical: radial 2 u
/// s (1+P^2)/(1-P^2)^2, tangential 2 u s/(1-P^2); paper: u s (1+P^2)/(1-P^2) on both axes. The quadrature
/// adapts to spread = largest nominal offset / smallest sigma in the plane (|dz| R/(f sigma_f) for a
/// parabola). Relative error of encircled energies and radii: below 1e-10 up to spread 100, growing beyond
/// 200. slope = 0 gives the nominal rays of the quadrature. Encircled energy is then a stair of the nodes'
/// offsets (steps of about 1/1000), from which radii and widths come.
class GeometricHarveyShack {
 public:
  /// slope >= 0; rms_height [m] is only returned by RmsHeight. Throws ComputationError when, somewhere inside
  /// the aperture, the mirror has no sag or is 45 degrees steep, so that rays do not come back to the focus.
  GeometricHarveyShack(const Mirror& mirror, const Aperture& aperture, double slope, Convention convention,
                       double rms_height);

  /// Fraction of the energy within `radius` [m] of the axis in the plane dz [m] from z = f.
  double encircled_energy(double radius, double dz) const;
  /// Derivative of the encircled energy over the radius [1/m]; 0 where the curve is a stair.
  double encircled_energy_slope(double radius, double dz) const;
  /// Radius [m] that holds `fraction` of the energy in the plane dz, to 1e-12. NaN outside (0, 1).
  double encircled_energy_radius(double fraction, double dz) const;
  /// Derivative of such a `radius` [m] in the plane dz, dr/d ln(slope) [m]; 0 where the curve is a stair.
  double radius_over_slope(double radius, double dz) const;
  /// Full width [m] at half maximum of N(z) = encircled_energy(ring_radius, z) over z, to a relative 1e-12.
  /// Between the half crossings nearest to ring_peak. NaN if ring_radius <= 0 or a crossing has |dz| > f/2.
  double ring_fwhm(double ring_radius) const;
  /// Plane dz [m] in which the ring holds the most energy: the zero of dN/dz next to the best plane of a
  /// scan. Its step is a quarter of the ring's depth, more where zones' foci spread over 200 depths.
  double ring_peak(double ring_radius) const;
  /// RMS distance from the axis at plane dz [m], both axes together.
  double rms_radius(double dz) const;
  /// RMS and mean angle [rad] between a ray and its nominal ray. The mean for an elliptic Gaussian is
  /// sqrt(2/pi) a E(sqrt(1 - b^2/a^2)), standard deviations a >= b, E the complete elliptic integral of the
  /// 2nd kind.
  double scatter_rms() const;
  double scatter_mean() const;
  /// FWHM [m] of the line spread profile in the plane z = f, between the outermost half crossings. The
  /// profile is averaged over direction and convolved with a Gaussian of standard deviation `bandwidth` [m].
  /// For small offsets it is the mean of the x and y widths. NaN if slope = bandwidth = 0.
  double spot_fwhm(double bandwidth) const;

  /// Any statistic by its description. RmsHeight gives rms_height, or half of it in `paper`.
  double operator()(const Statistic& statistic) const;

  /// Paraxial per-axis deviation of the focal displacement, sigma_f [m]: 2 f slope; f slope for `paper`.
  double focal_sigma() const { return focal_sigma_; }

 private:
  struct Zone {                                // one radial quadrature node
    double weight;                             // fraction of the aperture
    double rho;                                // [m]
    double offset, offset_per_dz;              // nominal radial landing: offset + dz * offset_per_dz [m]
    double sigma_radial, sigma_radial_per_dz;  // focal standard deviations, linear in dz [m]
    double sigma_tangential, sigma_tangential_per_dz;
    double angle_radial, angle_tangential;  // standard deviations of the scatter angle [rad]
  };
  struct Sums;  // encircled energy with its derivatives
  const std::vector<Zone>& zones(double dz) const;
  Sums sums(double radius, double dz) const;

  std::vector<std::vector<Zone>> levels_;  // the aperture in an increasing number of zones
  DiscRules rules_;
  double focal_length_ = 0;
  double aperture_radius_ = 0;
  double focal_sigma_ = 0;
  double rms_height_ = 0;
};

}  // namespace aberfit
