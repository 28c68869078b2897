#pragma once
#include <Eigen/Core>
#include <memory>
#include <vector>

#include "aberfit/roughness/psd.h"

namespace aberfit {

namespace internal {
class HigherOrders;
}

/// The scatter function of an infinite flat patch of a rough mirror at normal incidence, without the
/// smoothing of any aperture. It is generalised Harvey-Shack in direction cosines (Krywonos, Harvey and Choi
/// 2011; PHYSICS 6 and 10), from H(x) = exp(-(4 pi/lambda)^2 (C(0) - C(x))). With f = sin(theta)/lambda, k =
/// 4 pi/lambda, and g^2 = k^2 C(0) over the frequencies below 1/lambda (scattering_band):
///   BSDF(theta) = (K/lambda^2) [exp(-g^2) k^2 S(f)
///                 + 2 pi int exp(-g^2) (exp(k^2 C) - 1 - k^2 C) J0(2 pi f x) x dx].
/// The first part is single scattering (Rayleigh-Rice without polarisation, times exp(-g^2)). It is exact and
/// has the sharp edges of the band. The second part holds all higher orders, by a Hankel transform. K
/// corrects for orders that would leave beyond 90 degrees: K = TIS over the energy that the bracket sends
/// below 90 degrees. So the integral of BSDF cos(theta) over the hemisphere is TIS = 1 - exp(-g^2). Where K
/// is not close to 1, scalar theory does not hold (theory_error).
///
/// BSDF is per unit of direction-cosine area; the ASF per solid angle is BSDF cos(theta). Neither contains
/// the specular energy exp(-g^2). Reflectance 1; no polarisation and no obliquity factor, as in the focus.
///
/// The higher orders have kinks at sums and differences of sharp band edges, among them 0. The kinks and the
/// edge of the highest frequency are rounded over 0.5 % of their frequency. The error is 5e-4 near kinks
/// (test BeyondTheBandIsTheSecondOrder). The rounding error is 1e-11 of the energy per octave of angle. The
/// integral differs from TIS by less than 1e-7 for g = 0.01-5. Const use from many threads is safe.
class ScatterFunction {
 public:
  /// rest: the roughness that scatters, any RadialPsd, also a zero one; wavelength > 0 [m]. Throws
  /// ComputationError where the structure function is infinite (PSDs as steep as f^-4 at f = 0). Takes tenths
  /// of a second; seconds for tables of a thousand points and for several sharp edges inside the band.
  ScatterFunction(const RadialPsd& rest, double wavelength);

  /// [1/sr] at theta [rad], |theta| <= pi/2; infinite at 0 where S is.
  double bsdf(double theta) const;
  /// Fraction of the total energy that is scattered to within theta of the specular direction; `tis` at pi/2.
  double within(double theta) const;

  double wavelength() const { return wavelength_; }    ///< [m]
  const RadialPsd& psd() const { return psd_; }        ///< the frequencies that scatter
  double rms_height() const { return rms_height_; }    ///< scattering band [m]; may be infinite
  double rms_slope() const { return rms_slope_; }      ///< scattering band, per axis
  double g() const { return g_; }                      ///< 4 pi rms_height/lambda
  double tis() const { return tis_; }                  ///< 1 - exp(-g^2)
  double cut_share() const { return cut_share_; }      ///< fraction of the height variance above 1/lambda
  double renormalisation() const { return renorm_; }   ///< the factor K
  double lowest_sine() const { return lowest_sine_; }  ///< below it the function is flat or a power law
  /// Largest part of the higher orders that the panels could not resolve; normally 0.
  double unresolved() const;

 private:
  double bracket(double f) const;  // the bracket of the formula above [m^2]

  RadialPsd psd_;
  double wavelength_ = 0, rms_height_ = 0, rms_slope_ = 0, g_ = 0, tis_ = 0, core_ = 1, cut_share_ = 0;
  double renorm_ = 1, lowest_sine_ = 0;
  std::vector<double> knots_,
      variance_below_;  // [cycles/m]; int S d2f below each knot [m^2]; empty without a core
  std::shared_ptr<const internal::HigherOrders> higher_;  // null without roughness
};

/// A scatter function as a table: one row per angle, ascending, and the parameters of the function.
struct ScatterTable {
  Eigen::ArrayXd theta;         ///< [rad]; 0 first (unless infinite there), pi/2 last
  Eigen::ArrayXd asf_per_sr;    ///< scattered energy per solid angle [1/sr]
  Eigen::ArrayXd bsdf_per_sr;   ///< asf / cos(theta) [1/sr]
  Eigen::ArrayXd tis_within;    ///< fraction of the total energy scattered to within theta
  double wavelength = 0;        ///< [m]
  double tis = 0;               ///< 1 - exp(-g^2), the last of tis_within
  double rms_height = 0;        ///< over the frequencies that scatter [m]
  double rms_slope = 0;         ///< over the frequencies that scatter, per axis
  double g = 0;                 ///< 4 pi rms_height / wavelength
  double f_min = 0, f_max = 0;  ///< band that scatters [cycles/m]; f_max at most 1/wavelength
  double cut_share = 0;         ///< fraction of the height variance above 1/wavelength: no scatter
  double renormalisation = 1;   ///< factor K that corrects for orders beyond 90 degrees
};

/// Rows at log-spaced sines and at every bend of S, from the lowest sine of interest to 90 degrees; at least
/// `rows_per_decade` >= 1 of them. The lowest sine is a hundredth of that of f_min. Where the band starts at
/// 0, it is a thousandth of 1/(2 pi x), x the lag at which E is half of min(g^2, 1). A jump of S lies between
/// two rows, at a relative 1e-6 below and above its sine. Intervals are halved, up to eight times, until two
/// errors are small. The energy between rows is right to 3e-6 of the TIS. Log-log interpolation of the BSDF
/// is right to 1e-3 in the middle, if the BSDF there is above 1e-4 of its largest value. tis_within is exact
/// at the rows. Between rows it is nearly linear in the square of the sine, which is the variable for
/// sampling angles.
ScatterTable scatter_table(const ScatterFunction& scatter, int rows_per_decade = 20);

}  // namespace aberfit
