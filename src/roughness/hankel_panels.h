#pragma once
#include <vector>

#include "aberfit/roughness/psd_integrals.h"

namespace aberfit::internal {

/// Argument of J0 beyond which its Hankel amplitude is exact to rounding.
inline constexpr double kHankelFrom = 30;

/// The height variance exists: known from the exponents alone, without integrating.
bool has_finite_height_variance(const RadialPsd& psd);

/// Panels on which S is resolved, good for the Hankel transform at every r in [r_min, r_max].
struct SharedPanels {
  double low = 0;           ///< lower edge of the panels [cycles/m]
  double low_variance = 0;  ///< int S d2f below the panels, where also J0 = 1 to rounding [m^2]
  std::vector<PsdPanel> panels;
};
/// r_min > 0 [m]; S of a finite height variance.
SharedPanels shared_panels(const RadialPsd& psd, double r_min, double r_max);

}  // namespace aberfit::internal
