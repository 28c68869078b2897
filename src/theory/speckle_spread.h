#pragma once
#include <Eigen/Core>
#include <vector>

#include "aberfit/roughness/psd.h"

namespace aberfit::internal {

/// Spread of the light in a disc where the roughness above the cut is so rough that its light is speckle:
///   var E(r) = (lambda F)^2/area int_{disc} [I_h^2 + 2 I_c (I_h - I_h^-)] d2X,  F = f + dz,
/// I_c, I_h, I_h^- the transforms of OTF_low exp(-g^2), OTF_low (exp(-E_rest) - exp(-g^2)) and OTF_low
/// exp(-g^2) (1 - exp(E_rest - g^2)), g^2 = E_rest(infinity), E = wave_number^2 (C(0) - C(x)), OTF_low that
/// of the smooth mirror times exp(-E_low).
class SpeckleSpread {
 public:
  struct Scene {
    double wave_number = 0;  ///< phase per height: 4 pi/lambda, less for a deep mirror [1/m]
    double wavelength = 0;   ///< [m]
    double diameter = 0;     ///< of the aperture [m]
    double area = 0;         ///< [m^2]
    double cycles = 0;       ///< largest 2 r diameter/(lambda F) of all discs
  };
  /// cuts: ascending [cycles/m], all below the top of the band.
  SpeckleSpread(const RadialPsd& psd, const Scene& scene, std::vector<double> cuts);
  const std::vector<double>& cuts() const { return cuts_; }
  /// discs x cuts. transfer: of the smooth mirror at shears of 0, 1, 2, ... times pitch [m]; radius [m];
  /// distance: f + dz [m].
  Eigen::ArrayXXd variance(const Eigen::ArrayXd& transfer, double pitch, double distance,
                           const std::vector<double>& radius) const;

 private:
  Scene scene_;
  std::vector<double> cuts_;
  Eigen::ArrayXd shear_, weight_;  // nodes over the shear x, weight of int dx
  Eigen::ArrayXXd factor_;         // nodes x (1 + 2 cuts): what the smooth OTF is multiplied by
};

}  // namespace aberfit::internal
