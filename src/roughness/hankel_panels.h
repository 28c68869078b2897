#pragma once
#include <vector>

#include "aberfit/roughness/psd_integrals.h"

namespace aberfit::internal {

/// Argument of J0 beyond which its Hankel amplitude is exact to rounding.
inline constexpr double kHankelFrom = 30;

/// Returns whether the height variance exists; the exponents decide, without integration.
bool has_finite_height_variance(const RadialPsd& psd);
/// Returns whether the structure function exists: S must rise more slowly than f^-4 towards f = 0, where 1 -
/// J0 vanishes as f^2, and fall faster than f^-2 towards infinity.
bool has_finite_structure_function(const RadialPsd& psd);

/// Panels on which S is resolved, for the Hankel transform at every r in [r_min, r_max].
struct SharedPanels {
  double low = 0;           ///< lower edge of the panels [cycles/m]
  double low_variance = 0;  ///< int S d2f below the panels, where J0 = 1 to rounding [m^2]; may be infinite
  std::vector<PsdPanel> panels;
};
/// r_min > 0 [m]; S must have a finite structure function.
SharedPanels shared_panels(const RadialPsd& psd, double r_min, double r_max);

}  // namespace aberfit::internal
