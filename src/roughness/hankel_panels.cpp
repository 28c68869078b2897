#include "hankel_panels.h"

#include <algorithm>
#include <cmath>

#include "aberfit/core/constants.h"

namespace aberfit::internal {

namespace {

// Returns whether int S f^(power + 1) df exists at f = 0 and int S f df at infinity.
bool integrable(const RadialPsd& psd, double power) {
  for (const PowerTerm& term : psd.low_frequency_terms())
    if (!(term.exponent < 2 + power)) return false;
  for (const PowerTerm& term : psd.high_frequency_terms())
    if (!(term.exponent > 2)) return false;
  return true;
}

}  // namespace

bool has_finite_height_variance(const RadialPsd& psd) { return integrable(psd, 0); }
bool has_finite_structure_function(const RadialPsd& psd) { return integrable(psd, 2); }

SharedPanels shared_panels(const RadialPsd& psd, double r_min, double r_max) {
  const PowerLawLimits limits = power_law_limits(psd);
  const double low = psd.f_min() > 0 ? psd.f_min() : std::min(limits.low, 1e-9 / (2 * kPi * r_max));
  // Above `high`, either the oscillation averages S out or S is zero.
  const double high =
      std::isinf(psd.f_max()) ? std::max(limits.high, 1e9 * kHankelFrom / (2 * kPi * r_min)) : limits.high;
  return {low, psd.f_min() > 0 ? 0 : radial_moment(psd, 0, 0, low), resolved_panels(psd, low, high)};
}

}  // namespace aberfit::internal
