#pragma once
#include <Eigen/Core>
#include <string>
#include <vector>

#include "aberfit/roughness/psd.h"
#include "aberfit/roughness/psd_table.h"
#include "aberfit/spectrum/psd_model_fit.h"

namespace aberfit::internal {

/// A parametric PSD of the kind of the data: S2 [m^4] of maps, S1 [m^3] of profiles. Internal parameters
/// theta, one part after another:
///   k-correlation  log S(pivot), log B, log exponent   (of the data: one less for profiles)
///   power law      log S(pivot), exponent              (2-D; it may be zero or negative, so no log)
///   uniform, floor log S(pivot)
/// The level at a pivot inside the band replaces the amplitude. It stays determined when B is not, and it is
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

/// Ranges of the parameters: knees from 1/50 to 50 times the band, exponents up to 16. Beyond, a shape cannot
/// be distinguished from its limit. floor_level: smallest significant floor [m^3 or m^4].
struct PsdShapeBounds {
  Eigen::VectorXd lower, upper;
};
PsdShapeBounds shape_bounds(const PsdShape& shape, double floor_level);

/// A reported parameter of the surface: offset + exp(coordinate) if logarithmic, otherwise offset +
/// coordinate. gradient: d coordinate / d theta.
struct PsdShapeParameter {
  std::string name, unit;
  bool logarithmic = true;
  double offset = 0;
  double coordinate = 0;
  Eigen::VectorXd gradient;
  int internal = -1;  ///< index in theta if the coordinate is that parameter

  double natural(double at) const;
};
std::vector<PsdShapeParameter> shape_parameters(const PsdShape& shape, const Eigen::VectorXd& theta);

/// Returns the two-dimensional model in the band, without the floor of a profile.
PsdModel surface_model(const PsdShape& shape, const Eigen::VectorXd& theta);

}  // namespace aberfit::internal
