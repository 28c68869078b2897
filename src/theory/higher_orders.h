#pragma once
#include <vector>

#include "aberfit/roughness/psd.h"
#include "radial_transform.h"

namespace aberfit::internal {

/// Energy over frequency that a rough patch has scattered more than once: the Hankel transform of
///   T(x) = exp(-g^2) (exp(q) - 1 - q), q = k^2 C(x) = g^2 - E(x), k = 4 pi/lambda,
/// or of exp(-E) where g is infinite. T falls with the square of q: behind a sharp band edge as x^-3, not as
/// x^-3/2.
///
/// Each octave of frequency has its own transform, with T times a taper that ends about 400 cycles of that
/// frequency away. A smooth T far out does not affect high frequencies, but its rounding error would show
/// where the function has fallen by ten decades. From 200 cycles of the highest frequency on, C is that of S
/// (1 - y)^2 (1 + 2 y), y = sin^2(pi f/(2 f_max)), which softens only the edge.
class HigherOrders {
 public:
  /// psd: frequencies below 1/lambda, with a finite structure function; g may be infinite; lowest > 0:
  /// frequency below which nothing needs resolving [cycles/m].
  HigherOrders(const RadialPsd& psd, double wavelength, double g, double lowest);

  /// Energy per d2f [m^2], and energy within f, 0 <= f <= 1/lambda [cycles/m].
  double density(double f) const;
  double within(double f) const;
  double light() const { return light_; }  ///< energy at all frequencies, including those above 1/lambda
  double unresolved() const { return unresolved_; }

 private:
  const RadialTransform& octave(double f) const;

  double wavelength_ = 0, reach_ = 0, light_ = 0, unresolved_ = 0;
  std::vector<RadialTransform> octaves_;  // descending; the first is for (1/2, 1]/lambda
};

/// exp(-g^2) (exp(q) - 1 - q), q = g^2 - e, accurate for small q; exp(-e) where g2 is infinite. e >= 0.
double higher_order_transfer(double g2, double e);

}  // namespace aberfit::internal
