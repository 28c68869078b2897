#pragma once
#include <vector>

#include "aberfit/roughness/psd.h"
#include "radial_transform.h"

namespace aberfit::internal {

/// Light of a rough patch that has been scattered more than once, over frequency: the Hankel transform of
/// T(x) = exp(-g^2) (exp(q) - 1 - q), q = k^2 C(x) = g^2 - E(x), k = 4 pi/lambda. Where g is infinite, of
/// exp(-E). T falls with the square of q: behind a sharp band edge as x^-3, where the whole would as x^-3/2.
///
/// Each octave of frequency has its own transform, of T times a taper that ends some 400 cycles of that
/// frequency away: a smooth T far out has nothing to say at high frequencies, and left in would leave its
/// rounding where the function has fallen by ten decades. From 200 cycles of the highest frequency on C is
/// that of S (1 - y)^2 (1 + 2 y), y = sin^2(pi f/(2 f_max)): the edge softened, the rest as it was.
class HigherOrders {
 public:
  /// psd: frequencies below 1/lambda of a finite structure function; g may be infinite; lowest > 0: frequency
  /// below which there is nothing to resolve [cycles/m].
  HigherOrders(const RadialPsd& psd, double wavelength, double g, double lowest);

  /// Light per d2f [m^2], and within f, 0 <= f <= 1/lambda [cycles/m].
  double density(double f) const;
  double within(double f) const;
  double light() const { return light_; }  ///< at all frequencies, those above 1/lambda included
  double unresolved() const { return unresolved_; }

 private:
  const RadialTransform& octave(double f) const;

  double wavelength_ = 0, reach_ = 0, light_ = 0, unresolved_ = 0;
  std::vector<RadialTransform> octaves_;  // the one of (1/2, 1]/lambda first
};

/// exp(-g^2) (exp(q) - 1 - q), q = g^2 - e, without losing the digits of a small q; exp(-e) where g2 is
/// infinite. e >= 0.
double higher_order_transfer(double g2, double e);

}  // namespace aberfit::internal
