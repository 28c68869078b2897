#pragma once
#include <Eigen/Core>
#include <optional>
#include <vector>

#include "aberfit/roughness/psd.h"
#include "aberfit/theory/aperture_otf.h"

namespace aberfit::internal {

/// Spread of the encircled energy by pairs of different frequencies. The frequency f moves energy that lower
/// frequencies have scattered by lambda F f, F = f_focal + dz, across the edge of a disc. If the frequencies
/// become known one by one, from the lowest on, E(r) is a martingale, so their contributions to var E(r) add.
/// That of f is 2 pi f S(f) df times
///   M(f) = (k^2/area) int [K I_h I_h' + (I_c I_h' + I_h I_c')/2] (|p - p'| - |e|)^2 d2q,  k = 4 pi/lambda,
/// at q = X/(lambda F) [cycles/m]; primed quantities are at q - f. I_c is the mean irradiance [per d2q] that
/// the frequencies below f leave unscattered, I_h the one they scatter. p(q) is the probability that energy
/// at q lands in the disc after the scatter by frequencies above f. Fields count as Gaussian (fully developed
/// speckle; Goodman, Speckle Phenomena in Optics, 2007, 6.1). In focus every q receives waves from all of the
/// aperture, and the correlation area in q is 1/area. Energy that moves within the disc, or outside it, does
/// not count; the loss of one point is the gain of another.
///
/// K: out of focus, energy at q comes from a patch of the aperture. Smaller patches make larger and fewer
/// speckles. With W(P, q) the irradiance at q from the point P of the aperture, two points q and q' interfere
/// as int W(P, q) W(P, q') dP (Parseval); that is I_h I_h'/area where W does not depend on P. The mirror's
/// aberration moves the scatter, W(P, q) = B(q - g(P))/area. Over all q the first integral is int B B'
/// d2q/area and the second int I_h I_h' d2q/area, with the ratio
///   K(f) = int T^2 OTF_focus^2 J0(2 pi f x) d2x/int T^2 OTF^2 J0(2 pi f x) d2x.
/// T is the mean transfer function of the frequencies below f, without their core. K is 1 in focus.
///
/// e, the mean of p - p' over I_c + I_h, is a shift of the whole spot. Only a frequency with itself causes
/// one, and the periodogram term of RealisationSpread holds it. I_c counts by the factor 1 - int |OTF|^2/int
/// |OTF in focus|^2, with OTF that of the mirror without roughness: a perfect focus moves as a whole. The
/// factor 1/2 is measured on the spreads of RealisationSpread: 98 % are within a factor 1.5; factors of 1 and
/// 2 give 98 % and 96 %. I_c I_c' is no pair of frequencies but the response to one, linear in the heights.
///
/// Energy farther from the axis than 400 cycles across the aperture, or than 2.5 radii of the largest disc
/// plus ten cycles across, is left out.
class ScrambledLight {
 public:
  struct Scene {
    double wave_number = 0;  ///< k, less for a deep mirror [1/m]
    double wavelength = 0;   ///< [m]
    double diameter = 0;     ///< of the aperture [m]
    double area = 0;         ///< [m^2]
    double largest = 0;      ///< radius of the largest disc over lambda F [cycles/m]
  };
  /// low, high: ends of the band [cycles/m]; perfect: transfer function of the aperture.
  ScrambledLight(const RadialPsd& psd, const Scene& scene, const ApertureOtf& perfect, double low,
                 double high);
  /// M [m^-2], frequencies x discs. transfer: that of the smooth mirror at shears of 0, 1, 2, ... times pitch
  /// [m]; distance: F [m]; radius [m].
  Eigen::ArrayXXd operator()(const Eigen::ArrayXd& frequency, const Eigen::ArrayXd& transfer, double pitch,
                             double distance, const std::vector<double>& radius) const;
  /// Sum over frequencies of weight times M for pairs of discs, discs x discs. The product of the two discs'
  /// differences replaces (|p - p'| - |e|)^2: energy that moves across both edges counts for both.
  Eigen::MatrixXd covariance(const Eigen::ArrayXd& frequency, const Eigen::ArrayXd& weight,
                             const Eigen::ArrayXd& transfer, double pitch, double distance,
                             const std::vector<double>& radius) const;

 private:
  // Position on the grid of radii of the points q - f, for points q on rings.
  struct Moved {
    Eigen::Index index;
    double part, radius;
  };
  void set_shears(double reach);
  void set_radii(double reach);
  std::vector<Moved> moved(double f) const;
  // The mean irradiance that the frequencies below each of frequency_ leave and scatter.
  struct Light {
    Eigen::VectorXd perfect;    // unscattered, without the factor core_below_
    Eigen::MatrixXd scattered;  // radii x f
    Eigen::ArrayXd patch;       // K, one per f
  };
  Light light(const Eigen::ArrayXd& transfer, double pitch) const;
  Eigen::ArrayXd patches(const Eigen::ArrayXd& smooth) const;
  Eigen::ArrayXd smooth(const Eigen::ArrayXd& transfer, double pitch) const;  // at the shears
  Eigen::MatrixXd landing(
      double rim) const;  // probability that energy at a radius lands in the disc: radii x f
  static double at(const Moved& point, const Eigen::Ref<const Eigen::VectorXd>& values);
  // k^2/area times both irradiances, at the points of frequency j and those that it moves to.
  Eigen::ArrayXd pairs(std::size_t j, const Light& light) const;
  // |p - p'| - |e| at these points, for one disc.
  Eigen::ArrayXd differences(std::size_t j, const Light& light,
                             const Eigen::Ref<const Eigen::VectorXd>& landing, double rim) const;
  // Position of a frequency among frequency_.
  struct Among {
    Eigen::Index low = 0, high = 0;
    double part = 0;
  };
  std::optional<Among> among(double frequency) const;

  Scene scene_;
  std::vector<double> frequency_;  // frequencies at which M is computed, ascending
  Eigen::ArrayXd shear_, weight_;  // nodes over the shear x, weights of int 2 pi x dx
  Eigen::ArrayXd focal_;           // transfer function of the perfect focus at the nodes
  Eigen::ArrayXd radius_, ring_;   // grid over |q| and weights of int d2q
  Eigen::MatrixXd bessel_;         // J0(2 pi q x): radii x shears
  Eigen::MatrixXd below_,
      above_;  // transfer functions, without core, of the frequencies below and above: shears x f
  Eigen::ArrayXd core_below_, core_;  // exp(-g^2) of the frequencies below and above
  std::vector<std::vector<Moved>> moved_;
};

}  // namespace aberfit::internal
