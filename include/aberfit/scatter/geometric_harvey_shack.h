#pragma once
#include "aberfit/focus/statistic.h"
#include "aberfit/scatter/convention.h"
#include "aberfit/scene/aperture.h"
#include "aberfit/scene/mirror.h"

namespace aberfit {

/// Geometric Harvey-Shack prediction: every ray is deflected by an isotropic Gaussian slope error of per-axis standard deviation
/// `slope`; first order in the slope, exact in the aperture (PHYSICS 5). Relative error of order 4.6 slope^2.
/// Works for every rotationally symmetric mirror and every aperture shape: the nominal offset and the two focal standard
/// deviations (radial, tangential) are functions of rho alone, averaged with `radial_quadrature`.
class GeometricHarveyShack {
 public:
  GeometricHarveyShack(const Mirror& mirror, const Aperture& aperture, double slope, Convention convention,
                       double rms_height);

  /// Share of the light within `radius` [m] of the axis at plane dz [m] from z = f.
  double encircled_energy(double radius, double dz) const;
  /// Radius [m] that holds `fraction` of the light at plane dz. Newton with bisection on encircled_energy.
  double encircled_energy_radius(double fraction, double dz) const;
  /// Full width [m] at half maximum of N(z) = encircled_energy(ring_radius, z) over z.
  double ring_fwhm(double ring_radius) const;
  double rms_radius(double dz) const;
  double scatter_rms() const;
  double scatter_mean() const;
  /// FWHM of the line spread profile convolved with a Gaussian of standard deviation `bandwidth` [m].
  double spot_fwhm(double bandwidth) const;

  /// Any statistic by its description. RmsHeight gives the equivalent surface's: rms_height, halved in convention `paper`.
  double operator()(const Statistic& statistic) const;

  /// Paraxial per-axis standard deviation of the focal displacement, sigma_f [m]: 2 f slope, or f slope in convention `paper`.
  double focal_sigma() const { return focal_sigma_; }

 private:
  struct Zone {          // one radial quadrature node
    double weight;       // share of the aperture
    double rho;          // [m]
    double offset, offset_per_dz;            // nominal radial landing: offset + dz * offset_per_dz [m]
    double sigma_radial, sigma_radial_per_dz;          // focal standard deviations, linear in dz [m]
    double sigma_tangential, sigma_tangential_per_dz;
    double angle_radial, angle_tangential;   // standard deviations of the scatter angle [rad]
  };
  std::vector<Zone> zones_;
  double focal_sigma_ = 0;
  double rms_height_ = 0;
  double plane_scale_ = 0;  // f sigma_f / R: the natural unit of dz [m]
};

}  // namespace aberfit
