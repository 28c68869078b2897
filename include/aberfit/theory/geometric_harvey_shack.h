#pragma once
#include <vector>

#include "aberfit/focus/statistic.h"
#include "aberfit/scene/aperture.h"
#include "aberfit/scene/mirror.h"
#include "aberfit/theory/gaussian_in_disc.h"
#include "aberfit/theory/vocabulary.h"

namespace aberfit {

/// Geometric Harvey-Shack prediction: every ray is deflected by an isotropic Gaussian slope error of per-axis
/// standard deviation `slope`; first order in the slope, exact in the aperture (PHYSICS 5). Relative error of
/// order 4.6 slope^2, of 8 slope at f/0.25, where the rim is as steep as it may be. Works for every
/// rotationally symmetric mirror (`is_rotationally_symmetric`; known Zernikes with m != 0 are left out,
/// trace_perturbed has them) and every aperture shape: the nominal offset and the two focal standard
/// deviations (radial, tangential) are functions of rho alone, averaged with `radial_quadrature`. With P the
/// slope of the mirror at rho and u = zk - z the height of the plane over it: physical, radial 2 u s
/// (1+P^2)/(1-P^2)^2 and tangential 2 u s/(1-P^2); paper, u s (1+P^2)/(1-P^2) on both axes. The quadrature is
/// refined with spread = largest nominal offset / smallest sigma in the plane
/// (|dz| R/(f sigma_f) for a parabola): relative error of encircled energies and radii below 1e-10 up to
/// spread 100, growing beyond 200. slope = 0 gives the nominal rays of the quadrature: encircled energy is a
/// stair of the nodes' offsets (steps of about 1/1000 of the light), radii and widths come from that stair.
class GeometricHarveyShack {
 public:
  /// slope >= 0; rms_height [m] is passed through to RmsHeight. Throws ComputationError when the mirror has
  /// no sag somewhere inside the aperture or is 45 degrees steep there, so that light does not come back to
  /// the focus.
  GeometricHarveyShack(const Mirror& mirror, const Aperture& aperture, double slope, Convention convention,
                       double rms_height);

  /// Share of the light within `radius` [m] of the axis at plane dz [m] from z = f.
  double encircled_energy(double radius, double dz) const;
  /// Its derivative over the radius [1/m]; 0 where the curve is a stair.
  double encircled_energy_slope(double radius, double dz) const;
  /// Radius [m] that holds `fraction` of the light at plane dz, to 1e-12. Newton with bisection on
  /// encircled_energy. NaN for fractions outside (0, 1).
  double encircled_energy_radius(double fraction, double dz) const;
  /// How far such a `radius` [m] in the plane dz moves per relative change of the slope, dr/d ln(slope) [m]:
  /// 0 where the curve is a stair.
  double radius_over_slope(double radius, double dz) const;
  /// Full width [m] at half maximum of N(z) = encircled_energy(ring_radius, z) over z: the half crossings
  /// nearest to ring_peak on either side, to 1e-12. NaN when ring_radius is not positive or a crossing lies
  /// beyond |dz| = f/2.
  double ring_fwhm(double ring_radius) const;
  /// Plane dz [m] in which the ring holds most light: zero of dN/dz beside the best of a scan (a step is a
  /// quarter of the ring's depth, more where the zones' foci spread over 200 depths).
  double ring_peak(double ring_radius) const;
  /// RMS distance from the axis at plane dz [m], both axes together.
  double rms_radius(double dz) const;
  /// RMS and mean angle between a ray and its nominal ray [rad]. The mean of an elliptic Gaussian is
  /// sqrt(2/pi) a E(sqrt(1 - b^2/a^2)), a >= b its standard deviations, E the complete elliptic integral of
  /// the second kind.
  double scatter_rms() const;
  double scatter_mean() const;
  /// FWHM [m] of the line spread profile in the plane z = f, averaged over its direction (which for small
  /// offsets is the mean of the x and y widths of any aperture) and convolved with a Gaussian of standard
  /// deviation `bandwidth` [m]. Between the outermost half crossings. NaN when slope and bandwidth are both
  /// 0.
  double spot_fwhm(double bandwidth) const;

  /// Any statistic by its description. RmsHeight gives the equivalent surface's: rms_height, halved in
  /// convention `paper`.
  double operator()(const Statistic& statistic) const;

  /// Paraxial per-axis standard deviation of the focal displacement, sigma_f [m]: 2 f slope, or f slope in
  /// convention `paper`.
  double focal_sigma() const { return focal_sigma_; }

 private:
  struct Zone {                                // one radial quadrature node
    double weight;                             // share of the aperture
    double rho;                                // [m]
    double offset, offset_per_dz;              // nominal radial landing: offset + dz * offset_per_dz [m]
    double sigma_radial, sigma_radial_per_dz;  // focal standard deviations, linear in dz [m]
    double sigma_tangential, sigma_tangential_per_dz;
    double angle_radial, angle_tangential;  // standard deviations of the scatter angle [rad]
  };
  struct Sums;  // encircled energy with its derivatives
  const std::vector<Zone>& zones(double dz) const;
  Sums sums(double radius, double dz) const;

  std::vector<std::vector<Zone>> levels_;  // the aperture in ever more zones
  DiscRules rules_;
  double focal_length_ = 0;
  double aperture_radius_ = 0;
  double focal_sigma_ = 0;
  double rms_height_ = 0;
};

}  // namespace aberfit
