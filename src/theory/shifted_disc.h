#pragma once
#include <Eigen/Core>

#include "aberfit/core/quadrature.h"
#include "aberfit/theory/generalised_harvey_shack.h"

namespace aberfit::internal {

/// Light of a mean spot in discs away from its axis, from a table of its encircled energy.
class ShiftedDisc {
 public:
  /// core: radius of the order of the spot's finest detail [m]; reach: largest distance from the axis [m].
  ShiftedDisc(const MeanSpot& spot, double core, double reach);
  /// Light in a disc of `radius` whose centre is `shift` from the axis [m]:
  ///   (1/2 pi) oint E(rho)/rho^2 (X . n) ds
  /// around its edge, by Gauss's theorem. Error about 1e-3 of E(radius) (linear interpolation of E/rho^2).
  double operator()(double radius, double shift) const;

 private:
  double mean_irradiance(double rho) const;  // E(rho)/rho^2

  Quadrature rule_;
  double core_;
  Eigen::ArrayXd table_;  // over asinh(rho/core)
  double end_ = 0, light_ = 0;
};

}  // namespace aberfit::internal
