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
/// smoothing of any aperture: generalised Harvey-Shack in direction cosines (Krywonos, Harvey and Choi 2011;
/// PHYSICS 6 and 10), from H(x) = exp(-(4 pi/lambda)^2 (C(0) - C(x))). With f = sin(theta)/lambda,
/// k = 4 pi/lambda, g^2 = k^2 C(0) over the frequencies below 1/lambda (scattering_band):
///   BSDF(theta) = (K/lambda^2) [exp(-g^2) k^2 S(f) + 2 pi int exp(-g^2) (exp(k^2 C) - 1 - k^2 C) J0(2 pi f
///   x) x dx].
/// The first part is one scattering (Rayleigh-Rice without polarisation, times exp(-g^2)), exact and with the
/// sharp edges of the band; the second all higher orders, which is what the Hankel transform is left with.
/// K makes up for orders that would leave beyond 90 degrees: K = TIS over the light that the bracket sends
/// below them, so that the integral of BSDF cos(theta) over the hemisphere is TIS = 1 - exp(-g^2). Where K is
/// not close to 1 scalar theory does not hold (theory_error).
///
/// BSDF is per unit of direction-cosine area, the ASF per solid angle is BSDF cos(theta); the specular light
/// exp(-g^2) is in neither. Reflectance 1; no polarisation and no obliquity factor, as in the focus.
///
/// Error of the higher orders, beside the first: their kinks (at sums and differences of sharp band edges,
/// the middle among them) are rounded over 0.5 % of their frequency and the edge of the highest frequency
/// over as much, 5e-4 of them near kinks (test BeyondTheBandIsTheSecondOrder); 1e-11 of the light per octave
/// of angle is what is left of the precision where the function has fallen far. Integral against TIS: below
/// 1e-7 for g = 0.01-5 and six PSDs. Const use from many threads.
class ScatterFunction {
 public:
  /// rest: what is left to scatter, any RadialPsd, also one that is zero; wavelength > 0 [m]. Throws
  /// ComputationError where the structure function is infinite (PSDs as steep as f^-4 at f = 0). Costs tenths
  /// of a second, seconds of a table of a thousand points or of several sharp edges inside the band.
  ScatterFunction(const RadialPsd& rest, double wavelength);

  /// [1/sr] at theta [rad], |theta| <= pi/2; infinite at 0 where S is.
  double bsdf(double theta) const;
  double asf(double theta) const;
  /// Share of all light that is scattered to within theta of the specular direction; `tis` at pi/2.
  double within(double theta) const;

  double wavelength() const { return wavelength_; }    ///< [m]
  const RadialPsd& psd() const { return psd_; }        ///< the frequencies that scatter
  double rms_height() const { return rms_height_; }    ///< of them [m]; infinite where the variance diverges
  double rms_slope() const { return rms_slope_; }      ///< of them, per axis
  double g() const { return g_; }                      ///< 4 pi rms_height/lambda
  double tis() const { return tis_; }                  ///< 1 - exp(-g^2)
  double cut_share() const { return cut_share_; }      ///< of the height variance, above 1/lambda
  double renormalisation() const { return renorm_; }   ///< K
  double lowest_sine() const { return lowest_sine_; }  ///< below it the function is flat, or S a power
  /// Largest part of the higher orders that the panels could not resolve; 0 as a rule.
  double unresolved() const;

 private:
  double bracket(double f) const;  // of the formula above [m^2]

  RadialPsd psd_;
  double wavelength_ = 0, rms_height_ = 0, rms_slope_ = 0, g_ = 0, tis_ = 0, core_ = 1, cut_share_ = 0;
  double renorm_ = 1, lowest_sine_ = 0;
  std::vector<double> knots_,
      variance_below_;  // [cycles/m], int S d2f below each [m^2]; empty without a core
  std::shared_ptr<const internal::HigherOrders> higher_;  // null without roughness
};

/// A scatter function in numbers: one row per angle, ascending, and what it is the function of.
struct ScatterTable {
  Eigen::ArrayXd theta;         ///< [rad]; 0 first (unless infinite there), pi/2 last
  Eigen::ArrayXd asf_per_sr;    ///< scattered light per solid angle [1/sr]
  Eigen::ArrayXd bsdf_per_sr;   ///< asf / cos(theta) [1/sr]
  Eigen::ArrayXd tis_within;    ///< share of all light scattered to within theta
  double wavelength = 0;        ///< [m]
  double tis = 0;               ///< 1 - exp(-g^2), the last of tis_within
  double rms_height = 0;        ///< of the frequencies that scatter [m]
  double rms_slope = 0;         ///< of them, per axis
  double g = 0;                 ///< 4 pi rms_height / wavelength
  double f_min = 0, f_max = 0;  ///< band that scatters [cycles/m]; f_max at most 1/wavelength
  double cut_share = 0;         ///< share of the height variance above 1/wavelength, which does not scatter
  double renormalisation = 1;   ///< factor K on the function for orders beyond 90 degrees
};

/// Rows at log-spaced sines, at least `rows_per_decade` (1 or more) of them from the lowest of interest (a
/// hundredth of f_min; where the band starts at 0, a thousandth of the angle that the deciding lags give) to
/// 90 degrees, and at every bend of S. A jump of S lies between two rows at 1e-6 of its sine below and above.
/// Elsewhere rows are halved, up to eight times, until log-log interpolation of the BSDF keeps 1e-3 in their
/// middle (where it is above 1e-4 of its largest value) and its light between them is right to 3e-6 of the
/// TIS. tis_within is exact at the rows: between them it goes nearly linearly with the square of the sine,
/// which is what to draw angles by.
ScatterTable scatter_table(const ScatterFunction& scatter, int rows_per_decade = 20);

}  // namespace aberfit
