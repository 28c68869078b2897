#pragma once
#include <functional>
#include <optional>

namespace aberfit {

struct IndependentWidth {
  double fwhm;
  double per_light;  ///< by how much it is off where each value of the curve is, by one unit
};

/// Full width at half maximum of a curve of which only values are known, between the half crossings nearest
/// to the highest peak; written anew for the tests. Sampled at sixths of `expected` as far as that to either
/// side of 0, from there on by parabola and by false position: 1e-4 of a smooth curve's width. Nothing where
/// the peak, or a half on either side of it, is not within two of `expected`.
std::optional<IndependentWidth> independent_width(const std::function<double(double)>& curve,
                                                  double expected);

}  // namespace aberfit
