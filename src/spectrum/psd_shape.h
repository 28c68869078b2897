#pragma once
#include <Eigen/Core>
#include <string>
#include <vector>

#include "aberfit/roughness/psd.h"
#include "aberfit/roughness/psd_table.h"
#include "aberfit/spectrum/psd_model_fit.h"

namespace aberfit::internal {

/// A parametric PSD as it is fitted, of the kind of the data: S2 [m^4] of maps, S1 [m^3] of profiles.
/// Internal parameters theta, part after part of the family:
///   k-correlation  log S(pivot), log B, log exponent   (the exponent of the data: profiles have one less)
///   power law      log S(pivot), exponent              (the 2-D one; it may be zero or negative, so no log)
///   uniform, floor log S(pivot)
/// The level at a pivot inside the band instead of the amplitude: it stays determined when B is not, and is
/// hardly correlated with the exponent.
struct PsdShape {
  PsdFamily family = PsdFamily::kUniform;  ///< not kAuto
  PsdTableKind kind = PsdTableKind::k2dTwoSided;
  double f_min = 0, f_max = 0;  ///< band of the data [cycles/m], 0 < f_min < f_max
  double pivot() const;         ///< sqrt(f_min f_max)
};

int parameter_count(const PsdShape& shape);

/// S and its derivatives at frequencies f > 0. derivative: frequencies x parameters.
struct PsdShapeValues {
  Eigen::ArrayXd value;
  Eigen::MatrixXd derivative;
};
PsdShapeValues shape_values(const PsdShape& shape, const Eigen::VectorXd& theta, const Eigen::ArrayXd& f);

/// Range in which the parameters are looked for: knees from 1/50 of the band to 50 times, exponents up to 16;
/// beyond, the shape cannot be told from its limit. floor_level: least floor worth having [m^3 or m^4].
struct PsdShapeBounds {
  Eigen::VectorXd lower, upper;
};
PsdShapeBounds shape_bounds(const PsdShape& shape, double floor_level);

/// One number that is reported, in surface terms: offset + exp(coordinate) when logarithmic, else offset +
/// coordinate, with the gradient of the coordinate over theta.
struct PsdShapeParameter {
  std::string name, unit;
  bool logarithmic = true;
  double offset = 0;
  double coordinate = 0;
  Eigen::VectorXd gradient;
  int internal = -1;  ///< index in theta when the coordinate is that very parameter

  double natural(double at) const;
};
std::vector<PsdShapeParameter> shape_parameters(const PsdShape& shape, const Eigen::VectorXd& theta);

/// The two-dimensional model in the band; the floor of a profile is left out.
PsdModel surface_model(const PsdShape& shape, const Eigen::VectorXd& theta);

}  // namespace aberfit::internal
