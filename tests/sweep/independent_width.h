#pragma once
#include <functional>
#include <optional>

namespace aberfit {

struct IndependentWidth {
  double fwhm;
  double per_light;  ///< error of the width if every value of the curve has an error of one
};

/// Full width at half maximum of a curve that can only be evaluated, between the half crossings nearest to
/// the highest peak. Written anew for the tests. The curve is sampled in steps of a sixth of `expected`, as
/// far as `expected` on either side of 0; then parabola and false position follow: 1e-4 of a smooth curve's
/// width. Returns nothing if the peak or a half crossing is not within two of `expected`.
std::optional<IndependentWidth> independent_width(const std::function<double(double)>& curve,
                                                  double expected);

}  // namespace aberfit
