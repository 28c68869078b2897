#pragma once
#include <Eigen/Core>
#include <optional>
#include <vector>

#include "aberfit/roughness/psd.h"
#include "aberfit/theory/aperture_otf.h"

namespace aberfit::internal {

/// Spread by pairs of different frequencies: light that those below f have spread, the frequency f moves by
/// lambda F f, F = f_focal + dz, across the edge of a disc. Frequencies made known one after the other, from
/// the lowest on, are a martingale, so that their shares of var E(r) add; that of f is 2 pi f S(f) df times
///   M(f) = (k^2/area) int [K I_h I_h' + (I_c I_h' + I_h I_c')/2] (|p - p'| - |e|)^2 d2q,  k = 4 pi/lambda,
/// at q = X/(lambda F) [cycles/m], primed at q - f: I_c the mean irradiance [per d2q] that the frequencies
/// below f leave unscattered, I_h what they scatter, p(q) the probability of light at q to be in the disc
/// after those above f. Fields count as Gaussian (fully developed speckle; Goodman, Speckle Phenomena in
/// Optics, 2007, 6.1). In focus light at every q comes from all of the aperture, and its correlation area in
/// q is 1/area. Light that moves within the disc, or outside it, does not count, and what one loses the other
/// gains.
///
/// K: away from the focus light at q comes from a patch of the aperture, and where patches are smaller,
/// speckles are larger and fewer. With W(P, q) the irradiance at q from the point P of the aperture, two
/// points q and q' interfere as int W(P, q) W(P, q') dP (Parseval), which is I_h I_h'/area where W does not
/// depend on P. The aberration of the mirror moves what the roughness spreads, W(P, q) = B(q - g(P))/area, so
/// that over all q the first is int B B' d2q/area and the second int I_h I_h' d2q/area: their ratio is
///   K(f) = int T^2 OTF_focus^2 J0(2 pi f x) d2x/int T^2 OTF^2 J0(2 pi f x) d2x,
/// T the mean transfer function that the frequencies below f have without their core. 1 in focus; without it
/// the spread is half of that of draws where the defocus is five times the spot (uniform PSD, g = 2).
///
/// e, the mean of p - p' over I_c + I_h, is a shift of the whole spot: only a frequency with itself does
/// that, and the periodogram's term of RealisationSpread holds it. I_c counts as far as aberration spreads
/// it: by the factor 1 - int |OTF|^2/int |OTF in focus|^2, OTF of the mirror without roughness; a perfect
/// focus moves as a whole. The half is measured: of the spreads described at RealisationSpread it puts 98.2 %
/// within a factor 1.5 of the draws, 1 in its place 97.9 %, 2 95.9 %. I_c I_c' is no pair of frequencies, but
/// the answer to one, linear in the heights.
///
/// Light farther from the axis than 400 cycles across the aperture, or 2.5 radii of the largest disc, is left
/// out.
class ScrambledLight {
 public:
  struct Scene {
    double wave_number = 0;  ///< k, less for a deep mirror [1/m]
    double wavelength = 0;   ///< [m]
    double diameter = 0;     ///< of the aperture [m]
    double area = 0;         ///< [m^2]
    double largest = 0;      ///< radius of the largest disc over lambda F [cycles/m]
  };
  /// low, high: of the band [cycles/m]; perfect: transfer function of the aperture.
  ScrambledLight(const RadialPsd& psd, const Scene& scene, const ApertureOtf& perfect, double low,
                 double high);
  /// M at frequencies [m^-2], frequencies x discs. transfer: of the smooth mirror at shears of 0, 1, 2, ...
  /// times pitch [m]; distance: F [m]; radius [m].
  Eigen::ArrayXXd operator()(const Eigen::ArrayXd& frequency, const Eigen::ArrayXd& transfer, double pitch,
                             double distance, const std::vector<double>& radius) const;
  /// sum over frequencies of weight times M of pairs of discs, (|p - p'| - |e|)^2 replaced by the product of
  /// the two discs' own differences: light that moves across both edges counts for both. discs x discs.
  Eigen::MatrixXd covariance(const Eigen::ArrayXd& frequency, const Eigen::ArrayXd& weight,
                             const Eigen::ArrayXd& transfer, double pitch, double distance,
                             const std::vector<double>& radius) const;

 private:
  // Points q - f, seen from the points q on rings: where they lie on the grid of radii.
  struct Moved {
    Eigen::Index index;
    double part, radius;
  };
  void set_shears(double reach);
  void set_radii(double reach);
  std::vector<Moved> moved(double f) const;
  // The mean irradiance by what the frequencies below each of frequency_ leave and spread.
  struct Light {
    Eigen::VectorXd perfect;    // unscattered, without its core_below_
    Eigen::MatrixXd scattered;  // radii x f
    Eigen::ArrayXd patch;       // K, one per f
  };
  Light light(const Eigen::ArrayXd& transfer, double pitch) const;
  Eigen::ArrayXd patches(const Eigen::ArrayXd& smooth) const;
  Eigen::ArrayXd smooth(const Eigen::ArrayXd& transfer, double pitch) const;  // at the shears
  Eigen::MatrixXd landing(
      double rim) const;  // probability of light at a radius to land in the disc: radii x f
  static double at(const Moved& point, const Eigen::Ref<const Eigen::VectorXd>& values);
  // Of the points of frequency j and those that it moves to: k^2/area times the light of both.
  Eigen::ArrayXd pairs(std::size_t j, const Light& light) const;
  // |p - p'| - |e| there, of a disc.
  Eigen::ArrayXd differences(std::size_t j, const Light& light,
                             const Eigen::Ref<const Eigen::VectorXd>& landing, double rim) const;
  // Where a frequency lies among frequency_.
  struct Among {
    Eigen::Index low = 0, high = 0;
    double part = 0;
  };
  std::optional<Among> among(double frequency) const;

  Scene scene_;
  std::vector<double> frequency_;  // where M is computed, ascending
  Eigen::ArrayXd shear_, weight_;  // nodes over the shear x, weight of int 2 pi x dx
  Eigen::ArrayXd focal_;           // transfer function of the perfect focus there
  Eigen::ArrayXd radius_, ring_;   // grid over |q| and weight of int d2q
  Eigen::MatrixXd bessel_;         // J0(2 pi q x): radii x shears
  Eigen::MatrixXd below_,
      above_;  // transfer functions without core of the frequencies below and above: shears x f
  Eigen::ArrayXd core_below_, core_;  // exp(-g^2) of the frequencies below and above
  std::vector<std::vector<Moved>> moved_;
};

}  // namespace aberfit::internal
